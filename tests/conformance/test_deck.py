"""Every engine on a deck with edges: what stands near one, what falls, and what moves as ever."""

import math
from dataclasses import replace

import numpy as np
import pytest

from steadyload.engines.registry import world_class
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods.registry import make_method
from steadyload.methods.session.recording import record_loading
from steadyload.methods.session.session import LoadingSession
from steadyload.methods.simulation.placements import Placements

PALLET = Pallet(100.0, 200.0, 100.0, overhang=30.0)
MM = 0.1
LONG = 2.0
"""Time [s] in which a box whose centre of mass lies 1 mm past an edge falls for all to see."""


def box(sequence, x, y, width, height, weight=10.0, *, offset=0.0):
    """All boxes share their depth, and are judged in the plane as well."""
    return Item(sequence, (x, y, 30.0), (width, height, 40.0), weight, (offset, 0.0, 0.0))


def layout(*items, pallet=PALLET):
    return Layout("deck", pallet, items)


def simulation(engine, seconds=LONG, frequency=1000):
    return make_method(
        f"simulation@{engine}:between_steps=reseat,t_max={seconds},frequency={frequency}"
    )


def resolved(engine):
    """How far inside an edge a centre of mass must lie for a box to stand [cm].

    An engine whose contacts give way declares the failure of a check with 1 mm.
    """
    known = [failure.check for failure in world_class(engine).capabilities.known_failures]
    return 2.0 * MM if "edge_of_a_deck" in known else MM


def tipping_time(width, height, past):
    """When a box of uniform density, its centre of mass so far past an edge, has tipped by 10 deg.

    About the edge, with its centre of mass at height h above it: I a'' = m g (h sin a + past), I =
    m ((w^2 + (2 h)^2) / 12 + h^2 + past^2). From rest a = past / h (cosh(k t) - 1), k^2 = m g h /
    I.
    """
    h = 0.5 * height
    inertia = (width**2 + height**2) / 12.0 + h**2 + past**2
    k = math.sqrt(980.0 * h / inertia)
    return math.acosh(1.0 + math.radians(10.0) * h / past) / k


@pytest.mark.parametrize("edge", ["left", "right"])
@pytest.mark.parametrize(("offset", "height"), [(0.0, 30.0), (5.0, 15.0), (0.0, 8.0)])
def test_a_millimetre_decides_whether_a_box_stands(any_engine, edge, offset, height):
    for inside, stands in ((resolved(any_engine), True), (-MM, False)):
        x, shift = inside - 15.0 - offset, offset
        if edge == "right":
            x, shift = 100.0 - x - 30.0, -shift
        found = simulation(any_engine).judge(layout(box(0, x, 0.0, 30.0, height, offset=shift)))
        assert (found.status, found.stable) == ("done", stands)


def test_the_time_of_a_placement_bounds_what_it_shows(any_engine):
    """A box tips slowly at first: 0.3 s show a fall 1.7 cm past the edge, and none 1 mm past it."""
    for past in (MM, 1.7):
        early, late = 0.85 if past > resolved(any_engine) else 0.6, 1.15
        seconds = tipping_time(40.0, 30.0, past)
        assert seconds == pytest.approx({MM: 0.686, 1.7: 0.273}[past], abs=1e-3)
        item = box(0, -20.0 - past, 0.0, 40.0, 30.0)
        found = [
            simulation(any_engine, factor * seconds).judge(layout(item)).stable
            for factor in (early, late)
        ]
        assert found == [True, False]
        assert make_method(f"label@{any_engine}").judge(layout(item)).stable is (past == MM)


@pytest.mark.parametrize("counterweight", [0.0, 2.0, 10.0])
def test_a_stack_on_an_overhanging_box_is_held_by_a_counterweight(any_engine, counterweight):
    # As for equilibrium (tests/methods/test_deck.py): a board of 10 kg with a moment of 10 x 5
    # about the edge, a counterweight with 15 cm, and two boxes that pull with 5 cm.
    board = box(0, -10.0, 0.0, 30.0, 5.0)
    most = (10.0 * 5.0 + counterweight * 15.0) / 5.0
    for load, stands in ((0.9 * most, True), (1.1 * most, False)):
        items = [board]
        if counterweight:
            items.append(box(1, 10.0, 5.0, 10.0, 10.0, counterweight))
        for level in range(2):
            place = -10.0, 5.0 + 10.0 * level
            items.append(box(len(items), *place, 10.0, 10.0, 0.5 * load))
        found = simulation(any_engine).judge(layout(*items))
        expected = None if stands else len(items) - 1
        assert (found.status, found.failing_step) == ("done", expected)


