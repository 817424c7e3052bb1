"""From labelled cases to the thresholds of a cascade, with all that is needed to fit them again."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any

import numpy as np

from steadyload.engines.registry import capabilities, engines
from steadyload.errors import nearest
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.parts import PALLET_SOFTWARE, REAL, Part
from steadyload.layouts.model.question import Question
from steadyload.methods.cascade.thresholds import Ladder, Stage, Thresholds, fingerprint
from steadyload.methods.contract.spec import SpecError, parse_spec
from steadyload.methods.registry import each_question, make_method
from steadyload.progress import Progress, silent
from steadyload.runs.provenance import provenance
from steadyload.tuning import TuningError
from steadyload.tuning.cascade.defaults import (
    BUDGETS,
    CANDIDATES,
    CONFIDENCE,
    LAST,
    SIZES,
)
from steadyload.tuning.cascade.evaluation import evaluate
from steadyload.tuning.cascade.fitting import Fit, LeftOut, fit, independent_cases, left_out
from steadyload.tuning.cascade.step_scores import BoolArray, StepScores, Table, score_steps
from steadyload.tuning.cases import Case, CaseSource, load_cases, own_part, set_for
from steadyload.tuning.cases import fingerprint as cases_fingerprint

SURE = 0.95
"""Confidence of the second bound that is reported."""

ELSEWHERE = 200
"""Cases a scenario of the training part, for stages that learnt nothing from it."""


@dataclasses.dataclass(frozen=True, slots=True)
class FitOptions:
    """Options of fitting the thresholds of a cascade.

    Attributes:
        engine: that the last method runs on.
        budgets: points of accuracy, one or more; see :data:`BUDGETS`.
        confidence: see :data:`CONFIDENCE`.
        candidates: specs; ``{engine}`` stands for the engine. Empty for :data:`CANDIDATES`.
        directory: the labelled set that is fitted on, as a study names it; None for the one of the
            package that was made for it, or the planar one. Its part ``fitting`` counts, or as of
            :func:`steadyload.tuning.cases.own_part`.
        data: folders of further sets, or their words, likewise. No method may have learnt anything
            of these parts.
        limit: only so many cases a scenario of every set.
        question: whose labels count.
        falls: a set whose parts ``train`` and ``validation`` count, too: of its customers' pallets,
            or of all its cases where it has none, stages may lose no fall that the last method
            finds, and stages only pass steps. Empty for no such set; None for that of real size
            where the question is ``stands``, and for none otherwise.
        last: spec of the method that decides the rest, on the engine; ``{engine}`` stands for its
            name, and the question is added where the method has one. Empty for :data:`LAST`.

    Raises:
        TuningError: no budget, or a number that is out of its range; a set that stands there
            twice, or is not planar on an engine of two dimensions; a last method that runs on
            another engine, or that was made for another question.
        SpecError: no such engine, or a candidate or last method that is none.
    """

    engine: str
    budgets: tuple[float, ...] = BUDGETS
    confidence: float = CONFIDENCE
    candidates: tuple[str, ...] = ()
    directory: str | None = None
    data: tuple[str, ...] = ()
    limit: int | None = None
    question: Question = Question.WITHIN
    last: str = ""
    falls: str | None = None

    def __post_init__(self) -> None:
        if self.engine not in engines():
            raise SpecError(f"unknown engine {self.engine!r}; {nearest(self.engine, engines())}")
        if not self.budgets:
            raise TuningError("error budget: none is given; allowed: one or more")
        for budget in self.budgets:
            if not 0.0 < budget <= 100.0:
                raise TuningError(f"error budget is {budget:g} points; allowed: above 0, to 100")
        if not 0.0 < self.confidence < 1.0:
            raise TuningError(f"confidence is {self.confidence:g}; allowed: between 0 and 1")
        if self.falls is None:
            counts = self.question == Question.STANDS and capabilities(self.engine).dimensions == 3
            object.__setattr__(self, "falls", REAL if counts else "")
        sets = (*self.data, self.falls) if self.falls else self.data
        object.__setattr__(self, "directory", set_for(self.engine, self.directory, sets))
        asked = map(self.of_engine, self.candidates or CANDIDATES[self.question])
        named = (str(make_method(spec).spec) for spec in asked)
        object.__setattr__(self, "candidates", tuple(named))
        object.__setattr__(self, "last", self._last())

    def of_engine(self, spec: str) -> str:
        """A spec with the engine's name in its place."""
        return spec.replace("{engine}", self.engine)

    def _last(self) -> str:
        """The canonical spec of the last method."""
        spec = parse_spec(self.of_engine(self.last or LAST))
        if spec.engine != self.engine:
            raise TuningError(
                f"last method is {spec}; allowed: one on the engine {self.engine}, which the "
                "cascade is named by"
            )
        stated = dict(spec.values).get("question")
        if stated not in (None, str(self.question)):
            raise TuningError(
                f"last method is {spec}; allowed: the question {self.question}, whose labels count"
            )
        if self.question != Question.WITHIN and self.question in each_question(spec.name):
            spec = spec.stating("question", self.question)
        return str(make_method(spec).spec)

    def sources(self) -> tuple[CaseSource, ...]:
        """Sources of the cases that thresholds are fitted on."""
        return tuple(
            CaseSource(own_part(path, Part.FITTING), path, self.limit, str(self.question))
            for path in (self.directory, *self.data)
        )

    def of_falls(self) -> tuple[CaseSource, ...]:
        """Sources of the cases among which falls are not to be lost."""
        parts = (Part.TRAIN, Part.VALIDATION) if self.falls else ()
        return tuple(
            CaseSource(str(part), self.falls, self.limit, str(self.question)) for part in parts
        )


