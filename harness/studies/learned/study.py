"""The study of learners: from a plan to the records that its page shows."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from steadyload.errors import nearest
from steadyload.layouts.benchmark import Part, load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.learners import LearnerError
from steadyload.learners.jobs import BENCHMARK
from steadyload.learners.plans.plan import Contrast, Plan, Section
from steadyload.learners.plans.trainings import Workshop
from steadyload.learners.weights import load_weights, shipped_weights
from steadyload.progress import NamedProgress, silent
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share
from steadyload.studies.learned.calibration import MethodCalibration, calibration
from steadyload.studies.learned.foreign import foreign_layouts
from steadyload.studies.learned.judged import JudgedPart, provenance_row
from steadyload.studies.learned.summary import (
    LeakRow,
    Learned,
    ProvenanceRow,
    SizeCurve,
    TrainedRow,
)
from steadyload.studies.learned.table import judge_table


def learner_study(
    plan: Plan,
    work: Path,
    *,
    only: Collection[Section] = (),
    part: Part | None = None,
    limit: int | None = None,
    foreign: Sequence[Path] = (),
    workers: int,
    progress: NamedProgress = silent,
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
        progress: of item lists for every set, of trainings, and of verdicts for every table.

    Raises:
        LearnerError: a section that is not planned, or a file of layouts that is not there.
        as :meth:`steadyload.learners.plans.trainings.Workshop.make`,
        :func:`steadyload.studies.learned.table.judge_table` and
        :func:`steadyload.studies.learned.foreign.foreign_layouts`.
    """
    workshop = Workshop(plan, work)  # of the whole plan, which says what is a method
    plan = dataclasses.replace(_chosen(plan, only, foreign), part=part or plan.part)
    judged = JudgedPart(plan.part, work, limit)
    workshop.make(
        plan.sections(),
        workers=workers,
        known=judged.knows,
        generating=partial(progress, "item lists"),
        training=partial(progress, "trainings"),
    )
    for planned in plan.needed(plan.sections()):
        for run in workshop.runs(planned.name):
            judged.keep(run)
    judging: dict[str, Any] = {
        "limit": limit,
        "workers": workers,
        "progress": partial(progress, "verdicts"),
    }
    trained = _Trained(plan, workshop, judged)
    return Learned(
        part=str(plan.part),
        cases=len(judged.cases),
        item_lists=len(set(judged.cases.instances)),
        scenarios=judged.scenarios,
        table=judge_table(plan, workshop, work / "table", **judging) if plan.table else None,
        size=trained.size(),
        sources=trained.contrast(plan.sources),
        agreement=trained.agreement(),
        remedies=trained.contrast(plan.remedies),
        calibration=trained.calibration(),
        leak=trained.leak(),
        foreign=foreign_layouts(plan.foreign, foreign, work / "foreign", **judging)
        if plan.foreign
        else None,
        trainings=trained.provenance(),
    )


def _chosen(plan: Plan, only: Collection[Section], foreign: Sequence[Path]) -> Plan:
    """The plan with the sections that are asked for, all where none is named."""
    for section in only:
        if section not in plan.sections():
            raise LearnerError(
                f"section {str(section)!r} is not planned; {nearest(section, plan.sections())}"
            )
    chosen = set(only or plan.sections())
    if Section.FOREIGN in chosen and not foreign:
        if only:
            raise LearnerError("section 'foreign' needs files of layouts: --foreign FILE")
        chosen.remove(Section.FOREIGN)
    for file in foreign:  # so that an error is raised before hours of training
        if not file.is_file():
            raise LearnerError(f"{file}: no such file of layouts")
    return plan.only(chosen)


@dataclass(frozen=True)
class _Trained:
    """Results that need trained weights alone; empty for a section that is not planned."""

    plan: Plan
    workshop: Workshop
    judged: JudgedPart

    def _row(self, name: str, against: str = "") -> TrainedRow:
        held = self.workshop.runs(against) if against else []
        return self.judged.row(self.workshop.runs(name), held)

    def size(self) -> tuple[SizeCurve, ...]:
        return tuple(
            SizeCurve(curve.title, tuple(map(self._row, curve.trainings)))
            for curve in self.plan.size
        )

    def contrast(self, planned: Contrast | None) -> tuple[TrainedRow, ...]:
        if planned is None:
            return ()
        others = (self._row(name, planned.baseline) for name in planned.trainings)
        return (self._row(planned.baseline), *others)

    def leak(self) -> tuple[LeakRow, ...]:
        return tuple(
            LeakRow(honest, leaky)
            for honest, *others in map(self.contrast, self.plan.leak)
            for leaky in others
        )

    def calibration(self) -> tuple[MethodCalibration, ...]:
        found = []
        for name in self.plan.calibration.judges if self.plan.calibration else ():
            title, where = name, name
            if name in self.plan.trainings:
                run = self.workshop.runs(name)[0]
                title, where = f"{run.training.title}, seed {run.seed}", str(run.weights)
            probabilities = self.judged.probabilities(load_weights(where))
            found.append(calibration(title, probabilities, self.judged.cases))
        return tuple(found)

    def agreement(self) -> dict[str, Estimate]:
        """By label source, its agreement with the labels of the baseline's set."""
        sources = self.plan.sources
        own = _generated(self.plan.trainings[sources.baseline].data) if sources else []
        if not own:
            return {}
        basis = self._cases(own[0])
        needed = self.plan.needed([Section.SOURCES])
        found = {}
        for name in dict.fromkeys(name for t in needed for name in _generated(t.data)):
            other = self._cases(name)
            both = basis.index.intersection(other.index)
            if name == own[0] or not len(both):
                continue
            mine, theirs = (t.loc[both, "failing_step"].fillna(-1) for t in (basis, other))
            same = (mine == theirs).to_numpy(bool)
            label = self.plan.sets[name].label
            found[label] = share(same, basis.loc[both, "instance"].to_numpy())
        return found

    def _cases(self, name: str) -> pd.DataFrame:
        return load_benchmark(self.workshop.set_folder(name)).cases.set_index(KEYS)

    def provenance(self) -> tuple[ProvenanceRow, ...]:
        """Provenance of all weights that are used, those that come with the package first."""
        sections = self.plan.sections()
        named = dict.fromkeys(self.plan.method_names(sections))
        return (
            *(
                provenance_row(f"{name}, shipped", load_weights(name))
                for name in named
                if name in shipped_weights()
            ),
            *(
                provenance_row(training.title, self.judged.said(run))
                for training in self.plan.needed(sections)
                for run in self.workshop.runs(training.name)
            ),
        )


def _generated(data: Sequence[str]) -> list[str]:
    """Names of generated sets among the data of a training."""
    return [name for name in data if name != BENCHMARK]
