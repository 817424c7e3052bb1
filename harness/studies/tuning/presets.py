"""Results of tuned presets: rows of their page. Shares are 0 to 1, times in ms a layout."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from statistics import fmean
from typing import Any

from steadyload.methods.tuned import TUNED
from steadyload.reports.columns import (
    column,
    compact,
    general,
    names,
    percent,
    plain_percent,
    row,
)
from steadyload.runs.evaluation import MethodEvaluation
from steadyload.statistics.estimate import Estimate
from steadyload.studies.tuning.gains import SearchGain
from steadyload.studies.tuning.searching import Algorithm, Gene, Point, Searching

BUDGETS = (1.0, 3.0, 10.0, 30.0)
"""Budgets in the table of prices [ms a layout]."""

DEAR = "ps3"
"""The family of which a page compares the cost with that of tuned methods."""

START = "label"
"""The family of the genotype with which a search begins."""


@row
class Step:
    """Parameters on the way from the paper's values to the tuned ones."""

    engine: str = column()
    title: str = column("parameters")
    found: MethodEvaluation
    gain: Estimate | None = column("more than the row above, points", percent)


@row
class Variant:
    """The tuned parameters with some of them changed; differences are to the tuned ones."""

    engine: str = column()
    change: str = column()
    values: str = column("to")
    found: MethodEvaluation
    accuracy_change: Estimate = column("change of accuracy", percent)
    cost_change: float = column("cost factor", compact)


@row
class Seed:
    """The search with one seed: its best genotype on validation, and once on test."""

    seed: int = column(left=True)
    fitness: float = column(form="{:.4f}".format)
    validation: float = column("validation %", plain_percent)
    test: MethodEvaluation
    values: Mapping[str, Any] = column("{}", about="of parameters that differ between seeds")


@row
class Luck:
    """A search with several seeds; means and ranges of their results on test."""

    engine: str
    seeds: Sequence[Seed]
    accuracy: Estimate
    cpu: Estimate
    genes: int


@row
class Bought:
    """The most accurate of all judged parameter sets whose modelled cost is within a budget."""

    engine: str = column()
    budget: float = column("budget ms", general, left=True)
    validation: float = column("accuracy where chosen %", plain_percent)
    test: MethodEvaluation
    values: str = column("parameters")


@row
class Carried:
    """Parameters tuned on one engine, judged on another, and compared with those tuned there."""

    tuned_on: str = column("tuned on")
    judged_on: str = column("judged on")
    found: MethodEvaluation
    ignored: Sequence[str] = column("without effect there", names, left=True)

    @property
    def gain(self) -> float:
        """Accuracy minus that of the engine's own parameters."""
        return 0.0 if self.found.ahead is None else -self.found.ahead.value

    @property
    def outcome(self) -> str:
        """Of the engine's own parameters: ``own``, or significantly ``better`` or ``worse``."""
        if self.found.ahead is None:
            return "own"
        is_alike = self.found.ahead.low <= 0.0 <= self.found.ahead.high
        return "alike" if is_alike else "better" if self.gain < 0.0 else "worse"


@row
class OnEngine:
    """Tuned parameters of an engine, and methods that are compared with them on the same cases."""

    engine: str
    tuned: MethodEvaluation
    others: Sequence[MethodEvaluation]


@row
class OnPart:
    """Tuned parameters on a part of a labelled set; ``carried``: also those of other engines."""

    part: str
    tested: Sequence[OnEngine]
    carried: Sequence[Carried]

    @property
    def rows(self) -> list[MethodEvaluation]:
        """The tuned methods, each before the others of its engine."""
        return [row for one in self.tested for row in (one.tuned, *one.others)]

    @property
    def outcomes(self) -> Counter[str]:
        """How many pairs of engines are each :attr:`Carried.outcome`."""
        return Counter(one.outcome for one in self.carried)

    @property
    def at_home(self) -> tuple[float, float, float]:
        """Mean accuracy on the engine that parameters were tuned on, on others, and the lead."""
        own, away = (
            fmean(one.found.accuracy.value for one in self.carried if (one.outcome == "own") is own)
            for own in (True, False)
        )
        return own, away, own - away


@row
class Found:
    """Results of searches, and of presets on other cases; without these a page of searches alone.

    ``fronts``: of all searches of an engine, where they judged. ``costs_explained``: sentences on
    the measured CPU times.
    """

    genes: Sequence[Gene]
    searches: Sequence[Searching]
    algorithms: Sequence[Algorithm]
    made_with: Mapping[str, str]
    parts: Sequence[OnPart] = ()
    gains: Sequence[SearchGain] = ()
    steps: Sequence[Step] = ()
    left_out: Sequence[Variant] = ()
    physical: Sequence[Variant] = ()
    bought: Sequence[Bought] = ()
    fronts: Sequence[Point] = ()
    luck: Sequence[Luck] = ()
    costs_explained: str = ""

    @property
    def shown(self) -> list[MethodEvaluation]:
        """Tuned parameters, PS_3 and the start of the search, on every engine."""
        rows = [row for part in self.parts for row in part.rows]
        return [row for row in rows if row.method.family in (TUNED, DEAR, START)]

    @property
    def finders(self) -> list[Searching]:
        """The first search on every engine, which found its preset."""
        first = {one.engine: one for one in reversed(self.searches)}
        return [first[engine] for engine in sorted(first)]

    @property
    def largest(self) -> list[Searching]:
        """The search on every engine that judged most."""
        by_size = sorted(self.searches, key=lambda one: one.genotypes)
        return list({one.engine: one for one in by_size}.values())
