"""What another distribution might bring: a judge that does its process harm, and plain units."""

import ctypes
import math
import multiprocessing
import os
import re
import signal
import threading
import time
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cache
from pathlib import Path

import pymunk

from steadyload.core.library import HELD
from steadyload.engines.quantities import quantity
from steadyload.methods.contract.method import STABLE, BatchVerdicts, Method
from steadyload.time_limit import cpu_clock

BAD = "layout-0002"

if os.getenv("OUTSIDE_JUDGES_KILL"):
    with Path(os.environ["OUTSIDE_JUDGES_KILL"]).open("a") as deaths:
        deaths.write("|")
    os.kill(os.getpid(), signal.SIGKILL)


class Harm(StrEnum):
    NONE = "none"
    ABORT = "abort"
    ABORT_ONCE = "abort-once"
    EXIT = "exit"
    FAULT = "fault"
    KILL = "kill"
    KILL_PARENT = "kill-parent"
    PREPARE = "prepare"
    SLOW_START = "slow-start"
    HANG = "hang"


@dataclass(frozen=True)
class Parameters:
    harm: Harm = quantity(Harm.NONE, f"what happens on {BAD}")
    pause: float = quantity(0.0, "time a judgement takes", unit="s", least=0)
    work: float = quantity(0.0, "CPU time a judgement takes", unit="s", least=0)


class Harmful(Method):
    """Finds every layout stable, and writes down which it was asked about."""

    Parameters = Parameters

    def prepare(self, item_count=0):
        if self.parameters.harm is Harm.PREPARE and multiprocessing.parent_process():
            raise ZeroDivisionError("nothing was prepared")
        if self.parameters.harm is Harm.SLOW_START and multiprocessing.parent_process():
            _prepare_slowly()

    def _judge(self, layout, watch):
        folder = Path(os.environ["OUTSIDE_JUDGES"])
        with (folder / "judged.txt").open("a") as file:
            file.write(f"{layout.name}\n")
        time.sleep(self.parameters.pause)
        list(burns(Words((self.parameters.work,))))
        if layout.name == BAD and not (folder / "harmless").exists():
            match self.parameters.harm:
                case Harm.ABORT:
                    abort_in_chipmunk()
                case Harm.ABORT_ONCE:
                    (folder / "harmless").touch()
                    abort_in_chipmunk()
                case Harm.EXIT:
                    ctypes.CDLL(None).exit(3)
                case Harm.FAULT:
                    fault_in_the_core()
                case Harm.KILL:
                    os.kill(os.getpid(), signal.SIGKILL)
                case Harm.HANG:
                    compute_without_end()
                case Harm.KILL_PARENT:
                    os.kill(os.getppid(), signal.SIGKILL)
                    time.sleep(60)
        return STABLE


class HarmfulBatches(Harmful):
    """The same, which judges batches."""

    def evaluate(self, batch):
        for layout in batch:
            self._judge(layout, None)
        return BatchVerdicts.of_steps(batch, batch.item_counts)


@cache
def _prepare_slowly():
    """Take 2 CPU seconds, once a process, as a compiler does."""
    list(burns(Words((2.0,))))


def compute_without_end():
    """A native call that holds Python's lock, so that nothing in its process can end it."""
    re.match("(a|aa)+$", 99 * "a" + "b")


def abort_in_chipmunk():
    """Chipmunk ends the process itself when it is given a box of no size that there is."""
    pymunk.Body(1.0, pymunk.moment_for_box(1.0, (math.nan, 0.1)))


def fault_in_the_core():
    """The C library of this package reads memory at an address that is nobody's."""
    HELD.sl_work_free(8)


@dataclass(frozen=True)
class Words:
    """A unit of work whose parts are texts, or anything else."""

    words: tuple

    def __len__(self):
        return len(self.words)

    def without(self, done):
        return replace(self, words=self.words[done:])

    def describe(self, part):
        return f"the word {self.words[part]!r}"


def variables(unit):
    return (os.getenv(word) for word in unit.words)


def pauses(unit):
    for seconds in unit.words:
        time.sleep(seconds)
        yield seconds


def cpu_clocks(unit):
    """The clocks of a worker: of its main thread, and of another one."""
    found = [cpu_clock().__name__]
    beside = threading.Thread(target=lambda: found.append(cpu_clock().__name__))
    beside.start()
    beside.join()
    yield found


def burns(unit):
    for seconds in unit.words:
        end = time.process_time() + seconds
        while time.process_time() < end:
            pass
        yield seconds


def told_why(unit, part, reason):
    return part, reason


def processes(unit):
    return (os.getpid() for _ in unit.words)


def locks(unit):
    return (threading.Lock() for _ in unit.words)


def no_crash(unit, part, reason):
    raise AssertionError(reason)


class _OddError(Exception):
    def __init__(self, one, two):
        super().__init__(f"{one} and {two}")


def odd_failures(unit):
    raise _OddError("this", "that")
