"""Results of tuned presets: rows of their page.

Shares are 0 to 1, times in ms a layout.
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Mapping, Sequence
from statistics import fmean
from typing import Any, NamedTuple

from steadyload.reports.columns import (
    column,
    compact,
    factor,
    general,
    milliseconds,
    percent,
    plain_percent,
    row,
    significant,
)
from steadyload.runs.evaluation import MethodEvaluation
from steadyload.statistics.estimate import Estimate
from steadyload.studies.tuning.searching import Algorithm, Point, Searched, Searching

BUDGETS = (1.0, 3.0, 10.0, 30.0)
"""Budgets in the table of prices [ms a layout]."""

AIMED = {"ps3": "PS_3", "ps5": "PS_5"}
"""Families that a tuned method is to exceed in accuracy."""

DEAR = "ps3"
"""The family whose cost is the reference of the cost limit of a tuned method."""

START = "label"
"""The family of the genotype with which a search begins."""

AS_LABELS = {"t_max=0.3", "eps_t=10", "eps_r=10", "between_steps=reseat", "criterion=adams"}
"""Parameters of a simulation under the criterion of the labels."""

SHARE_OF_COST = 0.2
ACCURATE = 0.98


class Target(NamedTuple):
    """A target of a tuned method, whether it is reached, and the measured value."""

    title: str
    met: bool
    said: str


@row
class Step:
    """Parameters on the way from the paper's values to the tuned ones."""

    title: str = column("parameters")
    n: int = column()
    accuracy: Estimate = column("accuracy %", percent)
    gain: Estimate | None = column("more than the row above, points", percent)
    cpu: Estimate = column("CPU ms", milliseconds)


@row
class Variant:
    """The tuned parameters with some of them changed; differences are to the tuned ones."""

    engine: str
    change: str = column()
    values: str = column("to")
    n: int = column()
    accuracy: Estimate = column("accuracy %", percent)
    accuracy_change: Estimate = column("change of accuracy", percent)
    cost_ms: float = column("cost ms", significant)
    cost_change: float = column("cost factor", compact)

    @property
    def loses(self) -> bool:
        """Whether the change costs accuracy significantly."""
        return self.accuracy_change.high < 0.0


@row
class Seed:
    """The search with one seed: its best genotype on validation, and once on test."""

    seed: int = column(left=True)
    fitness: float = column(form="{:.4f}".format)
    validation: float = column("validation %", plain_percent)
    n: int = column()
    test: Estimate = column("test %", percent)
    cpu: Estimate = column("CPU ms", milliseconds)
    values: Mapping[str, Any] = column("{}", about="of parameters that differ between seeds")


@row
class Luck:
    """A search with several seeds; means and ranges of their results on test."""

    seeds: Sequence[Seed]
    accuracy: Estimate
    cpu: Estimate
    genes: int


@row
class Bought:
    """The most accurate of all judged parameter sets whose modelled cost is within a budget."""

    engine: str = column()
    budget: float = column("budget ms", general, left=True)
    values: str = column("parameters")
    n: int = column()
    validation: float = column("accuracy where chosen %", plain_percent)
    accuracy: Estimate
    cpu: Estimate


def _bought(one: Bought | None) -> str:
    if one is None:
        return "nothing"
    return f"{percent(one.accuracy)}, {significant(one.cpu.value)} ms"


@row
class Budget:
    """Sets within a budget by engine, None where there is none."""

    budget: float = column("budget ms", general, left=True)
    bought: Mapping[str, Bought | None] = column("{}", _bought)

    @property
    def some(self) -> list[Bought]:
        """Those that there are, the most accurate first."""
        found = [one for one in self.bought.values() if one is not None]
        return sorted(found, key=lambda one: (one.accuracy.value, one.engine), reverse=True)


class Cell(NamedTuple):
    """Faults and cost of parameters tuned on one engine and judged on another."""

    over: Estimate
    under: Estimate
    cpu: Estimate


def _faults(cell: Cell) -> str:
    over, under = (plain_percent(share.value) for share in (cell.over, cell.under))
    return f"{over} / {under}, {significant(cell.cpu.value)} ms"


