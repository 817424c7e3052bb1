"""CPU and wall time of a judgement by phase, and the limit on it."""

from __future__ import annotations

import time
from dataclasses import dataclass
from enum import StrEnum

from steadyload.time_limit import TimeLimit


class Phase(StrEnum):
    """Phase of a judgement that time is spent on; static methods have no phases, only a total."""

    BUILD = "build"
    STEP = "step"
    READ = "read"


@dataclass(frozen=True, slots=True)
class Seconds:
    """Time by phase [s]; ``total`` also holds what belongs to no phase."""

    build: float = 0.0
    step: float = 0.0
    read: float = 0.0
    total: float = 0.0

    def shared(self, count: int) -> Seconds:
        """The share of each of some; of none nothing."""
        parts = max(count, 1)
        return Seconds(self.build / parts, self.step / parts, self.read / parts, self.total / parts)


class Stopwatch:
    """CPU and wall time by phase, and the limit on both.

    Args:
        timeout: CPU time that a judgement may take, as :mod:`steadyload.time_limit` counts it, in
            the thread that makes the watch; wall time is its backstop [s]. None: no limit.

    Raises:
        NumberError: the limit is no finite number above 0.
    """

    def __init__(self, timeout: float | None = None) -> None:
        self._limit = TimeLimit(timeout, "verdict")
        self.timeout = self._limit.seconds
        self._spent: dict[Phase, list[float]] = {}
        self._start = self._last = (time.process_time(), time.perf_counter())
        self._phase: Phase | None = None

    def enter(self, phase: Phase | None) -> None:
        """Begin ``phase``: the time that follows belongs to it."""
        now = (time.process_time(), time.perf_counter())
        if self._phase is not None:
            spent = self._spent.setdefault(self._phase, [0.0, 0.0])
            spent[0] += now[0] - self._last[0]
            spent[1] += now[1] - self._last[1]
        self._phase, self._last = phase, now

    def check(self) -> None:
        """End the judgement when its time is up.

        Raises:
            TimeoutExpiredError: the limit on CPU time is exceeded, or its backstop.
        """
        self._limit.check()

    def stop(self) -> tuple[Seconds, Seconds]:
        """CPU and wall time so far."""
        cpu_start, wall_start = self._start
        if self._last is self._start:  # no phase has begun
            return (
                Seconds(total=time.process_time() - cpu_start),
                Seconds(total=time.perf_counter() - wall_start),
            )
        self.enter(None)
        totals = self._last[0] - cpu_start, self._last[1] - wall_start
        cpu, wall = (
            Seconds(
                **{phase.value: spent[clock] for phase, spent in self._spent.items()},
                total=totals[clock],
            )
            for clock in (0, 1)
        )
        return cpu, wall
