"""Static rules and equilibrium on a deck with edges: closed forms, and a deck made of an item."""

from dataclasses import replace

import numpy as np
import pytest

from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.model.deviations import deviated
from steadyload.layouts.model.scenarios import Scenario, apply_scenario
from steadyload.layouts.model.snapping import snap
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods.registry import make_method
from steadyload.methods.session.session import LoadingSession
from steadyload.methods.uncertainty import parse_uncertainty
from steadyload.runs.verdict_reliability import Sampling, verdict_reliability
from steadyload.statics.margins import margins

PALLET = Pallet(100.0, 200.0, 100.0, overhang=30.0)
BALANCE = ("sme", "equilibrium", "equilibrium:sides=frictionless", "equilibrium:sides=friction")


def box(sequence, x, y, width, height, weight=10.0, *, z=10.0, depth=20.0, offset=0.0):
    return Item(sequence, (x, y, z), (width, height, depth), weight, (offset, 0.0, 0.0))


def scores(items, *methods, pallet=PALLET):
    layout = Layout("deck", pallet, tuple(items))
    return [make_method(method).judge(layout).score for method in methods]


@pytest.mark.parametrize("edge", ["left", "right"])
@pytest.mark.parametrize("offset", [0.0, 4.0])
def test_a_box_stands_while_its_centre_of_mass_is_above_the_deck(edge, offset):
    for inside, stands in ((0.1, 1.0), (0.0, 1.0), (-0.1, 0.0)):
        x, shift = inside - 10.0 - offset, offset
        if edge == "right":
            x, shift = 100.0 - x - 20.0, -shift
        item = box(0, x, 0.0, 20.0, 15.0, offset=shift)
        assert scores([item], *BALANCE) == [stands] * len(BALANCE)
        # Exactly above the edge it balances, without a margin: fragile.
        margin = margins(Layout("deck", PALLET, (item,)))[0]
        assert margin.patches == pytest.approx(inside, abs=1e-5)
        assert margin.centres == pytest.approx(inside, abs=1e-6)


def test_who_stands_exactly_above_the_edge_is_fragile():
    """Deviations from the plan tell: half of them fall, on the deck that the plan has."""
    for inside, low, high in ((0.0, 0.4, 0.6), (1.0, 0.99, 1.0), (-1.0, 0.0, 0.01)):
        item = box(0, inside - 10.0, 0.0, 20.0, 15.0)
        found = verdict_reliability(
            make_method("equilibrium"),
            Layout("deck", PALLET, (item,)),
            parse_uncertainty("position=2mm"),
            Sampling(most=256),
        )
        assert low <= found.stands <= high


def test_the_limit_of_the_overhang_stops_no_item():
    """What a plan may ask for is limited; where an item comes to lie is not."""
    item = box(0, -10.0, 0.0, 20.0, 15.0)
    stands = [
        verdict_reliability(
            make_method("equilibrium"),
            Layout("deck", replace(PALLET, overhang=limit), (item,)),
            parse_uncertainty("position=2mm"),
            Sampling(most=64),
        ).stands
        for limit in (10.0, 30.0)
    ]
    assert stands[0] == stands[1] < 0.7


def test_a_deviation_to_within_the_edges_leaves_the_floor_a_deck():
    plan = Layout("deck", PALLET, (box(0, -0.05, 0.0, 20.0, 15.0), box(1, 50.0, 0.0, 9.0, 9.0)))
    places = np.full((2, 2, 6), 0.5)
    places[0, 0, 3], places[1, 0, 3] = 0.999, 0.001
    inward, outward = deviated(plan, places, place=2.0)
    assert inward.lower[0, 0] > 0.0
    assert outward.lower[0, 0] < -5.0
    assert inward.floor == outward.floor == plan.floor
    # On a plane nothing is moved over the edge.
    [plane] = deviated(plan.on("infinite"), places[1:], place=2.0)
    assert plane.lower[0, 0] == -0.05


def test_base_support_counts_the_deck_and_nothing_beyond_it():
    # 7 of 20 cm overhang: 65 % of the base is on the deck.
    item = box(0, -7.0, 0.0, 20.0, 15.0)
    assert scores([item], "fbs", "pbs:alpha=0.64", "pbs:alpha=0.66") == [0.0, 1.0, 0.0]
    [verdict] = make_method("fbs").judge_many([Layout("deck", PALLET, (item,))])
    assert verdict.reason == "65.0% of its base is supported; required: 100.0%"
    assert scores([item], "fbs", pallet=replace(PALLET, floor="infinite")) == [1.0]


def test_nothing_carries_beside_the_deck():
    beside = box(0, -25.0, 0.0, 20.0, 15.0)
    assert scores([beside], "fbs", "pbs:alpha=0.1", *BALANCE) == [0.0] * (2 + len(BALANCE))
    [verdict] = make_method("sme").judge_many([Layout("deck", PALLET, (beside,))])
    assert verdict.reason == "nothing supports it"
    # Held by a neighbour's top, it stands; items on it are asked about as anywhere.
    plank = box(1, -25.0, 15.0, 60.0, 5.0, 8.0)
    block = box(0, 0.0, 0.0, 30.0, 15.0)
    assert scores([block, plank], *BALANCE) == [1.0] * len(BALANCE)
    assert scores([block, plank], "fbs") == [0.5]