@row
class Carried:
    """Parameters tuned on one engine, judged on another; ``ahead``: accuracy of the second one's
    own minus theirs, None where they are its own; ``ignored``: parameters without effect there.
    """

    tuned_on: str
    judged_on: str
    accuracy: Estimate
    ahead: Estimate | None
    cell: Cell
    ignored: Sequence[str]

    @property
    def gain(self) -> float:
        """Accuracy minus that of the engine's own parameters."""
        return 0.0 if self.ahead is None else -self.ahead.value

    @property
    def outcome(self) -> str:
        """Whether the engine's own parameters are significantly ``better``, ``worse``, or
        ``alike``.
        """
        if self.ahead is None or self.ahead.low <= 0.0 <= self.ahead.high:
            return "alike"
        return "better" if self.gain < 0.0 else "worse"


@row
class TunedOn:
    """Parameters tuned on one engine, by the engine that they are judged on."""

    tuned_on: str = column("tuned on, judged on")
    accuracy: Mapping[str, Estimate] = column("{}", percent)
    cells: Mapping[str, Cell] = column("{}", _faults)


@row
class Transfer:
    """All pairs of engines on the same cases."""

    part: str
    carried: Sequence[Carried]

    @property
    def rows(self) -> list[TunedOn]:
        """The pairs as matrices."""
        own: dict[str, list[Carried]] = {}
        for one in self.carried:
            own.setdefault(one.tuned_on, []).append(one)
        return [
            TunedOn(
                tuned_on,
                {one.judged_on: one.accuracy for one in ones},
                {one.judged_on: one.cell for one in ones},
            )
            for tuned_on, ones in own.items()
        ]

    @property
    def foreign(self) -> list[Carried]:
        """The pairs of different engines."""
        return [one for one in self.carried if one.ahead is not None]

    @property
    def counts(self) -> list[int]:
        """Numbers of cases."""
        return sorted({one.accuracy.n for one in self.carried})

    @property
    def at_home(self) -> float:
        """Mean accuracy of parameters on the engine that they were tuned on."""
        return fmean(one.accuracy.value for one in self.carried if one.ahead is None)

    @property
    def away(self) -> float:
        """Mean accuracy of parameters on another engine."""
        return fmean(one.accuracy.value for one in self.foreign)

    @property
    def lead(self) -> float:
        """Difference of the two [points]."""
        return 100.0 * (self.at_home - self.away)

    @property
    def outcomes(self) -> Mapping[str, int]:
        """How many of these are each :attr:`Carried.outcome`."""
        return Counter(one.outcome for one in self.foreign)


@row
class Tested:
    """Tuned parameters of one engine and what they are compared with, on the same cases.

    ``others``: each with the difference of accuracy and the ratio of CPU times, tuned against it.
    ``steps``: from the paper's values to the tuned ones. ``left_out``: parts of the tuned
    parameters put back to the start of the search; ``physical``: to those of the reference.
    ``front``: of all searches, where they judged. ``luck``: None without searches that differ in
    their seed alone.
    """

    engine: str
    tuned: MethodEvaluation
    others: Sequence[MethodEvaluation]
    steps: Sequence[Step] = ()
    left_out: Sequence[Variant] = ()
    physical: Sequence[Variant] = ()
    front: Sequence[Point] = ()
    bought: Mapping[float, Bought | None] = dataclasses.field(default_factory=dict)
    luck: Luck | None = None

    @property
    def rows(self) -> list[MethodEvaluation]:
        """The tuned method, and the others."""
        return [self.tuned, *self.others]

    @property
    def start(self) -> MethodEvaluation | None:
        """The genotype that a search begins with."""
        return next((one for one in self.others if one.method.family == START), None)

    @property
    def targets(self) -> list[Target]:
        """The targets, of which those without a method to compare with are left out."""
        by_family = {one.method.family: one for one in self.others}
        found = []
        for family, title in AIMED.items():
            ahead = by_family[family].ahead if family in by_family else None
            if ahead is not None:
                said = f"{percent(ahead)} points"
                found.append(Target(f"beats {title}", ahead.low > 0.0, said))
        ratio = by_family[DEAR].cost_ratio if DEAR in by_family else None
        if ratio is not None:
            title = "costs at most a fifth of PS_3's CPU time"
            said = f"{factor(ratio)} of it{_unsure(ratio, SHARE_OF_COST)}"
            found.append(Target(title, ratio.value <= SHARE_OF_COST, said))
        right, title = self.tuned.accuracy, f"accuracy of at least {100 * ACCURATE:g} %"
        said = f"{percent(right)} %{_unsure(right, ACCURATE)}"
        return [*found, Target(title, right.value >= ACCURATE, said)]

    @property
    def missed(self) -> list[Target]:
        """Targets that are not reached."""
        return [target for target in self.targets if not target.met]


