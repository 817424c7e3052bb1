"""The study of learners: from a plan to the records that its page shows."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Sequence
from pathlib import Path

from steadyload.errors import nearest
from steadyload.layouts.benchmark import Part, load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.learners import LearnerError
from steadyload.learners.jobs import BENCHMARK
from steadyload.learners.weights import load_weights, shipped_weights
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share
from steadyload.studies.learned.calibration import MethodCalibration, calibration
from steadyload.studies.learned.foreign import foreign_layouts
from steadyload.studies.learned.judged import JudgedPart, provenance_row
from steadyload.studies.learned.plan import Plan, Section
from steadyload.studies.learned.summary import (
    LeakRow,
    Learned,
    ProvenanceRow,
    SizeCurve,
    TrainedRow,
)
from steadyload.studies.learned.table import judge_table
from steadyload.studies.learned.trainings import Workshop

Progress = Callable[[int, int], None]


def _silent(done: int, total: int) -> None:
    """Progress that is not shown."""


def learner_study(
    plan: Plan,
    work: Path,
    *,
    only: Collection[Section] = (),
    part: Part | None = None,
    limit: int | None = None,
    foreign: Sequence[Path] = (),
    workers: int,
    generating: Progress = _silent,
    training: Progress = _silent,
    judging: Progress = _silent,
) -> Learned:
    """Make the missing trainings of a plan, then judge; an interrupted study is resumed.

    Args:
        plan: the trainings and comparisons.
        work: folder of sets, trainings and verdicts.
        only: sections; empty for all that are planned.
        part: of the labelled set; None for the plan's.
        limit: largest number of judged cases a scenario; trainings are not affected.
        foreign: files of layouts of another kind; without one there is no such section.
        workers: processes beside this one, one training each.
        generating: called with item lists done and in all, for every set.
        training: called with trainings done and in all.
        judging: called with verdicts done and in all, for every table.

    Raises:
        LearnerError: a section that is not planned, or a file of layouts that is not there.
        as :meth:`steadyload.studies.learned.trainings.Workshop.make`,
        :func:`steadyload.studies.learned.table.judge_table` and
        :func:`steadyload.studies.learned.foreign.foreign_layouts`.
    """
    for section in only:
        if section not in plan.sections():
            raise LearnerError(
                f"section {str(section)!r} is not planned; {nearest(section, plan.sections())}"
            )
    chosen = [s for s in plan.sections() if not only or s in only]
    if Section.FOREIGN in chosen and not foreign:
        if only:
            raise LearnerError("section 'foreign' needs files of layouts: --foreign FILE")
        chosen.remove(Section.FOREIGN)
    for file in foreign:  # so that an error is raised before hours of training
        if not file.is_file():
            raise LearnerError(f"{file}: no such file of layouts")
    if part is not None:
        plan = dataclasses.replace(plan, part=part)
    workshop = Workshop(plan, work)
    workshop.make(chosen, workers=workers, generating=generating, training=training)
    judged = JudgedPart(plan.part, limit)
    study = _Study(plan, workshop, judged)
    found: dict[str, object] = {}
    if Section.TABLE in chosen:
        found["table"] = judge_table(
            plan, workshop, work / "table", limit=limit, workers=workers, progress=judging
        )
    for section, read in study.readings.items():
        if section in chosen:
            found[str(section)] = read()
    if Section.SOURCES in chosen:
        found["agreement"] = study.agreement()
    if Section.FOREIGN in chosen and plan.foreign is not None:
        found["foreign"] = foreign_layouts(
            plan.foreign, foreign, work / "foreign", limit=limit, workers=workers, progress=judging
        )
    return Learned(
        part=str(plan.part),
        cases=len(judged.cases),
        item_lists=len(set(judged.cases.instances)),
        scenarios=judged.scenarios,
        trainings=study.provenance(chosen),
        **found,  # type: ignore[arg-type]
    )


class _Study:
    """The sections that need trained weights alone."""

    def __init__(self, plan: Plan, workshop: Workshop, judged: JudgedPart) -> None:
        self._plan, self._workshop, self._judged = plan, workshop, judged
        self.readings: dict[Section, Callable[[], object]] = {
            Section.SIZE: self._size,
            Section.SOURCES: lambda: self._contrast(Section.SOURCES),
            Section.REMEDIES: lambda: self._contrast(Section.REMEDIES),
            Section.CALIBRATION: self._calibration,
            Section.LEAK: self._leak,
        }

    def _row(self, name: str, against: str = "") -> TrainedRow:
        held = self._workshop.runs(against) if against else []
        return self._judged.row(self._workshop.runs(name), held)

    def _size(self) -> tuple[SizeCurve, ...]:
        return tuple(
            SizeCurve(curve.title, tuple(self._row(name) for name in curve.trainings))
            for curve in self._plan.size
        )

    def _contrast(self, section: Section) -> tuple[TrainedRow, ...]:
        contrast = getattr(self._plan, section)
        return (
            self._row(contrast.baseline),
            *(self._row(name, contrast.baseline) for name in contrast.trainings),
        )

    def _leak(self) -> tuple[LeakRow, ...]:
        return tuple(
            LeakRow(self._row(pair.baseline), self._row(name, pair.baseline))
            for pair in self._plan.leak
            for name in pair.trainings
        )

    def _calibration(self) -> tuple[MethodCalibration, ...]:
        assert self._plan.calibration is not None
        found = []
        for name in self._plan.calibration.judges:
            title, where = name, str(name)
            if name in self._plan.trainings:
                run = self._workshop.runs(name)[0]
                title, where = f"{run.training.title}, seed {run.seed}", str(run.weights)
            probabilities = self._judged.probabilities(load_weights(where))
            found.append(calibration(title, probabilities, self._judged.cases))
        return tuple(found)

    def agreement(self) -> dict[str, Estimate]:
        """By label source, its agreement with the labels of the baseline's set."""
        sources = self._plan.sources
        assert sources is not None
        own = [n for n in self._plan.trainings[sources.baseline].data if n != BENCHMARK]
        if not own:
            return {}
        basis = load_benchmark(self._workshop.set_folder(own[0])).cases.set_index(KEYS)
        found = {}
        needed = self._plan.needed([Section.SOURCES])
        for name in dict.fromkeys(n for t in needed for n in t.data if n != BENCHMARK):
            other = load_benchmark(self._workshop.set_folder(name)).cases.set_index(KEYS)
            both = basis.index.intersection(other.index)
            if name == own[0] or not len(both):
                continue
            mine, theirs = (t.loc[both, "failing_step"].fillna(-1) for t in (basis, other))
            same = (mine == theirs).to_numpy(bool)
            label = self._plan.sets[name].label
            found[label] = share(same, basis.loc[both, "instance"].to_numpy())
        return found

    def provenance(self, sections: Collection[Section]) -> tuple[ProvenanceRow, ...]:
        """Provenance of all weights that sections use."""
        rows = [
            provenance_row(training.title, load_weights(run.weights))
            for training in self._plan.needed(sections)
            for run in self._workshop.runs(training.name)
        ]
        named = [
            name
            for section in sections
            for name in (
                *getattr(getattr(self._plan, section), "methods", ()),
                *getattr(getattr(self._plan, section), "judges", ()),
            )
        ]
        shipped = [n for n in dict.fromkeys(named) if n in shipped_weights()]
        return (*(provenance_row(f"{n}, shipped", load_weights(n)) for n in shipped), *rows)
