"""Settling: the rest position of least potential energy, against closed forms and simulation."""

import math

import numpy as np
import pytest

from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.model.question import Question
from steadyload.methods import make_method
from steadyload.methods.contract.spec import SpecError
from steadyload.methods.contract.stopwatch import Stopwatch
from steadyload.methods.session.session import LoadingSession

PALLET = Pallet(200.0, 200.0, 200.0)


def layout(*boxes, name="boxes"):
    """Boxes given as position and size, and a weight where it is not 1 kg."""
    items = [Item(k, box[0], box[1], *(box[2:] or (1.0,))) for k, box in enumerate(boxes)]
    return Layout(name, PALLET, tuple(items))


def found(lay, spec="settling"):
    """The movement at the last step, and the verdict."""
    method = make_method(spec)
    steps = method.steps(lay, Stopwatch())
    scores = [steps.step_score(k) for k in range(len(lay))]
    return scores, method.judge(lay)


def bridge(gap, base=20.0, lean=2.0):
    """A box whose middle lies past the edge of a pillar, over another that is lower by a gap."""
    height = 30.0
    return layout(
        ((0.0, 0.0, 0.0), (10.0 - lean, height, 20.0)),
        ((10.0, 0.0, 0.0), (10.0, height - gap, 20.0)),
        ((0.0, height, 0.0), (base, 10.0, 20.0)),
    )


@pytest.mark.parametrize("gap", [0.3, 1.0, 1.5])
def test_a_box_tips_into_a_gap_until_it_meets_what_is_lower(gap):
    """It turns about the edge of the pillar until its far edge has come down by the gap."""
    scores, verdict = found(bridge(gap))
    slope = gap / (20.0 - 8.0)
    expected = math.degrees(math.atan(slope)) / 10.0
    assert scores[:2] == [0.0, 0.0]
    # Patches are drawn in by 0.1 mm on every side.
    assert scores[2] == pytest.approx(expected, rel=2.0 * 0.02 / 12.0)
    assert verdict.stable
    assert make_method("equilibrium").judge(bridge(gap)).failing_step == 2


def test_a_gap_that_is_too_deep_is_a_failure_and_a_threshold_moves_the_limit():
    slope = math.tan(math.radians(10.0))
    for factor, fails in ((0.98, False), (1.02, True)):
        lay = bridge(factor * slope * 12.0)
        verdict = make_method("settling").judge(lay)
        assert (verdict.failing_step == 2) is fails
    assert verdict.moved_item == 2
    assert verdict.rotation == pytest.approx(10.2, abs=0.1)
    assert make_method("settling:eps_r=12").judge(lay).stable


@pytest.mark.parametrize(("drop", "fails"), [(9.9, False), (10.1, True)])
def test_what_floats_sinks_straight_down(drop, fails):
    lay = layout(((0, 0, 0), (20, 10, 20)), ((0, 10.0 + drop, 0), (20, 10, 20)))
    scores, verdict = found(lay)
    assert scores[1] == pytest.approx(drop / 10.0, abs=1e-6)
    assert verdict.failing_step == (1 if fails else None)
    if fails:
        assert verdict.displacement == pytest.approx(drop)
        assert verdict.rotation == pytest.approx(0.0, abs=1e-6)


def test_what_stands_out_too_far_falls():
    lay = layout(((0, 0, 0), (20, 100, 20)), ((11, 100, 0), (20, 10, 20)))
    scores, verdict = found(lay)
    assert scores[1] > 1.0
    assert (verdict.failing_step, verdict.moved_item) == (1, 1)


def test_boxes_on_a_box_that_tilts_go_with_it():
    lay = bridge(1.0)
    top = Item(3, (0.0, 40.0, 0.0), (20.0, 10.0, 20.0), 1.0)
    higher = Layout("higher", PALLET, (*lay.items, top))
    scores, verdict = found(higher)
    assert verdict.stable
    assert scores[3] == pytest.approx(scores[2], rel=1e-6)


def test_a_counterweight_keeps_a_box_from_tipping():
    """Every step is judged from the plan: with a weight on its other end the box stays there."""
    lay = bridge(1.0)
    weight = Item(3, (0.0, 40.0, 0.0), (4.0, 10.0, 20.0), 5.0)
    scores, _ = found(Layout("held", PALLET, (*lay.items, weight)))
    assert scores[2] > 0.1
    assert scores[3] == pytest.approx(0.0, abs=1e-6)


def test_the_position_does_not_depend_on_units_of_mass_or_place():
    lay = bridge(1.2)
    scores, _ = found(lay)
    moved = [
        Item(i.sequence, tuple(np.add(i.position, (50.0, 0.0, 70.0))), i.size, 1e3 * i.weight)
        for i in lay.items
    ]
    others, _ = found(Layout("moved", PALLET, tuple(moved)))
    assert others == pytest.approx(scores, rel=1e-6)


