"""Placements that end early by what is foreseen, and what tips slowly, which must not."""

import itertools
import math
from functools import partial

import numpy as np
import pytest
from late_fallers import SLOW, Build, Fall, late_faller

from steadyload.engines.attitudes import rotate
from steadyload.engines.registry import world_class
from steadyload.engines.world import Box, EngineNotInstalledError, Poses
from steadyload.methods import make_method
from steadyload.methods.contract.spec import SpecError, stored_values
from steadyload.methods.contract.stopwatch import Stopwatch
from steadyload.methods.simulation.criteria import Criterion, Examiner
from steadyload.methods.simulation.foresight import Foresight

GRAVITY, EPS_T, EPS_R = 9.8, 0.1, math.radians(10.0)
LOOKS = (0.01, 0.03, 0.06)


def seen(displacement, angle=0.0):
    """One item's movement along one axis [m] and about another [rad], in units of thresholds."""
    return np.array([[0.0, displacement / EPS_T, 0.0, 0.0, 0.0, angle / EPS_R]])


def sunk(time):
    """How far a contact gives way under what is placed [m]."""
    return 5e-4 * (1.0 - math.exp(-time / 0.01))


def tips(past, height, sinks, time):
    """A rod that tips about its lower end, past its point of balance [m], on what sinks in."""
    rate = math.sqrt(0.75 * GRAVITY / (0.5 * height))
    angle = past / (0.5 * height) * (math.cosh(rate * time) - 1.0)
    return seen(height * angle + sinks * sunk(time), angle)


def first_safe(motion, every, end=3.0, share=0.4):
    """When what moves so is first held for safe [s], or passes a threshold; and which of both."""
    foresight = Foresight(share, end, EPS_T)
    for look in range(1, round(end / every) + 1):
        time = look * every
        moved = motion(time)
        if np.abs(moved).max() > 1.0:
            return time, "fails"
        if foresight.is_safe(time, moved):
            return time, "safe"
    return end, "neither"


@pytest.mark.parametrize("every", LOOKS)
@pytest.mark.parametrize("height", [0.1, 0.3, 1.0, 2.0])
@pytest.mark.parametrize("past", [1e-4, 5e-4, 2e-3])
def test_what_tips_is_never_held_for_safe(every, height, past):
    """A pile tips about its edge as a rod: past its point of balance by 0.1, 0.5 and 2 mm."""
    for sinks in (0.0, 1.0, 3.0):
        _, how = first_safe(partial(tips, past, height, sinks), every)
        assert how == "fails"


@pytest.mark.parametrize("height", [0.1, 0.3, 1.0, 2.0])
@pytest.mark.parametrize("beyond", [1.05, 1.5])
def test_what_just_fails_within_the_time_of_a_label_is_never_held_for_safe(height, beyond):
    for every in (0.01, 0.03):
        far = np.abs(tips(1e-3, height, 0.0, 0.3)).max()
        _, how = first_safe(partial(tips, 1e-3 * beyond / far, height, 1.0), every, end=0.3)
        assert how == "fails"


@pytest.mark.parametrize("every", LOOKS)
def test_what_rests_is_safe_wherever_it_has_come_to(every):
    for far in (0.0, 0.5 * EPS_T, 0.9 * EPS_T):

        def settles(time, far=far):
            return seen(far * (1.0 - math.exp(-time / 0.02)) + sunk(time))

        time, how = first_safe(settles, every)
        assert how == "safe"
        assert time <= 0.6


@pytest.mark.parametrize("share", [0.3, 0.6])
def test_what_creeps_is_safe_from_when_the_share_of_what_is_left_is_not_to_come(share):
    """At a steady speed: speed x time left <= share x (threshold - speed x time)."""
    for speed in (0.7 * share / 3.0, 0.9 / 3.0):
        expected = (3.0 * speed - share) / (speed - share * speed)
        time, how = first_safe(lambda time, v=speed: seen(v * EPS_T * time), 0.06, share=share)
        assert how == "safe"
        assert time == pytest.approx(max(0.18, math.ceil(expected / 0.06 - 1e-9) * 0.06))


def test_one_item_that_tips_keeps_all_from_being_safe():
    foresight = Foresight(0.4, 3.0, EPS_T)
    for look in range(1, 15):
        time = 0.06 * look
        tips = 1e-4 * (math.cosh(6.0 * time) - 1.0)
        assert not foresight.is_safe(time, np.vstack((seen(0.0), seen(tips), seen(0.0))))


