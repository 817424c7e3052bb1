"""Number of substeps that a call to ``stepSimulation`` runs. Written once, for every engine."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

from steadyload.engines.errors import BadNumberError


class StepCount(NamedTuple):
    """Substeps of one ``stepSimulation``: executed, requested by its time, and lost."""

    executed: int
    requested: int
    lost: int


@lru_cache(maxsize=4096)
def _exact(seconds: float) -> Fraction:
    """The duration a user meant by a float: 0.3 is 3/10 and 1/90 is 1/90, not their neighbours."""
    value = Fraction(seconds)
    simple = value.limit_denominator(10_000_000)
    return simple if abs(float(simple) - seconds) <= 1e-14 * abs(seconds) else value


_NONE = Fraction(0)


@lru_cache(maxsize=65536)
def _divide(remainder: Fraction, time_step: float, fixed: float) -> tuple[int, Fraction]:
    """Whole substeps in ``remainder + time_step``, and the remainder; negative time runs none."""
    total = remainder + _exact(time_step)
    requested = max(0, total // _exact(fixed))
    return requested, total - requested * _exact(fixed)


class SubstepClock:
    """Bullet's substep accounting (``btDiscreteDynamicsWorld::stepSimulation``), in exact numbers.

    In floating point 0.3 s at 90 Hz runs 26 substeps, then 27: rounding decides. Here durations
    are fractions, so the count is the one that was meant. As in Bullet, time beyond
    ``maxSubSteps`` is lost, a remainder smaller than a substep is carried to the next call, and
    nothing is interpolated.
    """

    def __init__(self) -> None:
        self._remainder = _NONE

    def advance(
        self, time_step: float, max_sub_steps: int, fixed_time_step: float
    ) -> tuple[StepCount, float]:
        """Account for one call. Returns the count and the length of each substep [s].

        ``max_sub_steps=0`` means one variable step of ``time_step``.

        Raises:
            BadNumberError: a duration is not finite, ``max_sub_steps`` is negative, or
                ``fixed_time_step`` is not positive although it is used.
        """
        if not (math.isfinite(time_step) and math.isfinite(fixed_time_step)):
            raise BadNumberError(f"durations must be finite, got {time_step} and {fixed_time_step}")
        if max_sub_steps < 0:
            raise BadNumberError(f"maxSubSteps must be 0 or more, got {max_sub_steps}")
        if max_sub_steps == 0:
            self._remainder = _NONE
            count = 1 if time_step > 0.0 else 0
            return StepCount(count, count, 0), time_step
        if fixed_time_step <= 0.0:
            raise BadNumberError(f"fixedTimeStep must be positive, got {fixed_time_step}")
        requested, self._remainder = _divide(self._remainder, time_step, fixed_time_step)
        executed = min(requested, max_sub_steps)
        return StepCount(executed, requested, requested - executed), fixed_time_step