def _customers(directory: str, cases: Sequence[Case]) -> list[bool]:
    """Which cases are of customers' pallets; all where none is."""
    sources = load_benchmark(directory).layouts["sources"]
    found = [PALLET_SOFTWARE in sources[case.layout.name] for case in cases]
    return found if any(found) else [True] * len(found)


def fit_cascade(options: FitOptions, *, progress: Progress = silent) -> Thresholds:
    """Thresholds of the cheapest cascade within each budget, from the scores of all candidates.

    Args:
        options: what is fitted.
        progress: called with methods done and in all.

    Raises:
        TuningError: all cases are of one item list, or see
            :func:`steadyload.tuning.cascade.fitting.fit`.
        NotStepwiseError: a candidate judges whole loadings alone.
        BenchmarkError: no such labelled set.
    """
    cases = list(chain.from_iterable(_balanced(load_cases(s)) for s in options.sources()))
    known, falling = len(cases), list(chain.from_iterable(map(load_cases, options.of_falls())))
    cases += falling
    lists = {case.instance for case in cases}
    if len(lists) < 2:
        raise TuningError(
            f"cases to fit on: of {len(lists)} item lists; allowed: 2 or more, since each is "
            "judged by thresholds fitted without it, too"
        )
    specs = [*options.candidates, options.last]
    made_of = {spec: fingerprint(make_method(spec)) for spec in specs}
    table = score_steps(specs, cases, progress=progress)
    if options.falls:
        kept = [False] * known + _customers(options.falls, falling)
        table = dataclasses.replace(table, falls=np.array(kept))
    independent = independent_cases(table, options.candidates, options.last)
    fits = {
        budget: fit(
            table,
            options.candidates,
            options.last,
            budget=0.01 * budget,
            confidence=options.confidence,
            independent=independent,
        )
        for budget in options.budgets
    }
    used = list(dict.fromkeys(spec for f in fits.values() for spec in _methods(f)))
    elsewhere = _elsewhere(table, [spec for spec in used if spec != options.last], options)
    ladders = {
        budget: Ladder(
            found.stages, found.last, _summary(table, found, 0.01 * budget, options, elsewhere)
        )
        for budget, found in fits.items()
    }
    given = dataclasses.asdict(options).items()
    made_by = {
        **{name: list(value) if isinstance(value, tuple) else value for name, value in given},
        "cases": cases_fingerprint(cases),
        **provenance(),
    }
    return Thresholds(options.budgets[0], ladders, {spec: made_of[spec] for spec in used}, made_by)


def check_remakable(made_by: Mapping[str, Any]) -> None:
    """Check that thresholds may come with the package.

    Raises:
        TuningError: they would be made by code that is in no commit.
    """
    if "dirty" in str(made_by["git"]):
        raise TuningError(
            f"thresholds would be made by {made_by['git']}, which is in no commit: nobody could "
            "fit them again; commit first, or write them to a file of their own: --output FILE"
        )


def _balanced(cases: Sequence[Case]) -> list[Case]:
    """As many stable as unstable cases of every scenario, the first ones of each."""
    of: dict[str, tuple[list[Case], list[Case]]] = {}
    for case in cases:
        of.setdefault(case.scenario, ([], []))[case.safe < len(case.layout)].append(case)
    kept = {id(c) for both in of.values() for part in both for c in part[: min(map(len, both))]}
    return [case for case in cases if id(case) in kept]


def _methods(found: Fit) -> tuple[str, ...]:
    return (*(stage.method for stage in found.stages), found.last)


