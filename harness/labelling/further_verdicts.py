"""Verdicts of further methods on cases of a set that has its labels, added to its tables."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import pandas as pd

from steadyload.labelling.label_rows import CASE_SECONDS, THRESHOLDS
from steadyload.labelling.labelling import JUDGES, FurtherMethod, further_rows, reasons_of
from steadyload.layouts.benchmark.confidence import Reason
from steadyload.layouts.benchmark.dataset import KEYS, load_benchmark
from steadyload.layouts.benchmark.parts import Part
from steadyload.layouts.benchmark.tables import read_tables, write_tables
from steadyload.layouts.model.question import Question, question_named
from steadyload.methods.contract.spec import parse_spec
from steadyload.methods.registry import make_method
from steadyload.progress import Progress, silent
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.pool import IN_THIS_PROCESS, PartLimit
from steadyload.runs.provenance import provenance
from steadyload.runs.results import ResultsError, load_results
from steadyload.runs.runner import run_study
from steadyload.runs.store import locked
from steadyload.runs.units import timed_out_row

_FOLDERS = {Question.WITHIN: "further", Question.STANDS: "stands"}
"""Folders of results, by question."""

_SHARD = 5
"""Cases of a unit: a change of positions costs the reference ten times as much as a label."""


def add_further_verdicts(
    directory: Path,
    *,
    part: Part | str = Part.TEST_300,
    limit: int | None = None,
    question: Question = Question.WITHIN,
    judges: Sequence[FurtherMethod] = JUDGES,
    workers: int = IN_THIS_PROCESS,
    progress: Progress = silent,
) -> int:
    """Have cases of a labelled set judged by further methods; its labels stay.

    Cases that all of these methods have judged are left out, so that the set alone says where to go
    on. An interrupted run keeps the cases that are complete, and goes on with the others.

    Args:
        directory: of the set; the verdicts are written into its table of opinions on the question.
        part: of the set.
        limit: at most this many cases a scenario, those of the first ranks; None for all.
        question: whose labels are judged again.
        judges: the further methods; for the question ``stands`` see :func:`asked_to_stand`.
        workers: see :func:`steadyload.runs.runner.run_study`.
        progress: called with judgements done and judgements in all.

    Returns:
        The number of cases that were judged now.

    Raises:
        BenchmarkError: no labelled set, or no such case.
        ResultsError: another run is at work in the folder.
        EngineNotInstalledError: a method's engine is missing.
        WorkerDiedError: see :func:`steadyload.runs.pool.run_units`.
    """
    question = question_named(question)
    if question == Question.STANDS:
        judges = asked_to_stand(judges)
    specs = list(reasons_of(judges))
    for spec in specs:
        make_method(spec).prepare()
    with locked(directory):
        benchmark = load_benchmark(directory)
        cases = benchmark.select(part, limit=limit, question=question)
        cases = _incomplete(benchmark.further_verdicts_on(question), cases, specs)
        if cases.empty:
            return 0
        study = StudyDefinition(
            "further opinions", tuple(specs), benchmark=Part.ALL, shard_size=_SHARD
        )
        folder = directory / "opinions" / _FOLDERS[question]
        folder.parent.mkdir(exist_ok=True)
        try:
            run_study(
                study, folder, benchmark=benchmark.drawn(cases), workers=workers,
                limit=PartLimit(CASE_SECONDS, timed_out_row), progress=progress,
            )  # fmt: skip
        except BaseException:
            with suppress(ResultsError):  # nothing was judged yet
                _add(directory, folder, judges, question)
            raise
        _add(directory, folder, judges, question)
        return len(cases)


def asked_to_stand(judges: Sequence[FurtherMethod]) -> tuple[FurtherMethod, ...]:
    """The same methods for the question ``stands``, and the label's with other thresholds.

    For the question ``within`` a label's trace has the verdicts under other thresholds.
    """
    limits = [FurtherMethod(Reason.LIMITS, spec) for spec in THRESHOLDS]
    return tuple(
        FurtherMethod(own.reason, str(parse_spec(own.spec).stating("question", Question.STANDS)))
        for own in (*judges, *limits)
    )


def _incomplete(opinions: pd.DataFrame, cases: pd.DataFrame, specs: Sequence[str]) -> pd.DataFrame:
    """Cases that one of the methods has not judged yet."""
    said = opinions[opinions["judge"].isin(specs)]
    judged = said.groupby(KEYS, observed=True)["judge"].nunique()
    found = judged.reindex(pd.MultiIndex.from_frame(cases[KEYS])).fillna(0).to_numpy()
    return cases[found < len(specs)]


def _add(
    directory: Path, folder: Path, judges: Sequence[FurtherMethod], question: Question
) -> None:
    """Add to the table of opinions the cases of a run folder that all methods have judged."""
    rows = load_results(folder)
    judged = rows.groupby(KEYS)["method"].transform("nunique")
    with_further(directory, further_rows(rows[judged == len(judges)], judges, question))


def with_further(directory: Path, said: pd.DataFrame) -> None:
    """Add rows to a set's table of opinions.

    Earlier verdicts of the same methods on these cases and questions give way.
    """
    layouts, cases, before, manifest = read_tables(directory)
    every = pd.concat([before, said], ignore_index=True)
    every = every.drop_duplicates([*KEYS, "question", "judge"], keep="last")
    asked = dict.fromkeys(said["question"].unique(), provenance())
    made = {"judged_with": manifest.get("judged_with", {}) | asked}
    write_tables(directory, layouts, cases, every, manifest | made, keep_further=True)
