"""Whether a load stands: asked until everything rests, and not within the time of a label alone."""

import math

import pytest

from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.benchmark import load_benchmark
from steadyload.methods import Status, make_method
from steadyload.methods.cascade.thresholds import fingerprint
from steadyload.methods.contract.spec import SpecError, stored_values
from steadyload.methods.contract.stopwatch import Stopwatch
from steadyload.methods.simulation import placements
from steadyload.methods.simulation.simulation_parameters import STILL

GRAVITY = 9.8
PALLET = Pallet(100.0, 100.0, 100.0)


def past_the_edge(by):
    """A cube of 10 cm on another, with its centre of mass a bit beyond the edge of that."""
    return Layout(
        "edge",
        PALLET,
        (
            Item(0, (40.0, 0.0, 40.0), (10.0, 10.0, 10.0), 1.0),
            Item(1, (45.0 + by, 10.0, 40.0), (10.0, 10.0, 10.0), 1.0),
        ),
    )


def time_to_ten_degrees(by):
    """Time [s] that a cube of 10 cm takes to tip about an edge by 10 degrees (pendulum)."""
    side, lever = 0.1, math.hypot(0.05, by / 100.0)
    about_edge = side**2 / 6.0 + lever**2
    start, end = math.asin(by / 100.0 / lever), math.asin(by / 100.0 / lever) + math.radians(10.0)
    # Energy gives the rate at every angle, and the first bit goes with a steady acceleration.
    angle = start + 1e-9
    time = math.sqrt(2e-9 * about_edge / (GRAVITY * lever * math.sin(start)))
    while angle < end:
        step = max(1e-7, 1e-4 * (angle - start))
        middle = angle + 0.5 * step
        rate = math.sqrt(2.0 * GRAVITY * lever * (math.cos(start) - math.cos(middle)) / about_edge)
        time += step / rate
        angle += step
    return time


@pytest.mark.parametrize("engine", ["reference", "mujoco"])
@pytest.mark.parametrize("by", [0.01, 0.02])
def test_what_tips_slowly_fails_by_standing_and_not_within_the_label(engine, by):
    assert time_to_ten_degrees(by) > 0.3
    layout = past_the_edge(by)
    within = make_method(f"label@{engine}").judge(layout)
    stands = make_method(f"label@{engine}:question=stands").judge(layout)
    assert (within.status, within.failing_step) == (Status.DONE, None)
    assert (stands.status, stands.failing_step, stands.moved_item) == (Status.DONE, 1, 1)


def test_what_fails_within_the_label_does_not_stand_and_what_is_flush_does():
    method = make_method("label@reference:question=stands")
    assert method.judge(past_the_edge(3.0)).failing_step == 1
    assert method.judge(past_the_edge(-1.0)).stable


@pytest.mark.parametrize("engine", ["reference", "mujoco", "bullet", "dart"])
def test_what_still_moves_at_the_end_is_unsettled_and_neither_stands_nor_falls(engine):
    by = 0.3
    long = 0.8 * time_to_ten_degrees(by)
    spec = f"label@{engine}:question=stands,t_max={long:.3f},samples=10"
    verdict = make_method(spec).judge(past_the_edge(by))
    assert verdict.status is Status.UNSETTLED
    assert verdict.moved_item == 1
    assert verdict.score is None
    assert not verdict.stable
    assert "item 1 still moves" in verdict.reason


def test_a_speed_of_rest_that_is_stated_is_the_one_below_which_things_stand():
    by = 0.3
    long = 0.8 * time_to_ten_degrees(by)
    slow = f"label@reference:question=stands,t_max={long:.3f},samples=1,rest_speed=10"
    assert STILL < 10
    assert make_method(slow).judge(past_the_edge(by)).stable


def test_the_question_brings_its_times_unless_others_are_stated():
    own = make_method("label@reference:question=stands").parameters
    assert (own.t_max, own.samples, own.early_exit) == (3.0, 100, 0.0)
    stated = make_method("label@reference:question=stands,t_max=1,samples=20").parameters
    assert (stated.t_max, stated.samples) == (1.0, 20)
    assert make_method("ps_opt@mujoco:question=within").parameters == (
        make_method("ps_opt@mujoco").parameters
    )
    with pytest.raises(SpecError, match="early_exit needs question=within"):
        make_method("label@reference:question=stands,early_exit=2")
    with pytest.raises(SpecError, match=r"question is 'falls'; allowed: stands, within"):
        make_method("label@reference:question=falls")


def test_what_was_stored_before_there_was_a_question_stays_valid():
    assert "question" not in stored_values(make_method("label@reference").parameters)
    asked = make_method("label@reference:question=stands")
    assert stored_values(asked.parameters)["question"] == "stands"
    assert fingerprint(make_method("label@reference:question=within")) == (
        fingerprint(make_method("label@reference"))
    )


def test_what_rattles_in_its_place_is_at_rest(monkeypatch, moved_by):
    """On a pallet of 46 boxes MuJoCo has one going to and fro at 4 cm/s, by less than 1 mm.

    Whether it does at the end of the step, rounding decides: it does from some starts.
    """
    layout = load_benchmark("real").layout("0615664.order-3", "S1")
    method = make_method("label@mujoco:question=stands,rest_speed=0.01,rest_samples=5")

    def settled(seed):
        with moved_by(seed):
            steps = method.steps(layout, Stopwatch())
            found = math.isfinite(steps.step_score(24))
            assert found or steps.finding(24).status is Status.UNSETTLED
            steps.close()
        return found

    starts = (None, *map(str, range(1, 9)))
    assert all(map(settled, starts[:3]))
    monkeypatch.setattr(placements, "_RATTLE", -1.0)
    assert not all(map(settled, starts))
