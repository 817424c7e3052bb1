"""A limit in seconds: CPU time, and ten times as much wall time as a backstop.

How long something takes on a busy machine depends on what else runs there; its CPU time hardly
does. So CPU time ends a judgement, and a busy machine changes no verdict. Wall time ends what waits
and computes nothing.

Whose CPU time counts depends on where it is judged. In a thread of a service it is that of the
thread: threads that judge side by side do not charge one another. All engines and the core compute
in the thread that calls them, but Rapier, which computes in a thread of its own: in a service, only
the backstop ends it at the right order of time. A process that multiprocessing started, as workers
of a pool are, judges one thing at a time in its main thread; all of its CPU time counts there.
"""

from __future__ import annotations

import math
import multiprocessing
import threading
import time
from collections.abc import Callable

from steadyload.errors import FailedError
from steadyload.numbers import seconds_allowed

BACKSTOP = 10.0
"""Wall time that is allowed, in units of the CPU time that is."""


def cpu_clock() -> Callable[[], float]:
    """The clock of the CPU time that counts for what this thread computes [s]."""
    in_main_thread = threading.current_thread() is threading.main_thread()
    if in_main_thread and multiprocessing.parent_process() is not None:
        return time.process_time
    return time.thread_time


def seconds_of_process(pid: int) -> float:
    """CPU time of another process so far [s]; 0 where the system does not tell."""
    try:
        # As clock_getcpuclockid(3) makes it on Linux.
        return time.clock_gettime(~pid << 3 | 2)
    except (AttributeError, OSError):
        return 0.0


def exceeded(limit: float, cpu: float, wall: float) -> str | None:
    """Which time is over, such as "2 s of CPU time"; None where there is some left.

    Args:
        limit: CPU time that is allowed [s].
        cpu: CPU time that was spent [s].
        wall: wall time that has passed [s].
    """
    if cpu > limit:
        return f"{limit:g} s of CPU time"
    if wall > BACKSTOP * limit:
        return f"{BACKSTOP * limit:g} s of wall time"
    return None


class TimeoutExpiredError(FailedError):
    """Something took longer than it may; a judgement becomes a verdict with status ``timeout``."""


class TimeLimit:
    """A limit on what this thread computes from now on.

    Args:
        seconds: CPU time that is allowed [s]; None: no limit.
        sought: what is computed, for the message.

    Raises:
        NumberError: the limit is no finite number above 0.
    """

    def __init__(self, seconds: float | None, sought: str) -> None:
        self.seconds = seconds_allowed(seconds)
        self._sought = sought
        if seconds is not None:
            self._clock = cpu_clock()
            self._begun = self._clock(), time.perf_counter()

    def check(self) -> None:
        """End what is computed when its time is up.

        Raises:
            TimeoutExpiredError: the limit on CPU time is exceeded, or its backstop.
        """
        if self.seconds is None:
            return
        cpu, wall = self._clock() - self._begun[0], time.perf_counter() - self._begun[1]
        if (over := exceeded(self.seconds, cpu, wall)) is not None:
            raise TimeoutExpiredError(f"no {self._sought} within {over}")

    def left(self) -> float:
        """CPU time that is left [s], infinite without a limit."""
        if self.seconds is None:
            return math.inf
        return self.seconds - (self._clock() - self._begun[0])
