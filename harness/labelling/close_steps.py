"""Verdicts of the reference with changed contacts, at the steps of labelled cases that are close.

On layouts of real size all steps of a case take the reference hours. Two changes of contacts alone
are looked at, and of each case only the steps at which they could change the verdict: the failing
steps of both questions, the step before each, and those at which something moved far or balance is
narrow; of a case that stands the final load and three earlier steps, too.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from steadyload.labelling.further_verdicts import with_further
from steadyload.labelling.label_rows import LABEL
from steadyload.labelling.labelling import JUDGES, FurtherMethod
from steadyload.labelling.screened_loading import NARROW, NEAR, SAME
from steadyload.layouts.benchmark.dataset import KEYS, Benchmark, load_benchmark
from steadyload.layouts.benchmark.parts import Part
from steadyload.layouts.benchmark.tables import OPINIONS, BenchmarkError
from steadyload.layouts.model.layout import FloatArray, Layout
from steadyload.layouts.model.question import Question
from steadyload.methods.contract.method import Status
from steadyload.methods.contract.spec import parse_spec
from steadyload.methods.registry import make_method
from steadyload.methods.simulation import step_answers
from steadyload.methods.simulation.simulation import Simulation
from steadyload.methods.simulation.step_answers import StepAnswer, StepAnswers
from steadyload.progress import Progress, silent
from steadyload.runs.asked import Asked, kept_rows, rows_so_far
from steadyload.runs.pool import IN_THIS_PROCESS
from steadyload.runs.provenance import made_by

CONTACTS = tuple(
    judge
    for judge in JUDGES
    if judge.spec in (f"{LABEL}:stiffness=1e7,most_rate=3e3", f"{LABEL}:jitter=1e-4")
)
"""Contacts of 1e7 N/m, as throws of a real cube fit, and positions disturbed by 0.1 mm."""

STANDING = 60
"""Cases that stand which are looked at, evenly over the numbers of boxes."""

EARLIER = 3
"""Earlier steps of a case that stands, drawn at random."""


class CloseCase(NamedTuple):
    """A labelled case and the steps that are close, in ascending order."""

    scenario: str
    layout: Layout
    steps: tuple[int, ...]


@dataclass(frozen=True)
class StepVerdicts:
    """Answers about some steps of a case, up to the first that fails within 0.3 s.

    Attributes:
        status: ``done``, or how the simulation of a step ended without an answer.
        steps: that were simulated.
        within: whether each fails within 0.3 s.
        standing: whether each fails once everything rests; None where something still moved.
    """

    status: str
    steps: list[int]
    within: list[bool]
    standing: list[bool | None]

    def verdict(self, question: Question) -> tuple[str, int | None]:
        """Status and failing step for a question."""
        fails = self.within if question == Question.WITHIN else self.standing
        for step, found in zip(self.steps, fails, strict=True):
            if found is None:
                return str(Status.UNSETTLED), None
            if found:
                return str(Status.DONE), step
        return self.status, None


class CloseSteps(Asked[StepVerdicts], what="close steps"):
    """Some steps of a layout, put to a simulation."""

    layout: Layout
    judge: str
    steps: tuple[int, ...]
    made_by: Mapping[str, str]

    def measure(self) -> StepVerdicts:
        """Simulate the steps."""
        method = make_method(self.judge)
        assert isinstance(method, Simulation)
        method.prepare(len(self.layout))
        asked: list[int] = []
        found: list[StepAnswer] = []
        standing, status = True, Status.DONE
        with closing(StepAnswers(self.layout, method)) as answers:
            for step in self.steps:
                answer = answers.ask(step, standing=standing)
                status = answer.status
                if status is not Status.DONE:
                    break
                asked.append(step)
                found.append(answer)
                standing = standing and answer.fails_standing is False
                if answer.fails_within:
                    break
        return StepVerdicts(
            str(status), asked, [a.fails_within for a in found], [a.fails_standing for a in found]
        )


def made_for(judge: str) -> dict[str, str]:
    """Versions on which answers of a method about steps depend.

    Args:
        judge: spec of a simulation.
    """
    return {**made_by(make_method(judge)), "version of answers": str(step_answers.VERSION)}


def judge_close_steps(
    directory: Path,
    *,
    part: Part | str = Part.TEST,
    standing: int = STANDING,
    workers: int = IN_THIS_PROCESS,
    progress: Progress = silent,
) -> int:
    """Store verdicts of :data:`CONTACTS` on the failing cases of a part and some that stand.

    Rows lie in ``opinions/close`` in the folder: an interrupted run keeps the cases that are
    complete, and goes on with the others.

    Args:
        directory: of a set that was labelled by screening, for both questions.
        part: of the set.
        standing: cases that stand, at most.
        workers: see :func:`steadyload.runs.runner.run_study`.
        progress: called with verdicts that are known and those in all.

    Returns:
        The number of cases.

    Raises:
        BenchmarkError: no labelled set, or none that was labelled by screening.
        ResultsError: another run is at work in the folder, or a unit ended its process.
    """
    benchmark = load_benchmark(directory)
    cases = close_cases(benchmark, part, standing)
    made = {judge.spec: made_for(judge.spec) for judge in CONTACTS}
    asked = [(case, judge) for case in cases for judge in CONTACTS]
    units = [
        CloseSteps(case.layout, judge.spec, case.steps, made[judge.spec]) for case, judge in asked
    ]
    folder = directory / "opinions" / "close"
    folder.parent.mkdir(exist_ok=True)
    try:
        kept_rows(folder, units, StepVerdicts, workers=workers, progress=progress)
    finally:
        known = rows_so_far(folder, units, StepVerdicts)
        _store(
            directory,
            cases,
            [known[k : k + len(CONTACTS)] for k in range(0, len(known), len(CONTACTS))],
        )
    return len(cases)


def _store(
    directory: Path, cases: Sequence[CloseCase], known: Sequence[Sequence[StepVerdicts | None]]
) -> None:
    """Write the verdicts on those cases that all methods have judged into the tables of a set."""
    for question in Question:
        rows = [
            _verdict_row(case, judge, question, verdicts)
            for case, said in zip(cases, known, strict=True)
            if all(said)
            for judge, verdicts in zip(CONTACTS, said, strict=True)
            if verdicts is not None
        ]
        if rows:
            with_further(directory, pd.DataFrame(rows, columns=OPINIONS.names))


def _verdict_row(
    case: CloseCase, judge: FurtherMethod, question: Question, verdicts: StepVerdicts
) -> tuple[object, ...]:
    """A row of the table of opinions."""
    spec = parse_spec(judge.spec)
    if question != Question.WITHIN:
        spec = spec.stating("question", question)
    said = str(make_method(str(spec)).spec)
    status, step = verdicts.verdict(question)
    return case.layout.name, case.scenario, str(question), str(judge.reason), said, status, step


def close_cases(benchmark: Benchmark, part: Part | str, standing: int) -> list[CloseCase]:
    """All cases of a part that fail by one of the questions, and some that stand.

    Raises:
        BenchmarkError: no case of the part was labelled by screening, for both questions.
    """
    labels = benchmark.select(part).merge(
        benchmark.labels_on(Question.STANDS)[[*KEYS, "failing_step"]],
        on=KEYS,
        suffixes=("", "_stands"),
    )
    labels = labels.merge(benchmark.screening, on=KEYS)
    if labels.empty:
        raise BenchmarkError(
            f"part {part}: no case was labelled by screening for both questions; allowed: a set "
            "that steadyload benchmark screen has labelled"
        )
    fails = labels[["failing_step", "failing_step_stands"]].notna().any(axis=1)
    names = labels["layout"] + " " + labels["scenario"]
    labels = labels.assign(drawn=names.map(lambda case: zlib.crc32(case.encode())))
    others = labels[~fails].sort_values(["item_count", "drawn"])
    evenly = np.linspace(0, len(others) - 1, min(standing, len(others))).round().astype(int)
    chosen = pd.concat([labels[fails].sort_values(["item_count", "drawn"]), others.iloc[evenly]])
    return [
        CloseCase(row.scenario, benchmark.layout(row.layout, row.scenario), _steps(row))
        for row in chosen.itertuples()
    ]


def _steps(row: Any) -> tuple[int, ...]:
    """The steps of a labelled case that are close."""
    labels = [getattr(row, name) for name in ("failing_step", "failing_step_stands")]
    failing = [int(step) for step in labels if not pd.isna(step)]
    chosen = {*failing, *(step - 1 for step in failing if step)}
    far = np.array(row.reference, dtype=float)
    far = np.where(np.isfinite(far), far, np.array(row.screen, dtype=float))
    count = max(failing) if failing else len(far)
    if not failing:
        chosen |= last_and_earlier(count, row.drawn)
    chosen |= _close(far[:count], row.moved, row.margin)
    return tuple(sorted(chosen))


def last_and_earlier(count: int, seed: int) -> set[int]:
    """The last of so many steps, and :data:`EARLIER` ones drawn at random."""
    earlier = np.random.default_rng(seed).permutation(count - 1)[:EARLIER]
    return {count - 1, *map(int, earlier)}


def _close(far: FloatArray, moved: Sequence[int], margins: Sequence[float]) -> set[int]:
    """Steps at which something moved far or balance is narrow, and was not so at an earlier one."""
    found: set[int] = set()
    moves: dict[int, list[float]] = {}
    narrow: set[float] = set()
    for step, beyond in enumerate(far):
        before = moves.setdefault(int(moved[step]), [])
        if beyond > NEAR and not any(abs(beyond - other) < SAME for other in before):
            before.append(float(beyond))
            found.add(step)
        margin = float(margins[step])
        if abs(margin) < NARROW and margin not in narrow:
            narrow.add(margin)
            found.add(step)
    return found
