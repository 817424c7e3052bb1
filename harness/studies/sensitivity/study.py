"""Methods and the reference on the same cases, each under every rule by which a loading fails."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from steadyload.methods.registry import make_method
from steadyload.progress import NamedProgress as Progress
from steadyload.progress import silent
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.pool import Executor
from steadyload.runs.runner import run_study
from steadyload.studies.sensitivity.rules import RULES
from steadyload.studies.sensitivity.summary import Sensitivity, summarise

METHODS = (
    "fbs",
    "pbs0.9",
    "pbs0.7",
    "pbs0.5",
    "sme",
    "equilibrium",
    "equilibrium:time=0.3",
    "ps3-literal@bullet",
    "ps3@mujoco",
    "ps_opt-paper@bullet",
    "ps_opt@bullet",
    "ps_opt@mujoco",
    "ps_opt@dart",
    "lstm_1",
    "lstm_e",
    "cascade@mujoco",
)
"""Specs of the methods that are compared by default."""

PART = "test"
"""Part of the labelled set; nothing was tuned, trained or fitted on it."""

_SHARD = 25


def run_sensitivity(
    methods: Sequence[str],
    limit: int | None,
    work: Path,
    *,
    benchmark: str | Path | None = None,
    workers: int | Executor = 1,
    progress: Progress = silent,
) -> Sensitivity:
    """Judge all cases under all rules, as far as that is missing, and compare.

    Args:
        methods: specs.
        limit: cases a scenario, those of the first ranks; None for all.
        work: the run folder.
        benchmark: folder of the labelled set, or a word of
            :data:`steadyload.layouts.benchmark.dataset.SETS`; None for the large one.
        workers: see :func:`steadyload.runs.runner.run_study`.
        progress: called with the rows done and those to be done.

    Raises:
        SpecError, StudyError: no such method, or one that cannot judge layouts in space.
        ResultsError: the folder holds another study.
    """
    plain = [str(make_method(spec).spec) for spec in methods]
    labels = [rule.label for rule in RULES]
    told = [rule.given_to(spec) for spec in plain for rule in RULES]
    definition = StudyDefinition(
        "sensitivity",
        tuple(dict.fromkeys([*labels, *plain, *told])),
        benchmark=PART,
        benchmark_directory=benchmark,
        limit=limit,
        shard_size=_SHARD,
    )
    run_study(definition, work, workers=workers, progress=lambda *of: progress("judging", *of))
    return summarise(work, tuple(plain))