def test_what_balances_with_the_margin_does_not_move_and_nothing_else_is_solved():
    """A step balances by exact equilibrium exactly where nothing sinks."""
    benchmark = load_benchmark()
    chosen = benchmark.select("validation", limit=60)
    exact, settling = make_method("equilibrium:margin=0.01"), make_method("settling")
    unstable = 0
    for case in chosen.itertuples():
        lay = benchmark.layout(case.layout, case.scenario)
        first = exact.judge(lay).failing_step
        steps = settling.steps(lay, Stopwatch())
        end = len(lay) if first is None else first
        assert all(steps.step_score(k) == 0.0 for k in range(end))
        if first is not None:
            unstable += 1
            assert steps.step_score(first) > 1e-6
    assert unstable > 30


def test_verdicts_are_mostly_the_labels_of_what_stands():
    """Of 300 cases exact equilibrium is right on 87 %, settling on 94 %."""
    benchmark = load_benchmark()
    chosen = benchmark.select("validation", limit=60, question=Question.STANDS)
    layouts = [benchmark.layout(c.layout, c.scenario) for c in chosen.itertuples()]
    labels = [
        None if np.isnan(step) else int(step) for step in chosen["failing_step"].astype(float)
    ]
    right = {}
    for spec in ("settling", "equilibrium:margin=0.01"):
        said = [v.failing_step for v in make_method(spec).judge_many(layouts)]
        right[spec] = np.mean([a == b for a, b in zip(said, labels, strict=True)])
    assert right["settling"] > max(0.9, right["equilibrium:margin=0.01"] + 0.03)


def test_single_steps_sessions_and_whole_layouts_agree():
    benchmark = load_benchmark()
    chosen = benchmark.select("validation", limit=8)
    method = make_method("settling")
    for case in chosen.itertuples():
        lay = benchmark.layout(case.layout, case.scenario)
        step = method.judge(lay).failing_step
        steps = method.steps(lay, Stopwatch())
        end = len(lay) if step is None else step
        assert all(steps.step_score(k) <= 1.0 for k in range(end))
        if step is not None:
            assert not steps.step_score(step) <= 1.0
            assert steps.finding(step).failing_step == step
        with LoadingSession(lay.pallet, method) as session:
            said = [session.try_place(item).stable for item in lay.items[: end + 1]]
        assert said == [True] * end + [False] * (step is not None)


def test_steps_that_are_left_out_count_as_placed():
    lay = bridge(1.0)
    top = Item(3, (0.0, 40.0, 0.0), (20.0, 10.0, 20.0), 1.0)
    higher = Layout("higher", PALLET, (*lay.items, top))
    scores, _ = found(higher)
    steps = make_method("settling").steps(higher, Stopwatch())
    assert steps.step_score(3) == pytest.approx(scores[3])


def test_the_edge_of_a_deck_ends_what_carries():
    items = (Item(0, (-1.0, 0.0, 0.0), (30.0, 20.0, 30.0), 1.0),)
    over = (Item(0, (-16.0, 0.0, 0.0), (30.0, 20.0, 30.0), 1.0),)
    deck = Pallet(80.0, 100.0, 120.0, overhang=20.0)
    assert make_method("settling").judge(Layout("in", deck, items)).stable
    assert make_method("settling").judge(Layout("out", deck, over)).failing_step == 0


@pytest.mark.parametrize("limits", ["eps_r=0", "eps_t=0", "eps_t=0,eps_r=0"])
def test_thresholds_of_nothing_allow_nothing(limits):
    out = layout(((0, 0, 0), (20, 100, 20)), ((11, 100, 0), (20, 10, 20)))
    floats = layout(((0, 0, 0), (20, 10, 20)), ((0, 10.5, 0), (20, 10, 20)))
    still = layout(((0, 0, 0), (20, 10, 20)), ((0, 10, 0), (20, 10, 20)))
    method = make_method(f"settling:{limits}")
    assert method.judge(out).failing_step == 1
    assert method.judge(floats).failing_step == (None if limits == "eps_r=0" else 1)
    assert method.judge(still).stable


def test_a_light_box_among_heavy_ones_is_not_forgotten():
    """It floats by 5 mm above a box that tips, and comes down by that and a bit more."""
    heavy = [Item(i.sequence, i.position, i.size, 1e5) for i in bridge(1.0).items]
    light = Item(3, (0.0, 40.5, 0.0), (4.0, 4.0, 4.0), 1e-3)
    lay = Layout("light", PALLET, (*heavy, light))
    scores, verdict = found(lay)
    assert verdict.stable
    assert scores[3] < 0.6


def test_a_step_does_not_depend_on_what_comes_later():
    falls = layout(((0, 0, 0), (20, 100, 20)), ((11, 100, 0), (20, 10, 20)))
    later = (
        Item(2, (100.0, 0.0, 100.0), (90.0, 50.0, 90.0), 5.0),
        Item(3, (100.0, 50.0, 100.0), (90.0, 50.0, 90.0), 5.0),
    )
    longer = Layout("longer", PALLET, (*falls.items, *later))
    alone, whole = (make_method("settling").judge(lay) for lay in (falls, longer))
    assert (alone.failing_step, alone.displacement) == (whole.failing_step, whole.displacement)


def test_options_are_checked():
    assert make_method("settling:margin=0.1mm").parameters.margin == pytest.approx(0.01)
    for wrong in ("margin=-1", "eps_t=-1", "eps_r=60", "sides=friction"):
        with pytest.raises(SpecError):
            make_method(f"settling:{wrong}")
