"""All methods on a part of a labelled set, and what tables and charts show of them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from steadyload.app.recommend.front import Measured, on_front
from steadyload.layouts.model.question import Question
from steadyload.methods.naming import MethodKey
from steadyload.reports.columns import (
    compact,
    fixed,
)
from steadyload.runs.agreement import AgreementMatrix, Pair
from steadyload.runs.comparison import Alike, Family, PairTest
from steadyload.runs.evaluation import (
    ALL,
    Evaluation,
    MethodEvaluation,
)
from steadyload.runs.paper import Paper
from steadyload.statistics.error_costs import cheapest_by_ratio
from steadyload.statistics.estimate import NOTHING, Estimate
from steadyload.statistics.metrics import agreement
from steadyload.studies.evaluation.costing import Growth, body_substeps_of, cost_in
from steadyload.studies.evaluation.error_places import (
    CaseBin,
    MarginBin,
)
from steadyload.studies.evaluation.parts import (
    CasePart,
    OnLabelledCases,
    OriginBin,
    SizeCost,
    size_costs,
)
from steadyload.studies.evaluation.rows import (
    Against,
    Beside,
    Cell,
    Cheapest,
    Point,
    Result,
    Timing,
)
from steadyload.studies.evaluation.watched import Watch

YARDSTICK = "ps3@mujoco"
"""The method to which cost ratios refer, where it was timed."""

RATIOS = (0.01, 0.1, 1.0, 10.0, 100.0)
"""Costs of an overestimation in a table, in units of that of an underestimation."""

_FEW, _LINES = 10, 7
_ROUNDED = 0.0101
"""Largest difference [ms] of a mean of printed numbers to a printed mean, rounded to 0.01 ms."""


@dataclass(frozen=True)
class JudgedSet(OnLabelledCases):
    """All methods on a part of a labelled set.

    Attributes:
        tests: by group, all pairs; of few item lists each method against one.
        tunings: by spec of a simulation, a text of its parameters; equal for equal parameters.
        answers: of all methods to all cases, without shares.
        classes, margins: empty where the set has none.
        without_label: cases that were judged and have no label of the question, by the way in which
            labelling ended.
        failing: by spec, accuracy on cases whose label is a failing step.
        stable: share of the other cases, on which the constant verdict *stable* is right.
        growth: by spec, of the CPU time; empty without a time limit, as the costs of bins.
        spans: the cases by the sizes that the page answers for; empty without a time limit.
        origins: the cases by origin; empty without a time limit, or a customer's pallet.
        timing: None where judgements have a time limit, and times are of judging.
        paper: the table of the paper; None where the question is not the paper's.
    """

    question: Question
    evaluation: Evaluation
    layouts: int
    timing: Timing | None
    tests: Mapping[str, Family[MethodKey]]
    tunings: Mapping[str, str]
    answers: AgreementMatrix
    classes: Sequence[CaseBin]
    sizes: Sequence[CaseBin]
    margins: Sequence[MarginBin]
    watched: Sequence[Watch]
    without_label: Mapping[str, int]
    paper: Paper | None
    failing: Mapping[str, Estimate]
    stable: Estimate
    growth: Mapping[str, Growth]
    spans: Sequence[CasePart] = ()
    origins: Sequence[CasePart] = ()

    @property
    def yardstick(self) -> MethodKey | None:
        """The method that shares of CPU time refer to; None where it was not timed."""
        return self.timing.yardstick if self.timing else None

    @property
    def groups(self) -> tuple[str, ...]:
        """All cases, then the scenarios."""
        return self.evaluation.groups

    @property
    def alike(self) -> Alike[MethodKey]:
        """Tests of methods that do not differ significantly from the best."""
        return self.tests[ALL].versus(self.best.method).alike

    @cached_property
    def front(self) -> list[MethodEvaluation]:
        """Methods than which no cheaper one is as accurate, by rising cost; none without times."""
        specs = on_front(map(Measured.of, self.evaluation.comparable))
        return [self.evaluation.row(spec) for spec in specs]

    @cached_property
    def rows(self) -> Mapping[str, Sequence[Result]]:
        """A row a method, by group."""
        return {group: self._results(group) for group in self.groups}

    @cached_property
    def results(self) -> Sequence[Result]:
        """A row a method, on all cases."""
        return self.rows[ALL]

    @property
    def charted(self) -> Mapping[str, Sequence[Result]]:
        """The methods that a reader of the chart may choose from, by title of a group of cases."""
        titles = {group: "all scenarios" if group == ALL else group for group in self.groups}
        parts = {part.name: part.results for part in (*self.origins, *self.spans)}
        return {title: self.rows[group] for group, title in titles.items()} | parts

    @property
    def bins(self) -> Sequence[OriginBin]:
        """All cases by number of boxes, then those of every origin."""
        parts = [("all cases", self.sizes), *((part.name, part.sizes) for part in self.origins)]
        return [OriginBin(name, own) for name, sizes in parts for own in sizes]

    @property
    def size_costs(self) -> Mapping[str, Sequence[SizeCost]]:
        """Costs by the name of a bin of the number of boxes."""
        return size_costs(self.sizes, self.origins, self.evaluation.judged.keys)

    @cached_property
    def few(self) -> list[Result]:
        """The methods of charts: the front, the yardstick, and the best of further families."""
        compared = {m.method.spec for m in self.evaluation.comparable}
        results = {s: own for own in self.results if (s := own.own.method.spec) in compared}
        front = (own.method.spec for own in self.front)
        shown = [spec for spec in dict.fromkeys((*front, YARDSTICK)) if spec in results]
        families = {results[spec].own.method.family for spec in shown}
        for own in sorted(results.values(), key=lambda one: -one.own.accuracy.value):
            if len(shown) < _FEW and own.own.method.family not in families:
                families.add(own.own.method.family)
                shown.append(own.own.method.spec)
        return [own for spec, own in results.items() if spec in shown[:_FEW]]

    def _results(self, group: str) -> list[Result]:
        tests, timing, own = self.tests[group], self.timing, self.evaluation
        shares = timing.shares[group] if timing else {}
        yard = self.paper and self.yardstick and self.paper.row_of(self.yardstick)
        against = {test.first: test for test in tests.tests if tests.against}
        found = []
        for one in own.rows[group]:
            spec = one.method.spec
            share = "1" if self.yardstick == one.method else shares.get(spec)
            like = self.paper.like(one.method) if self.paper else None
            more: dict[str, Any] = {"cost": cost_in(own, spec, group)}
            if group == ALL:
                by = {name: own.row(spec, name) for name in self.groups}
                more |= {
                    "classes": {f"{b.name} (n {b.cases})": b.accuracy[spec] for b in self.classes},
                    "sizes": {f"{b.name} (n {b.cases})": b.accuracy[spec] for b in self.sizes},
                    "mean_cpu": {
                        f"{b.name} (n {b.cases})": b.costs[spec].mean
                        for b in self.sizes
                        if spec in b.costs
                    },
                    "scenarios": {name: by[name].accuracy for name in self.groups[1:]},
                    "cpu_by": {
                        name: by[name].cpu.value if by[name].cpu.n else None
                        for name in self.groups[1:]
                    },
                    "cost_at": {
                        f"{ratio:g}": one.errors.cost(ratio) if one.errors else None
                        for ratio in RATIOS
                    },
                    "alarms": {
                        f"{_span(bin_)} (n {bin_.holding})": bin_.false_alarms[spec]
                        for bin_ in self.margins
                        if bin_.high <= 0.0 and bin_.holding
                    },
                    "fragile_errors": _fragile_errors(one),
                    "multiple": timing.multiples.get(spec) if timing else None,
                    "body_substeps": body_substeps_of(own.judged, spec),
                    "spread": timing.spread.get(spec) if timing and timing.repeats > 1 else None,
                    "versus": against.get(one.method),
                    "failing": self.failing.get(spec),
                    "growth": self.growth.get(spec),
                }
                if self.paper and (printed := self.paper.row_of(one.method)):
                    more |= {
                        "beside": {
                            name: f"{100 * printed.accuracy[name]:.1f} / "
                            f"{100 * by[name].accuracy.value:.1f}"
                            for name in self.paper.among(self.groups)
                        },
                        "paper_wall": printed.runtime[ALL],
                        "paper_share": printed.runtime[ALL] / yard.runtime[ALL] if yard else None,
                    }
            letters = tests.letters.get(one.method)
            found.append(
                Result(one, like.accuracy[group] if like else None, letters, share, **more)
            )
        return found

    @cached_property
    def cheapest(self) -> list[Cheapest]:
        """The methods whose errors cost least, by rising ratio of costs."""
        rows = {m.method.spec: m for m in self.evaluation.comparable}
        shares = {spec: m.errors for spec, m in rows.items() if m.errors is not None}
        return [
            Cheapest(each.least, each.most, rows[each.method]) for each in cheapest_by_ratio(shares)
        ]

    @property
    def cost_results(self) -> list[Result]:
        """Methods on the front, and those whose errors cost least at some ratio."""
        shown = {own.method for own in (*self.front, *(each.own for each in self.cheapest))}
        return [own for own in self.results if own.own.method in shown]

    @property
    def error_costs(self) -> list[Point]:
        """Expected costs of errors over the ratio, of methods that are the cheapest at some."""
        keys = {each.own.method for each in self.cheapest}
        return [
            Point(own.own.method, own.own.method.title, float(ratio), cost)
            for own in self.results
            if own.own.method in keys
            for ratio, cost in own.cost_at.items()
            if cost is not None and cost.value > 0.0
        ]

    @property
    def against(self) -> Mapping[MethodKey, Sequence[Against]]:
        """Every method compared with the yardstick, and with the best one."""
        held = dict.fromkeys(filter(None, [self.yardstick, self.best.method]))
        return {key: self._against(key) for key in held}

    def _against(self, held: MethodKey) -> list[Against]:
        found = {group: tests.versus(held) for group, tests in self.tests.items()}

        def brief(test: PairTest[MethodKey]) -> str:
            return f"{round(100 * test.difference.value, 1) + 0.0:.1f} ({compact(test.corrected)})"

        return [
            Against(test, {g: brief(found[g].of(test.first, held)) for g in self.groups[1:]})
            for test in found[ALL].tests
        ]

    @property
    def differences(self) -> list[Cell]:
        """Differences between the few methods, the most accurate first."""
        few = sorted((own.own for own in self.few), key=lambda m: -m.accuracy.value)
        return [
            Cell(one.method.title, other.method.title, test.difference, not test.significant)
            for one in few
            for other in few
            if one is not other and (test := self.tests[ALL].of(one.method, other.method))
        ]

    @property
    def one_tuning(self) -> Sequence[PairTest[MethodKey]]:
        """Pairs of simulations with one tuning, on two engines; a family of their own."""
        return self._simulations(same_tuning=True)

    @property
    def one_engine(self) -> Sequence[PairTest[MethodKey]]:
        """Pairs of simulations with two tunings, on one engine; a family of their own."""
        return self._simulations(same_tuning=False)

    def _simulations(self, *, same_tuning: bool) -> Sequence[PairTest[MethodKey]]:
        of = self.tunings

        def asked(test: PairTest[MethodKey]) -> bool:
            one, other = test.first, test.second
            return (
                one.spec in of
                and other.spec in of
                and (of[one.spec] == of[other.spec]) == same_tuning
                and (one.engine == other.engine) != same_tuning
            )

        return self.tests[ALL].only(asked).tests

    @property
    def beside_paper(self) -> list[Beside]:
        """Methods of the paper that judge here as there, by group."""
        if self.paper is None:
            return []
        return [
            Beside(one, "all scenarios" if group == ALL else group, [like.accuracy[group]])
            for group in self.paper.among(self.groups)
            for one in self.evaluation.rows[group]
            if (like := self.paper.like(one.method))
        ]

    @property
    def named_alike(self) -> list[Result]:
        """Methods that the paper has, too, or a namesake of."""
        return [own for own in self.results if own.beside]

    @property
    def odd_averages(self) -> str:
        """Methods whose average of times in the paper is not the mean of its scenarios."""
        return ", ".join(
            f"{one.title} {one.runtime[ALL]:.2f} (mean {one.runtime_mean:.2f})"
            for one in (self.paper.rows if self.paper else ())
            if abs(one.runtime_mean - one.runtime[ALL]) > _ROUNDED
        )

    @property
    def lines(self) -> list[MethodEvaluation]:
        """The methods of line charts: the most accurate ones on the front."""
        return sorted(self.front, key=lambda m: m.accuracy.value)[-_LINES:]

    @property
    def by_size(self) -> list[Point]:
        """Accuracy by number of boxes."""
        return [
            Point(own.method, own.method.title, bin_.middle, bin_.accuracy[own.method.spec])
            for own in self.lines
            for bin_ in self.sizes
        ]

    @property
    def cost_by_size(self) -> list[Point]:
        """Median CPU times [ms]; the exponent over all sizes stands in the title."""
        found = []
        for key in (own.method for own in self.lines if own.method.spec in self.growth):
            power = self.growth[key.spec].everything.value
            title = key.title + (f": n^{power:.2f}" if math.isfinite(power) else "")
            found += [
                Point(key, title, bin_.middle, bin_.costs[key.spec].median)
                for bin_ in self.sizes
                if key.spec in bin_.costs
            ]
        return found

    @property
    def false_alarms(self) -> list[Cell]:
        """Of steps that hold by the label, those that a method calls failing."""
        return self._margins("false_alarms", "holding")

    @property
    def misses(self) -> list[Cell]:
        """Of failing steps by the label, those that a method calls holding."""
        return self._margins("misses", "failing")

    def _margins(self, errors: str, counted: str) -> list[Cell]:
        return [
            Cell(
                own.own.method.title,
                f"{bin_.name} (n {getattr(bin_, counted)})",
                getattr(bin_, errors)[own.own.method.spec],
            )
            for own in self.few
            for bin_ in self.margins
            if getattr(bin_, counted)
        ]

    @property
    def agreement(self) -> list[Pair]:
        """How often two of the few methods say the same."""
        judged, keys = self.evaluation.judged, [own.own.method for own in self.few]
        return [
            Pair(
                one.title, other.title,
                NOTHING if one == other
                else agreement(judged.said, one.spec, other.spec, judged.clusters),
            )
            for one in keys
            for other in keys
        ]  # fmt: skip

    @property
    def answer_chart(self) -> Any:
        """The chart of the answers of all methods, for the HTML page; None without them."""
        from steadyload.studies.agreement_section import answer_chart

        return answer_chart(self.answers)


def _span(bin_: MarginBin) -> str:
    below = bin_.low == float("-inf")
    return f"below {bin_.high:g}" if below else f"{bin_.low:g} to {bin_.high:g}"


def _fragile_errors(one: MethodEvaluation) -> str | None:
    """Share that is on fragile labels, of a method's errors where it is known which are fragile."""
    known = [each for each in (one.robust, one.fragile) if each.n]
    wrong = sum((1.0 - each.value) * each.n for each in known)
    if one.fragile.n == 0 or wrong == 0.0:
        return None
    return f"{fixed(100 * (1.0 - one.fragile.value) * one.fragile.n / wrong)} (of {fixed(wrong)})"