def test_what_is_not_a_number_is_not_safe():
    foresight = Foresight(1.0, 3.0, EPS_T)
    with np.errstate(invalid="ignore"):
        assert not any(foresight.is_safe(0.1 * k, seen(np.nan)) for k in range(1, 20))


@pytest.mark.parametrize("criterion", Criterion)
def test_movements_are_those_of_the_criterion(criterion):
    box = Box((0.2, 0.4, 0.6), 5.0, (1.0, 2.0, 0.3))
    examiner = Examiner([box], criterion, 10.0, 20.0)
    angle = math.radians(5.0)
    turn = np.array([[math.cos(angle / 2.0), 0.0, math.sin(angle / 2.0), 0.0]])
    shift = np.array([[0.01, -0.02, 0.03]])
    for sign in (1.0, -1.0):  # a rotation has two quaternions
        poses = Poses(np.array([box.centre]) + shift, sign * turn)
        moved = examiner.moved_along(poses, np.array([0]))
        corner = -0.5 * np.array([box.size])
        expected = shift + (rotate(turn, corner) - corner) * (criterion is Criterion.ADAMS)
        assert moved[0, :3] == pytest.approx(expected[0] / 0.1)
        assert moved[0, 3:] == pytest.approx([0.0, 0.25, 0.0], rel=1e-3)


def test_it_is_off_unless_stated_and_then_part_of_the_method():
    plain, early = (make_method(f"label@mujoco{own}") for own in ("", ":early_stop=0.4"))
    assert plain.parameters.early_stop == 0.0
    assert "early_stop" not in stored_values(plain.parameters)
    assert "foresight" not in plain.parts()
    assert stored_values(early.parameters)["early_stop"] == 0.4
    assert early.parts()["foresight"] >= 1
    assert make_method(str(early.spec)).parameters == early.parameters
    for value in ("-0.1", "1.1"):
        with pytest.raises(SpecError, match="early_stop"):
            make_method(f"label@mujoco:early_stop={value}")


def last_step(spec, planted):
    """How far something has moved when the last box of a load is placed, over a threshold."""
    method = make_method(spec)
    try:
        world_class(method.spec.engine)
    except EngineNotInstalledError as error:
        pytest.skip(str(error))
    steps = method.steps(planted.layout, Stopwatch())
    try:
        return steps.step_score(len(planted.layout) - 1), steps.effort.substeps
    finally:
        steps.close()


@pytest.mark.parametrize("build", Build)
@pytest.mark.parametrize("fall", SLOW)
def test_a_box_just_past_its_point_of_balance_falls(build, fall):
    spec = "label@mujoco:frequency=240,question=stands,scope=widening,rest_speed=0.05"
    for turns, past in enumerate((0.01, 0.05, 0.2)):
        planted = late_faller(20, build, fall, past=past, turns=turns)
        assert last_step(f"{spec},early_stop=0.4", planted)[0] > 1.0


@pytest.mark.deep("needs the extra rapier")
@pytest.mark.parametrize("boxes", [20, 45, 91])
def test_a_box_just_past_its_point_of_balance_falls_in_piles_of_several_sizes(boxes):
    """The speed of rest that ends a placement otherwise takes most of these for resting."""
    spec = "ps_opt@rapier:question=stands"
    missed = 0
    for build, fall, past in itertools.product(Build, SLOW, (0.01, 0.05, 0.2)):
        planted = late_faller(boxes, build, fall, past=past, turns=boxes)
        assert last_step(f"{spec},early_stop=0.4", planted)[0] > 1.0, planted.layout.name
        missed += last_step(spec, planted)[0] <= 1.0
    assert missed > 0


@pytest.mark.parametrize("question", ["within", "stands"])
def test_what_stands_still_ends_early_with_the_same_verdict(question):
    spec = f"label@mujoco:frequency=240,question={question}"
    planted = late_faller(20, Build.MIXED, Fall.NONE)
    (moved, long), (early, short) = (
        last_step(spec + own, planted) for own in ("", ",early_stop=0.4")
    )
    assert max(moved, early) < 0.1
    assert short < 0.7 * long
    falls = late_faller(20, Build.MIXED, Fall.OVERHANG)
    assert last_step(f"{spec},early_stop=0.4", falls)[0] > 1.0
