"""stepSimulation(timeStep, maxSubSteps, fixedTimeStep) counts as Bullet does, but exactly."""

import math

import pytest

from steadyload.engines.substeps import StepCount, SubstepClock

SIXTIETH = 1.0 / 60.0


def counts(*calls):
    clock = SubstepClock()
    return [clock.advance(*call)[0] for call in calls]


def test_one_frame_is_one_substep():
    assert counts((SIXTIETH, 1, SIXTIETH)) == [StepCount(1, 1, 0)]


def test_time_beyond_the_clamp_is_lost():
    # 0.1 s at 60 Hz asks for six; one is allowed; the rest is gone, not carried.
    assert counts((0.1, 1, SIXTIETH), (0.0, 10, SIXTIETH)) == [
        StepCount(1, 6, 5),
        StepCount(0, 0, 0),
    ]


def test_a_remainder_is_carried():
    # 0.025 s is 1.5 substeps of 60 Hz: one now, the half completes the next call's.
    assert [c.executed for c in counts(*[(0.025, 10, SIXTIETH)] * 4)] == [1, 2, 1, 2]


def test_too_little_time_runs_nothing_and_is_not_lost():
    assert [c.executed for c in counts(*[(0.004, 10, SIXTIETH)] * 5)] == [0, 0, 0, 0, 1]


def test_no_maximum_means_one_variable_step():
    clock = SubstepClock()
    assert clock.advance(0.123, 0, SIXTIETH) == (StepCount(1, 1, 0), 0.123)
    assert clock.advance(0.0, 0, SIXTIETH)[0] == StepCount(0, 0, 0)
    # It also clears what was left over before.
    clock.advance(0.5 * SIXTIETH, 10, SIXTIETH)
    clock.advance(0.01, 0, SIXTIETH)
    assert clock.advance(0.6 * SIXTIETH, 10, SIXTIETH)[0].executed == 0


def test_negative_time_runs_nothing():
    assert counts((-1.0, 10, SIXTIETH), (-1.0, 0, SIXTIETH)) == [StepCount(0, 0, 0)] * 2


def naive_bullet(calls, time_step, fixed):
    """Bullet's own arithmetic in double precision."""
    local, found = 0.0, []
    for _ in range(calls):
        local += time_step
        n = int(local / fixed) if local >= fixed else 0
        local -= n * fixed
        found.append(n)
    return found


def test_the_26_or_27_trap():
    """0.3 s at 90 Hz is 27 substeps; doubles run 26 first."""
    assert naive_bullet(3, 0.3, 1.0 / 90.0)[0] == 26
    assert [c.executed for c in counts(*[(0.3, 100, 1.0 / 90.0)] * 3)] == [27, 27, 27]


def test_the_whole_grid_of_table_3_is_exact():
    """t_max 0.1 to 3 s by 0.1, 5 to 100 Hz by 5: every count is the product, every time."""
    naive_misses = 0
    for tenths in range(1, 31):
        for frequency in range(5, 101, 5):
            exact = [c.executed for c in counts(*[(tenths / 10, 10**6, 1.0 / frequency)] * 10)]
            total = math.floor(10 * tenths * frequency / 10 + 1e-9)
            assert sum(exact) == total, (tenths, frequency)
            naive = naive_bullet(1, tenths / 10, 1.0 / frequency)[0]
            naive_misses += naive != tenths * frequency // 10
    assert naive_misses > 50  # the trap is common, not a curiosity


def test_samples_of_a_placement_add_up():
    # 0.3 s at 90 Hz in ten looks: 2.7 substeps each, 27 in all.
    assert sum(c.executed for c in counts(*[(0.3 / 10, 100, 1.0 / 90.0)] * 10)) == 27
    assert sum(c.executed for c in counts(*[(0.3 / 7, 100, 1.0 / 90.0)] * 7)) == 27


def test_fine_steps_are_exact_too():
    # 0.123457 s at 1 MHz in ten looks: 12345.7 substeps each, 123457 in all.
    assert sum(c.executed for c in counts(*[(0.123457 / 10, 10**6, 1e-6)] * 10)) == 123457


@pytest.mark.parametrize(
    "call",
    [
        (math.nan, 1, SIXTIETH),
        (math.inf, 1, SIXTIETH),
        (0.1, -1, SIXTIETH),
        (0.1, 1, 0.0),
        (0.1, 1, -SIXTIETH),
        (0.1, 1, math.nan),
    ],
)
def test_impossible_arguments_are_refused(call):
    with pytest.raises(ValueError, match="must be"):
        SubstepClock().advance(*call)