def test_what_falls_beside_the_deck_comes_to_lie_on_the_ground(any_engine):
    beside = layout(box(0, -25.0, 0.0, 20.0, 15.0))
    method = make_method(f"simulation@{any_engine}:between_steps=reseat,t_max=1,eps_t=50,eps_r=90")
    assert method.judge(beside).stable
    recorded = record_loading(beside, method)
    height = recorded.steps[0].poses.centres[-1, 0, 1]
    assert recorded.planned[0] == pytest.approx((-15.0, 7.5, 50.0))
    # Some engines let a box that comes down sink in by a millimetre or two at first.
    assert height == pytest.approx(7.5 - 14.4, abs=0.3)
    low = replace(beside.pallet, deck_height=3.0)
    height = record_loading(layout(*beside.items, pallet=low), method).steps[0].poses.centres[-1]
    assert height[0, 1] == pytest.approx(7.5 - 3.0, abs=0.3)


def test_a_layout_moves_on_a_deck_as_on_a_plane(any_engine):
    """Away from edges, poses are equal to 0.2 mm while all stand, and to 3 mm in a fall."""
    planar = world_class(any_engine).capabilities.dimensions == 2
    falls = 0
    for plan in _piles(planar=planar):
        method = simulation(any_engine, 0.3, 480)
        deck, plane = (record_loading(plan.on(kind), method) for kind in ("deck", "infinite"))
        assert deck.verdict.failing_step == plane.verdict.failing_step
        for step, (one, other) in enumerate(zip(deck.steps, plane.steps, strict=True)):
            frames = min(one.judged, other.judged)
            there, here = one.poses.centres[:frames], other.poses.centres[:frames]
            failed = step == plane.verdict.failing_step
            assert np.abs(there - here).max() <= (3.0 if failed else 0.2) * MM
            falls += failed
    assert falls


def _piles(*, planar):
    """Piles in the middle of a wide deck; some fall."""
    for number in range(3):
        if planar:
            columns = [(2.0 * number, 0.0, 4.1), (20.0, 20.0, 17.0, 23.0)]
            items = [
                box(0, 200.0 + x, 10.0 * level, 10.0, 10.0)
                for shifts in columns
                for level, x in enumerate(shifts)
            ]
            items = [replace(item, sequence=k) for k, item in enumerate(items)]
            yield Layout(f"{number}", Pallet(500.0, 400.0, 100.0), tuple(items))
            continue
        plan = random_layouts(5, seed=4)[number].first(8)
        width, height, depth = plan.pallet.size
        items = [
            replace(i, position=(i.position[0] + 2 * width, i.position[1], i.position[2] + depth))
            for i in plan.items
        ]
        yield Layout(f"{number}", Pallet(5 * width, height, 3 * depth), tuple(items))


@pytest.mark.parametrize(
    "options",
    [
        "between_steps=carry",
        "between_steps=reseat",
        "between_steps=reseat,scope=local",
        "between_steps=reseat,scope=widening,rest_speed=0.02,samples=40",
    ],
)
def test_a_session_says_on_a_deck_what_the_simulation_says(any_engine, options):
    method = make_method(f"simulation@{any_engine}:{options}")
    # The second item makes the deck's edges matter; the last ones hold and fail.
    items = [
        box(0, 40.0, 0.0, 20.0, 20.0), box(1, -10.0, 0.0, 30.0, 5.0), box(2, 10.0, 5.0, 10.0, 10.0),
        box(3, -10.0, 5.0, 10.0, 10.0, 30.0), box(4, -10.0, 15.0, 10.0, 10.0, 60.0),
    ]  # fmt: skip
    with LoadingSession(PALLET, method) as session:
        for count, item in enumerate(items, start=1):
            found, whole = session.try_place(item), method.judge(layout(*items[:count]))
            assert (found.failing_step, found.displacement) == (
                whole.failing_step, whole.displacement
            )  # fmt: skip
        assert len(session) == 4
        # Without the board nothing overhangs, and the next world has no slab.
        session.undo(3)
        last = box(1, 0.0, 0.0, 20.0, 20.0)
        found, whole = session.try_place(last), method.judge(layout(items[0], last))
        assert found.stable
        assert not session.layout().floor.has_edges


def test_one_world_serves_all_placements_on_a_deck(any_engine, monkeypatch):
    worlds = []
    close = Placements.close
    monkeypatch.setattr(
        Placements, "close", lambda run: (worlds.append(run.effort.worlds), close(run))
    )
    items = [box(k, -4.0, 10.0 * k, 20.0, 10.0) for k in range(4)]
    assert simulation(any_engine, 0.3).judge(layout(*items)).stable
    assert worlds == [1]
