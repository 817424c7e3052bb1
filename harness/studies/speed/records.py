"""Rows of the benchmark: costs of judgements, and their growth with the number of items."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.reports.columns import cell, column, decimal, milliseconds, percent, row
from steadyload.runs.costs import load_explained
from steadyload.statistics.estimate import Estimate
from steadyload.studies.speed.measuring import ENOUGH, POSITIONS

LATE = 50
"""Number of items from which on the second exponent is fitted."""


def _titled(spec: str) -> str:
    return method_key(make_method(spec)).title


def _rate(microseconds: Estimate | None) -> str:
    """Layouts a second with the interval, with three significant digits."""
    if microseconds is None:
        return cell(None)
    ends = (microseconds.value, microseconds.high, microseconds.low)
    value, low, high = (f"{float(f'{1e6 / end:.2e}'):,.0f}" for end in ends)
    return f"{value} [{low}, {high}]"


class _OfMethod:
    """A row of a method, by its spec."""

    method: str

    @property
    def key(self) -> MethodKey:
        """Name of the method on pages."""
        return method_key(make_method(self.method))


@row
class CaseSet:
    """A set of layouts that is judged, and the CPU time of a layout without a judgement [us].

    ``loop``: in a Python loop that does nothing. ``empty``: a verdict with its times, of a method
    that does nothing.
    """

    name: str
    layouts: int
    mean_items: float
    loop: Estimate
    empty: Estimate


@row
class Cost(_OfMethod):
    """CPU times of a method on a set of layouts [us], and shares of its steps.

    Times are medians of the repeats; what a method cannot do is None, such as batches.
    """

    cases: str = column()
    method: str = column(form=_titled)
    n: int = column(about="layouts that are judged")
    missing: int = column(about="layouts left out because they had no verdict in time")
    placements: int | None = column(about="in a session, up to the first that fails")
    judge: Estimate | None = column("judge, us", milliseconds, "one by one", default=None)
    batch: Estimate | None = column("batch, layouts/s", _rate, "all at once", default=None)
    placement: Estimate | None = column("placement, us", milliseconds, default=None)
    position: Estimate | None = column("us a position", milliseconds, default=None)
    steps: int | None = column(default=None)
    kept: Estimate | None = column("kept %", percent, default=None)
    asked: Estimate | None = column("asked %", percent, default=None)


@row
class GrowthPoint(_OfMethod):
    """CPU time of a judgement at a number of items: the median of layouts that are stable."""

    scene: str
    method: str = column(form=_titled)
    items: int = column("J")
    joined: int = column(about="layouts that are made of several, side by side")
    judge: Estimate = column("judge, us", milliseconds)
    batch: Estimate | None = column("in a batch, us", milliseconds, "without a verdict of its own")


@row
class Growth(_OfMethod):
    """Exponents of the number of items in the cost; None where there is no interval."""

    scene: str
    method: str = column(form=_titled)
    exponent: Estimate | None = column("judge: exponent", decimal)
    late: Estimate | None = column(f"from {LATE} items on", decimal)
    batch: Estimate | None = column("in a batch: exponent", decimal)


@row
class Found:
    """A run of the benchmark, of which its page is made and which is kept as JSON.

    Attributes:
        quick: whether it is a short run on fewer layouts.
        load: most processes that wanted to run, one of them ours; None where it is not known.
        patience: seconds after which a judgement is given up.
        cases: sets of layouts, that of labelled ones first.
        made_with: with the kind of ``processor``; times on other kinds are not compared.
    """

    date: str
    quick: bool
    load: float | None
    patience: float
    cases: Sequence[CaseSet]
    costs: Sequence[Cost]
    growth: Sequence[Growth]
    points: Sequence[GrowthPoint]
    made_with: Mapping[str, str]

    aim: ClassVar[float] = 1.3
    """Exponent of growth that is aimed at."""

    positions: ClassVar[int] = POSITIONS
    enough: ClassVar[float] = ENOUGH

    @property
    def load_explained(self) -> str:
        """Sentence on the load of the machine."""
        return load_explained(self.load)
