"""Reliability of verdicts on labelled cases: the samples for the page of uncertain verdicts.

A run folder holds ``cases/*.json``, a :class:`steadyload.runs.store.Store` with a shard for some
cases of one method and uncertainty, so an interrupted run is resumed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest

import pandas as pd

from steadyload.engines.registry import package_versions
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.parts import LISTS, Part
from steadyload.methods.registry import make_method
from steadyload.runs import verdict_reliability
from steadyload.runs.labels import Case
from steadyload.runs.provenance import made_by
from steadyload.runs.store import JSON, Store, locked
from steadyload.runs.verdict_reliability import FIRST_LOOK, Sampling
from steadyload.studies.kit import Lab
from steadyload.studies.uncertain import cases as uncertain_cases
from steadyload.studies.uncertain.cases import Row, SampledMethod, Unit, crashed_row, sample_unit

SET, PART = LISTS, Part.TEST
"""The labelled set, and its part on which nothing was chosen."""

UNCERTAIN = "com=5mm,position=3mm"
"""The deviating quantities."""

CASES, ENGINE_CASES = 100, 20
"""Cases a scenario of methods without an engine, and of those with one."""

METHODS = {
    "within": ("sme", "equilibrium:time=0.3", "lstm_1:outside=accept", "ps_opt@mujoco"),
    "stands": (
        "sme", "equilibrium", "lstm_1:question=stands,outside=accept",
        "ps_opt@mujoco:question=stands",
    ),
}  # fmt: skip
"""By the question whose labels their verdicts are compared with."""

ALONE = ("com=5mm", "position=3mm", "weight=5%", "friction=0.1")
"""Quantities that deviate one at a time, to compare their effects."""

ALONE_METHOD = {"within": "equilibrium:time=0.3", "stands": "equilibrium"}
"""The method that judges :data:`ALONE`, on as many cases as methods with an engine, by question."""

CHECK = "equilibrium"
"""The method whose probabilities are compared with those of many random samples."""

CHECK_CASES = 500
"""Cases a scenario from which the checked layouts are chosen: the first of which some samples stand
and some fall, by :data:`FIRST_LOOK` samples of another seed."""

CHECKED = 50
"""Layouts that are checked."""

RANDOM = 4096
"""Random samples a checked layout."""

SAMPLING = Sampling()
"""The rule by which sampling ends."""

_SHARD = 10


@dataclass(frozen=True, slots=True)
class Sampled:
    """Results of a run: tables with the columns of :data:`Row`, a row a case."""

    methods: dict[str, pd.DataFrame]
    alone: dict[str, pd.DataFrame]
    check: pd.DataFrame


def sampled_cases(lab: Lab, asked: str, limit: int | None = None) -> Sampled:
    """Sample the missing cases, at most ``limit`` a scenario; an interrupted run is resumed.

    Progress counts cases done and cases in all, first of all but the random samples.
    """
    specs, alone_method = METHODS[asked], ALONE_METHOD[asked]
    for spec in (*specs, alone_method):
        make_method(spec).prepare()
    benchmark = load_benchmark(SET)
    # Of the code at the time of sampling, not of later changes.
    made = {spec: _made_by(spec) for spec in (*specs, alone_method, CHECK)}

    def unit(count: int, sampled: SampledMethod) -> Unit:
        """A method sampled on the first cases of each scenario."""
        chosen = benchmark.select(PART, limit=min(count, limit or count)).itertuples()
        own = tuple(
            (each.scenario, benchmark.layout(each.layout, each.scenario)) for each in chosen
        )
        return Unit(own, sampled, made[sampled.method])

    def of_method(spec: str) -> Unit:
        count = CASES if make_method(spec).spec.engine is None else ENGINE_CASES
        return unit(count, SampledMethod(spec, UNCERTAIN, SAMPLING))

    by_method = {spec: of_method(spec) for spec in specs}
    alone = {
        what: unit(ENGINE_CASES, SampledMethod(alone_method, what, SAMPLING)) for what in ALONE
    }
    few = replace(SAMPLING, most=FIRST_LOOK, seed=SAMPLING.seed + 1)
    glance = unit(CHECK_CASES, SampledMethod(CHECK, UNCERTAIN, few))
    with locked(lab.work):
        store: Store[Row, list[Row]] = Store(lab.work / "cases", JSON)

        def sample(units: Sequence[Unit]) -> None:
            store.complete(
                [shard for one in units for shard in one.in_shards(_SHARD)],
                sample_unit,
                crashed=crashed_row,
                workers=lab.workers,
                progress=lambda *of: lab.progress("sampling", *of),
            )

        def table(one: Unit) -> pd.DataFrame:
            shards = one.in_shards(_SHARD)
            return pd.DataFrame([row for shard in shards for row in store.read(shard.key)])

        sample([*by_method.values(), *alone.values(), glance])
        check = replace(
            glance,
            cases=_unsure(glance, table(glance))[:CHECKED],
            sampled=replace(glance.sampled, sampling=SAMPLING, random=RANDOM),
        )
        sample([check])
        return Sampled(
            {spec: table(one) for spec, one in by_method.items()},
            {what: table(one) for what, one in alone.items()},
            table(check),
        )


def _unsure(glance: Unit, table: pd.DataFrame) -> tuple[Case, ...]:
    """The cases of which some samples stand and some fall, scenarios in turn."""
    turns: dict[str, list[Case]] = {scenario: [] for scenario, _ in glance.cases}
    for case, safe in zip(glance.cases, table["safe"], strict=True):
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
