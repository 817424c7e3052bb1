"""Simulation of what moves alone, beside simulation of everything."""

import pytest

from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.benchmark import load_benchmark
from steadyload.methods import make_method
from steadyload.methods.contract.stopwatch import Stopwatch
from steadyload.methods.session.recording import record_loading

PALLET = Pallet(100.0, 100.0, 100.0)
MOVING = "label@mujoco:frequency=240,scope=moving"
ALL = "label@mujoco:frequency=240"


def stack(*boxes, weights=None, offset=0.0):
    """A layout of boxes, each (x, y, z, width, height, depth), of 1 kg a litre unless stated; the
    centre of mass of the first is off the middle by ``offset``.
    """
    own = weights or [b[3] * b[4] * b[5] / 1000.0 for b in boxes]
    offsets = [(0.0, 0.0, 0.0)] * len(boxes)
    offsets[0] = (offset, 0.0, 0.0)
    items = enumerate(zip(boxes, own, offsets, strict=True))
    placed = tuple(Item(k, b[:3], b[3:], kg, by) for k, (b, kg, by) in items)
    return Layout("stack", PALLET, placed)


def said(spec, layout):
    verdict = make_method(spec).judge(layout)
    assert verdict.status == "done", verdict.reason
    return verdict


BALANCED = stack((0, 0, 0, 20, 10, 20), (40, 0, 0, 20, 10, 20), (5, 10, 0, 20, 10, 20))


def test_what_balances_is_not_simulated_at_all():
    verdict = said(MOVING, BALANCED)
    assert verdict.stable
    assert verdict.effort.substeps == 0
    assert said(ALL, BALANCED).effort.substeps > 0


def test_what_balances_within_the_margin_alone_is_simulated():
    edge = stack((40, 0, 40, 10, 10, 10), (44.995, 10, 40, 10, 10, 10))
    assert said(f"{MOVING},balance_margin=0", edge).effort.substeps == 0
    assert said(MOVING, edge).effort.substeps > 0


def test_an_answer_is_kept_while_nothing_touches_what_moved():
    # A box that tips by some millimetres on another, lower one, and rests there.
    tips = ((0, 0, 0, 10, 10, 20), (12, 0, 0, 10, 9.7, 20), (4, 10, 0, 14, 10, 20))
    apart = ((60, 0, 0, 10, 10, 10), (60, 10, 0, 10, 10, 10))
    few, more = said(MOVING, stack(*tips)), said(MOVING, stack(*tips, *apart))
    assert few.stable
    assert more.stable
    assert more.effort.substeps == few.effort.substeps > 0
    on_top = said(MOVING, stack(*tips, (6, 20, 5, 10, 5, 10)))
    assert on_top.effort.substeps > few.effort.substeps


def test_thin_walls_that_are_pushed_aside_hold_nothing():
    # As firm walls they would jam the box between them.
    jam = stack((0, 0, 0, 20, 60, 20), (37, 0, 0, 1, 60, 20), (34, 0, 0, 3, 30, 20),
                (20, 30, 0, 17, 17, 20))  # fmt: skip
    assert said(ALL, jam).failing_step == 3
    assert said(MOVING, jam).failing_step == 3


def test_what_something_falls_on_gives_way():
    falls = stack((50, 0, 0, 10, 10, 10), (52, 10, 0, 14, 2, 10), (61, 12, 0, 12, 10, 10),
                  (66, 0, 0, 2, 6, 4))  # fmt: skip
    whole, part = said(ALL, falls), said(MOVING, falls)
    assert (whole.failing_step, whole.moved_item) == (part.failing_step, part.moved_item)


@pytest.mark.parametrize("engine", ["mujoco", "bullet"])
def test_verdicts_are_those_of_simulating_everything(engine):
    benchmark = load_benchmark()
    chosen = benchmark.select("validation", limit=12)
    whole, part = make_method(f"label@{engine}"), make_method(f"label@{engine}:scope=moving")
    work, other = [0, 0], []
    for name, scenario in zip(chosen["layout"], chosen["scenario"], strict=True):
        layout = benchmark.layout(name, scenario)
        verdicts = [method.judge(layout) for method in (whole, part)]
        for k, verdict in enumerate(verdicts):
            work[k] += verdict.effort.body_substeps
        if len({(v.status, v.failing_step) for v in verdicts}) > 1:
            other.append(name)
    assert len(other) <= 1, other
    assert work[1] < 0.6 * work[0]


def test_single_steps_are_scored_whatever_was_left_out():
    layout = stack((40, 0, 40, 10, 10, 10), (40, 10, 40, 10, 10, 10), (46, 20, 40, 10, 10, 10))
    method = make_method(MOVING)
    scorer = method.steps(layout, Stopwatch())
    assert scorer.step_score(2) > 1.0
    assert method.judge(layout).failing_step == 2


def test_a_step_that_is_not_simulated_has_a_score_of_its_own():
    # A plank tips; a counterweight holds it down again, and then nothing is simulated.
    tips = stack((40, 0, 40, 10, 10, 10), (42, 10, 40, 20, 2, 10), (40, 12, 40, 8, 10, 10),
                 weights=[1.0, 1.0, 20.0])  # fmt: skip
    scorer = make_method(MOVING).steps(tips, Stopwatch())
    assert scorer.step_score(1) > 1.0
    assert scorer.step_score(2) < 1.0


def test_what_is_in_the_way_of_one_item_is_in_the_way_of_all_that_moved_with_it():
    # The box on top tips on its lower carrier and pushes the tall one, which balances by itself.
    # Whether that gets as far as 10 degrees, rounding decides: here it may.
    boxes = ((10, 0, 0, 10, 20, 20), (22, 0, 0, 10, 19, 20), (32, 0, 4, 8, 50, 10),
             (14, 20, 0, 18, 30, 20))  # fmt: skip
    weights, far = [1.0, 1.0, 0.5, 5.0], f"{MOVING},eps_t=50,eps_r=90"
    before = said(far, stack(*boxes, weights=weights))
    beside = stack(*boxes, (40, 0, 4, 1, 50, 10), weights=[*weights, 0.05])
    assert before.effort.substeps > 0
    assert said(far, beside).effort.substeps > before.effort.substeps


def test_a_box_on_the_floor_that_stands_on_its_edge_is_simulated():
    one = stack((40, 0, 40, 10, 10, 10), offset=4.998)
    assert said(f"{MOVING},balance_margin=0", one).effort.substeps == 0
    asked = said(f"{MOVING},question=stands", one)
    assert asked.failing_step == said(f"{ALL},question=stands", one).failing_step == 0
    assert said("equilibrium:margin=0.01", one).failing_step == 0
    assert said("equilibrium", one).stable


def test_a_recording_shows_a_step_at_which_others_than_the_new_item_move():
    boxes = ((0, 0, 0, 10, 10, 20), (12, 0, 0, 6, 9.7, 20), (4, 10, 0, 14, 10, 20),
             (18.02, 0, 0, 10, 30, 20))  # fmt: skip
    recording = record_loading(stack(*boxes), make_method(MOVING))
    assert recording.verdict.stable
    assert [step.poses.centres.shape[1] for step in recording.steps] == [1, 2, 3, 4]