def _unsure(found: Estimate, bar: float) -> str:
    return ", the interval holds the bar" if found.low < bar < found.high else ""


@row
class OnPart:
    """Tuned parameters on one part of a labelled set, engine by engine."""

    part: str
    tested: Sequence[Tested]
    transfer: Transfer | None = None

    @property
    def rows(self) -> list[MethodEvaluation]:
        """The tuned methods, each before the others of its engine."""
        return [row for one in self.tested for row in one.rows]

    @property
    def mean(self) -> float:
        """Mean accuracy over engines."""
        return fmean(one.tuned.accuracy.value for one in self.tested)

    @property
    def is_accurate(self) -> bool:
        """Whether that is as high as it should be."""
        return self.mean >= ACCURATE

    @property
    def starts(self) -> dict[str, MethodEvaluation]:
        """The start of the search, by engine."""
        return {one.engine: one.start for one in self.tested if one.start is not None}

    @property
    def as_labels(self) -> bool:
        """Whether all starts are simulations under the criterion of the labels."""
        specs = [one.method.spec for one in self.starts.values()]
        return all(set(spec.partition(":")[2].split(",")) >= AS_LABELS for spec in specs)

    @property
    def right_already(self) -> list[float]:
        """The least and the largest accuracy of a start."""
        right = [one.accuracy.value for one in self.starts.values()]
        return [min(right), max(right)] if right else []

    @property
    def to_gain(self) -> float:
        """The most accuracy that a search could add."""
        return 1.0 - self.right_already[0]

    @property
    def by_gain(self) -> dict[str, list[str]]:
        """Engines by whether the interval of what the search adds includes 0 or excludes it."""
        found: dict[str, list[str]] = {"includes": [], "excludes": []}
        for engine, start in self.starts.items():
            gain = start.ahead
            if gain is not None:
                found["includes" if gain.low <= 0.0 <= gain.high else "excludes"].append(engine)
        return {word: engines for word, engines in found.items() if engines}

    @property
    def some_robust(self) -> bool:
        """Whether labels of some cases are known to be robust."""
        return any(one.robust.n for one in self.rows)


@row
class Found:
    """Results of searches, and those of presets on other cases, where they were judged.

    ``costs_explained``: sentences on the measured CPU times.
    """

    searched: Sequence[Searched]
    searches: Sequence[Searching]
    algorithms: Sequence[Algorithm] = ()
    parts: Sequence[OnPart] = ()
    costs_explained: str = ""
    made_with: Mapping[str, str] = dataclasses.field(default_factory=dict)

    @property
    def tested(self) -> list[Tested]:
        """Tuned parameters on all parts."""
        return [one for each in self.parts for one in each.tested]

    @property
    def shown(self) -> list[MethodEvaluation]:
        """Tuned parameters, PS_3 and the start of the search, on every engine."""
        return [
            row
            for one in self.tested
            for row in one.rows
            if row is one.tuned or row.method.family in (DEAR, START)
        ]

    @property
    def left_out(self) -> list[Variant]:
        """Parts of the tuned parameters put back, on all engines."""
        return [variant for one in self.tested for variant in one.left_out]

    @property
    def budgets(self) -> list[Budget]:
        """All budgets."""
        return [
            Budget(budget, {one.engine: one.bought[budget] for one in self.tested})
            for budget in BUDGETS
            if all(budget in one.bought for one in self.tested)
        ]

    @property
    def bought(self) -> list[Bought]:
        """All that is bought on any engine."""
        return [b for one in self.tested for b in one.bought.values() if b is not None]

    @property
    def largest(self) -> list[Searching]:
        """The search on every engine that judged most."""
        by_size = sorted(self.searches, key=lambda one: one.genotypes)
        return list({one.engine: one for one in by_size}.values())
