"""Reliability of verdicts on labelled cases: the samples for the page of uncertain verdicts.

A run folder holds ``cases/*.json``, a :class:`steadyload.runs.store.Store` with a shard for some
cases of one method and uncertainty, so an interrupted run is resumed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import zip_longest
from pathlib import Path

import pandas as pd

from steadyload.engines.registry import package_versions
from steadyload.layouts.benchmark import Benchmark, Part, load_benchmark
from steadyload.methods.registry import make_method
from steadyload.methods.uncertainty import parse_uncertainty
from steadyload.progress import Progress, silent
from steadyload.runs import verdict_reliability
from steadyload.runs.labels import Case
from steadyload.runs.pool import IN_THIS_PROCESS
from steadyload.runs.provenance import made_by
from steadyload.runs.store import JSON, Store, locked
from steadyload.runs.verdict_reliability import FIRST_LOOK, Sampling
from steadyload.studies.uncertain import cases as uncertain_cases
from steadyload.studies.uncertain.cases import Question, Row, Unit, crashed_row, sample_unit

CHECK = "equilibrium"
"""The method whose probabilities are compared with those of many random samples."""

_SHARD = 10


@dataclass(frozen=True, slots=True)
class UncertainOptions:
    """Options of the study of uncertain verdicts.

    Attributes:
        part: of the labelled set that comes with the package.
        uncertainty: the deviating quantities, as :func:`parse_uncertainty` reads them.
        methods: spec strings.
        cases: number a scenario, for methods without an engine.
        engine_cases: number a scenario, for methods with one, and for ``alone``.
        alone: quantities that deviate one at a time, to compare their effects.
        alone_method: spec of the method that judges ``alone``.
        checked: number of layouts on which :data:`CHECK` is compared with random samples; 0 for
            none.
        check_cases: number a scenario from which the checked layouts are chosen: the first of which
            some samples stand and some fall, by :data:`FIRST_LOOK` samples of another seed.
        random: number of random samples a checked layout.
        sampling: the rule by which sampling ends.
    """

    part: Part = Part.TEST
    uncertainty: str = "com=5mm,position=3mm"
    methods: tuple[str, ...] = (
        "sme", "equilibrium:time=0.3", "lstm_1:outside=accept", "ps_opt@mujoco"
    )  # fmt: skip
    cases: int = 100
    engine_cases: int = 20
    alone: tuple[str, ...] = ("com=5mm", "position=3mm", "weight=5%", "friction=0.1")
    alone_method: str = "equilibrium:time=0.3"
    checked: int = 50
    check_cases: int = 500
    random: int = 4096
    sampling: Sampling = field(default_factory=Sampling)


@dataclass(frozen=True, slots=True)
class Sampled:
    """Results of a run: tables with the columns of :data:`Row`, a row a case."""

    methods: dict[str, pd.DataFrame]
    alone: dict[str, pd.DataFrame]
    check: pd.DataFrame


def run_uncertain(
    asked: UncertainOptions,
    directory: Path,
    *,
    workers: int = IN_THIS_PROCESS,
    progress: Progress = silent,
) -> Sampled:
    """Sample the missing cases in ``directory``; an interrupted run is resumed.

    Args:
        asked: the options.
        directory: made when it does not exist.
        workers: see :func:`steadyload.runs.runner.run_study`.
        progress: called with cases done and cases in all, first of all but the random samples.

    Raises:
        SpecError: no such method, or not a quantity that can be uncertain.
        BenchmarkError: no such part.
        ResultsError: it is no folder, or another run is at work in it.
        EngineNotInstalledError: a method's engine is missing.
        WorkerDiedError: see :func:`steadyload.runs.pool.run_units`.
    """
    for text in (asked.uncertainty, *asked.alone):
        parse_uncertainty(text)
    for spec in (*asked.methods, asked.alone_method):
        make_method(spec).prepare()
    with locked(directory):
        run = _Run(asked, load_benchmark(), Store(directory / "cases", JSON))
        by_method = {spec: run.by_method(spec) for spec in asked.methods}
        alone = {what: run.alone(what) for what in asked.alone}
        glance = run.glance()
        run.sample([*by_method.values(), *alone.values(), glance], workers, progress)
        check = replace(
            glance,
            cases=_unsure(glance, run.table(glance))[: asked.checked],
            question=replace(glance.question, sampling=asked.sampling, random=asked.random),
        )
        run.sample([check], workers, progress)
        return Sampled(
            {spec: run.table(unit) for spec, unit in by_method.items()},
            {what: run.table(unit) for what, unit in alone.items()},
            run.table(check),
        )


class _Run:
    def __init__(
        self, asked: UncertainOptions, benchmark: Benchmark, store: Store[Row, list[Row]]
    ) -> None:
        self._asked, self._benchmark, self._store = asked, benchmark, store
        specs = dict.fromkeys((*asked.methods, asked.alone_method, CHECK))
        # Of the code at the time of sampling, not of later changes.
        self._made_by = {spec: _made_by(spec) for spec in specs}

    def by_method(self, spec: str) -> Unit:
        """The reliability of a method's verdicts."""
        asked = self._asked
        limit = asked.cases if make_method(spec).spec.engine is None else asked.engine_cases
        return self._unit(limit, Question(spec, asked.uncertainty, asked.sampling))

    def alone(self, what: str) -> Unit:
        """The effect of the deviation of one quantity alone."""
        asked = self._asked
        return self._unit(asked.engine_cases, Question(asked.alone_method, what, asked.sampling))

    def glance(self) -> Unit:
        """Samples by which the layouts to check are chosen; they are not used otherwise."""
        asked = self._asked
        few = replace(asked.sampling, most=FIRST_LOOK, seed=asked.sampling.seed + 1)
        question = Question(CHECK, asked.uncertainty, few)
        return self._unit(asked.check_cases if asked.checked else 0, question)

    def _unit(self, limit: int, question: Question) -> Unit:
        """A question about the first ``limit`` cases of each scenario; 0 for none."""
        cases = self._cases(limit) if limit else ()
        return Unit(cases, question, self._made_by[question.method])

    def _cases(self, limit: int) -> tuple[Case, ...]:
        chosen = self._benchmark.select(self._asked.part, limit=limit)
        return tuple(
            (scenario, self._benchmark.layout(name, scenario))
            for name, scenario in zip(chosen["layout"], chosen["scenario"], strict=True)
        )

    def sample(self, asked: Sequence[Unit], workers: int, progress: Progress) -> None:
        """Sample the missing cases."""
        units = [unit for one in asked for unit in one.in_shards(_SHARD)]
        self._store.complete(
            units, sample_unit, crashed=crashed_row, workers=workers, progress=progress
        )

    def table(self, asked: Unit) -> pd.DataFrame:
        """The stored rows of cases that were sampled."""
        units = asked.in_shards(_SHARD)
        return pd.DataFrame([row for unit in units for row in self._store.read(unit.key)])


def _unsure(glance: Unit, table: pd.DataFrame) -> tuple[Case, ...]:
    """The cases of which some samples stand and some fall, scenarios in turn."""
    turns: dict[str, list[Case]] = {scenario: [] for scenario, _ in glance.cases}
    for case, safe in zip(glance.cases, table["safe"] if len(table) else (), strict=True):
        counts = dict(safe)
        if 0 < counts.get(len(case[1]), 0) < sum(counts.values()):
            turns[case[0]].append(case)
    return tuple(case for turn in zip_longest(*turns.values()) for case in turn if case is not None)


def _made_by(spec: str) -> dict[str, str]:
    """Versions on which a row depends besides its parameters."""
    return {
        **made_by(make_method(spec)),
        **package_versions(("numpy", "scipy")),
        "version of sampling": str(verdict_reliability.VERSION),
        "version of rows": str(uncertain_cases.VERSION),
    }