def _elsewhere(table: Table, specs: Sequence[str], options: FitOptions) -> Table | None:
    """Step scores, on cases of a training part, of stages that learnt nothing from labels.

    The part is that of the large set where the set that is fitted on has none.
    """
    asked = [spec for spec in specs if not table.step_scores[spec].trained]
    if not asked:
        return None
    trained = str(Part.TRAIN) in set(load_benchmark(options.directory).cases["split"])
    directory = options.directory if trained else None
    source = CaseSource(
        str(Part.TRAIN), directory, options.limit or ELSEWHERE, str(options.question)
    )
    return score_steps(asked, load_cases(source))


def _summary(
    table: Table, found: Fit, budget: float, options: FitOptions, elsewhere: Table | None
) -> dict[str, Any]:
    """Summary of a fitted ladder, for the file and for people. Shares are from 0 to 1."""
    o, cases = found.evaluation, len(table.lists)
    out = left_out(table, found, budget=budget, confidence=options.confidence)
    return {
        "cases": cases,
        "item_lists": len(set(table.lists)),
        "independent": round(found.independent, 1),
        "allowed": found.most,
        "lost": int(o.lost.sum()),
        "gained": int(o.gained.sum()),
        "bound": round(found.bound(options.confidence), 6),
        "sure_bound": round(found.bound(SURE), 6),
        "left_out": {"lost": int(out.lost.sum()), "cases": int(out.judged.sum())},
        "left_out_by_size": _by_size(table, out),
        **_falls(table, found, out),
        "accuracy": round(float(o.right.mean()), 6),
        "alone": round(float(o.alone.mean()), 6),
        "milliseconds": round(float(o.cost.mean()), 4),
        "milliseconds_alone": round(float(evaluate(table, (), found.last).cost.mean()), 4),
        "decided": [
            {
                "method": spec,
                "steps": int((here := (o.by == number) & o.asked).sum()),
                "wrong": int((here & (o.unstable != table.fails)).sum()),
                "lost": int((o.lost & (o.blamed == number)).sum()),
            }
            for number, spec in enumerate(_methods(found))
        ],
        "elsewhere": [
            _errors_elsewhere(stage, elsewhere.step_scores[stage.method], elsewhere)
            for stage in found.stages
            if elsewhere is not None and stage.method in elsewhere.step_scores
        ],
    }


def _falls(table: Table, found: Fit, out: LeftOut) -> dict[str, Any]:
    """How many falls there are, are found, and are lost; how many loads that stand are said to
    fail: on the cases whose falls count. Empty where none does.
    """
    if table.falls is None:
        return {}
    fails, alone = _any(table, table.fails), evaluate(table, (), found.last)
    falls, stands = table.falls & fails, table.falls & ~fails
    said, by_last = _any(table, found.evaluation.unstable), _any(table, alone.unstable)
    return {
        "falls": {
            "cases": int(falls.sum()),
            "found": int((falls & said).sum()),
            "found_alone": int((falls & by_last).sum()),
            "lost_left_out": int((falls & by_last & ~out.unstable).sum()),
            "stand": int(stands.sum()),
            "false_alarms": int((stands & said).sum()),
            "false_alarms_alone": int((stands & by_last).sum()),
        }
    }


def _any(table: Table, steps: BoolArray) -> BoolArray:
    """The cases that have such a step, (M,)."""
    return np.bincount(table.of, steps, len(table.lists)) > 0


def _by_size(table: Table, out: LeftOut) -> list[dict[str, int]]:
    """Cases of item lists that were left out, by their number of boxes; sizes without any are
    missing.
    """
    place = np.searchsorted(SIZES, table.boxes)
    return [
        {"above": above, "lost": int((out.lost & own).sum()), "cases": count}
        for number, above in enumerate((0, *SIZES))
        if (count := int((out.judged & (own := place == number)).sum()))
    ]


def _errors_elsewhere(stage: Stage, step_scores: StepScores, table: Table) -> dict[str, Any]:
    """Errors of a stage's thresholds if it decides every step of other cases."""
    scored = zip(table.places.tolist(), step_scores.scores.tolist(), strict=True)
    said = [stage.unstable(step, score) for step, score in scored]
    decided = np.array([verdict is not None for verdict in said])
    unstable = np.array([verdict is True for verdict in said])
    return {
        "method": stage.method,
        "cases": len(table.lists),
        "item_lists": len(set(table.lists)),
        "steps": len(said),
        "decided": int(decided.sum()),
        "wrong": int((decided & (unstable != table.fails)).sum()),
    }