@pytest.mark.parametrize("method", BALANCE)
@pytest.mark.parametrize("counterweight", [None, 2.0, 10.0])
def test_a_load_on_an_overhanging_end_is_held_by_a_counterweight(method, counterweight):
    # A board of 30 cm and 10 kg overhangs by 10 cm: its moment about the edge is 10 x 5. A load
    # above the end pulls with 5 cm, a counterweight on the other end holds with 15 cm.
    board = box(0, -10.0, 0.0, 30.0, 5.0)
    most = (10.0 * 5.0 + (counterweight or 0.0) * 15.0) / 5.0
    for load, stands in ((0.999 * most, True), (1.001 * most, False)):
        items = [board]
        if counterweight is not None:
            items.append(box(1, 10.0, 5.0, 10.0, 10.0, counterweight))
        items.append(box(len(items), -10.0, 5.0, 10.0, 10.0, load))
        expected = 1.0 if stands else (len(items) - 1) / len(items)
        assert scores(items, method) == [pytest.approx(expected)]


def test_a_cantilever_is_held_down_by_what_is_on_it():
    # The board's own centre of mass is 5 cm past the edge, that of the box on it 5 cm inside.
    for weight, sign in ((9.9, -1), (10.1, 1)):
        items = (box(0, -20.0, 0.0, 30.0, 5.0), box(1, 0.0, 5.0, 10.0, 10.0, weight))
        before, after = margins(Layout("deck", PALLET, items))
        assert before.patches == pytest.approx(-5.0, abs=1e-5)
        # The box stands with all its base, so that nothing but the edge is short of length.
        assert np.sign(after.patches) == sign
    # A box over the outer end of that board reaches the deck's edge through it alone.
    items = (*items, box(2, -20.0, 5.0, 10.0, 10.0, 1.0))
    assert margins(Layout("deck", PALLET, items))[2].patches < 0.0


def test_time_tells_how_far_a_box_tips_over_the_edge():
    # 1 mm past the edge: 10 degrees after 0.69 s (tests/conformance/test_deck.py has the formula).
    item = box(0, -20.1, 0.0, 40.0, 30.0)
    assert scores([item], "equilibrium", "equilibrium:time=0.3", "equilibrium:time=1") == [0, 1, 0]
    # What falls is stopped by the ground 14.4 cm below, and not by anything at the deck's height.
    beside = [box(0, -25.0, 0.0, 20.0, 15.0)]
    wide = "equilibrium:time=0.3,eps_t={},eps_r=90"
    assert scores(beside, wide.format(14.0), wide.format(16.0)) == [0.0, 1.0]
    flat = replace(PALLET, deck_height=5.0)
    assert scores(beside, "equilibrium:time=0.3", pallet=flat) == [1.0]


@pytest.mark.parametrize(
    "method",
    ["fbs", "pbs:alpha=0.6", *BALANCE, "equilibrium:time=0.3"],
)
def test_a_deck_is_what_a_heavy_item_of_its_size_is(method):
    """Verdicts on a deck are those on a plane with the deck as the first item on it."""
    judges, differ, late = make_method(method), 0, 0
    for number, layout in enumerate(random_layouts(24, seed=8)):
        plan = apply_scenario(layout, Scenario.S2A, seed=2)
        short = (0.55, 0.7, 0.85)[number % 3] * plan.pallet.width
        pallet = replace(plan.pallet, width=short, overhang=100.0, floor="deck")
        items = plan.items
        deck = Item(0, (0.0, 0.0, 0.0), (pallet.width, 14.4, pallet.depth), 100.0)
        lifted = [
            replace(i, sequence=i.sequence + 1,
                    position=(i.position[0], i.position[1] + 14.4, i.position[2]))
            for i in items
        ]  # fmt: skip
        plane = replace(pallet, height=pallet.height + 14.4, floor="infinite")
        found = judges.judge(Layout("deck", pallet, tuple(items))).failing_step
        expected = judges.judge(Layout("item", plane, (deck, *lifted))).failing_step
        assert found == (None if expected is None else expected - 1)
        before = judges.judge(plan).failing_step
        differ += before != found
        late += found is None or found > 0
    assert differ > 4
    assert late > 12


@pytest.mark.parametrize("method", ["fbs", "pbs:alpha=0.6", *BALANCE, "equilibrium:time=0.3"])
def test_a_session_says_on_a_deck_what_the_method_says_of_the_whole(method):
    judges, refused = make_method(method), 0
    for layout in random_layouts(10, seed=9):
        pallet = replace(layout.pallet, overhang=9.0)
        session, loaded = LoadingSession(pallet, judges), []
        for item in layout.items:
            x, y, z = item.position
            item = replace(item, sequence=len(loaded), position=(x - 9.0, y, z))
            verdict = session.try_place(item)
            whole = judges.judge(Layout("session", pallet, (*loaded, item)))
            assert (verdict.failing_step, verdict.moved_item) == (
                whole.failing_step, whole.moved_item
            )  # fmt: skip
            loaded += [item] if verdict.stable else []
            refused += not verdict.stable
    assert refused > 10


def test_a_slit_is_closed_above_the_deck_alone():
    pallet = replace(PALLET, floor="deck")
    items = (box(0, -5.0, 0.3, 20.0, 10.0), box(1, -28.0, 0.3, 20.0, 10.0))
    snapped = snap(Layout("deck", pallet, items), 0.5)
    assert [item.position[1] for item in snapped.items] == [0.0, 0.3]
