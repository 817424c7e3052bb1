"""The study of learned methods: from a plan to the rows of its page. Shares are 0 to 1."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

from steadyload.errors import nearest
from steadyload.layouts.benchmark import Part, load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.learners import LearnerError
from steadyload.learners.plans.plan import Contrast, Plan, Section
from steadyload.learners.plans.trainings import Workshop
from steadyload.learners.sequences import BENCHMARK
from steadyload.learners.weights import load_weights, shipped_weights
from steadyload.reports.columns import row
from steadyload.runs.provenance import provenance_lines
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share
from steadyload.studies.kit import Lab
from steadyload.studies.learned.foreign import Foreign, Share, judge_foreign
from steadyload.studies.learned.table import Table, judge_table
from steadyload.studies.learned.trained import JudgedPart, Provenance, Trained, provenance_row
from steadyload.studies.reliability import Abstaining, Bin, Calibrated

SHIFTED = "S2b"
"""The scenario whose centres of mass are shifted the most."""

GAIN = 0.08
"""Gain of accuracy that is the target of remedies there."""


class Curve(NamedTuple):
    """Trainings that differ in the size of their training set."""

    title: str
    rows: Sequence[Trained]

    @property
    def smallest(self) -> Trained:
        """The training with the fewest cases."""
        return min(self.rows, key=lambda each: each.cases)

    @property
    def largest(self) -> Trained:
        """The training with the most cases."""
        return max(self.rows, key=lambda each: each.cases)


class Scored(NamedTuple):
    """Accuracy of a training on the cases of one scenario."""

    scenario: str
    title: str
    accuracy: Estimate
    seeds: Sequence[float]


@row
class Found:
    """All results on learned methods; parts that were not asked for are empty.

    ``part``: of the labelled set, on which all are evaluated; ``item_lists``: number of clusters.
    ``sources``, ``remedies``: the first training, and others that are compared with it; ``leaks``:
    likewise, the others also learnt from layouts of held-out item lists. ``agreement``: by source
    of labels, how often they are those of the first one.
    """

    part: str
    cases: int
    item_lists: int
    scenarios: Sequence[str]
    table: Table | None = None
    size: Sequence[Curve] = ()
    sources: Sequence[Trained] = ()
    agreement: Sequence[Share] = ()
    remedies: Sequence[Trained] = ()
    calibrated: Sequence[Calibrated] = ()
    abstaining: Sequence[Abstaining] = ()
    leaks: Sequence[Sequence[Trained]] = ()
    foreign: Foreign | None = None
    trainings: Sequence[Provenance] = ()
    made_with: Mapping[str, str] = dataclasses.field(default_factory=dict)
    shifted: str = SHIFTED
    gain: float = GAIN

    @property
    def drops(self) -> dict[str, float]:
        """By training, its accuracy in S1 minus that with shifted centres of mass."""
        return {
            each.title: each.accuracy["S1"].value - each.accuracy[SHIFTED].value
            for each in self.remedies
        }

    @property
    def reached(self) -> list[str]:
        """Titles of the remedies that gain what is aimed at."""
        return [
            each.title
            for each in self.remedies
            if each.difference and each.difference[SHIFTED].value >= GAIN
        ]

    @property
    def by_scenario(self) -> list[Scored]:
        """The remedies, scenario by scenario."""
        return [
            Scored(scenario, each.title, each.accuracy[scenario], seeds)
            for each in self.remedies
            for scenario, seeds in each.seeds.items()
        ]

    @property
    def bins(self) -> list[Bin]:
        """All bins of :attr:`calibrated`."""
        return [one for each in self.calibrated for one in each.bins]


def compare(
    lab: Lab,
    plan: Plan,
    *,
    only: Collection[str] = (),
    part: str | None = None,
    limit: int | None = None,
    foreign: Sequence[Path] = (),
) -> Found:
    """Make the missing trainings of a plan, then judge; an interrupted study is resumed.

    Args:
        lab: where it runs; each worker makes one training at a time.
        plan: the trainings and comparisons.
        only: sections; empty for all that are planned.
        part: of the labelled set; None for the plan's.
        limit: largest number of judged cases a scenario; trainings are not affected.
        foreign: files of layouts of another kind; without one there is no such section.

    Raises:
        LearnerError: a section that is not planned, or a file of layouts that is not there.
        as :meth:`steadyload.learners.plans.trainings.Workshop.make`, :func:`judge_table` and
        :func:`judge_foreign`.
    """
    workshop = Workshop(plan, lab.work)  # of the whole plan, which says what is a method
    plan = dataclasses.replace(_chosen(plan, only, foreign), part=Part(part or plan.part))
    sections = plan.sections()
    judged = JudgedPart(plan.part, lab.work, limit)
    workshop.make(
        sections,
        workers=lab.workers,
        known=judged.knows,
        generating=partial(lab.progress, "item lists"),
        training=partial(lab.progress, "trainings"),
    )
    runs = {each.name: workshop.runs(each.name) for each in plan.needed(sections)}
    for run in (run for each in runs.values() for run in each):
        judged.keep(run)

    def contrast(planned: Contrast) -> list[Trained]:
        first = runs[planned.baseline]
        return [judged.row(first), *(judged.row(runs[name], first) for name in planned.trainings)]

    calibrations = []
    for name in plan.calibration.judges if plan.calibration else ():
        title, where = name, name
        if own := runs.get(name):
            title, where = f"{own[0].training.title}, seed {own[0].seed}", str(own[0].weights)
        calibrations.append(judged.calibration(title, load_weights(where)))
    named = dict.fromkeys(plan.method_names(sections))
    shipped = {name: load_weights(name) for name in named if name in shipped_weights()}
    return Found(
        part=str(plan.part),
        cases=len(judged.cases),
        item_lists=len(set(judged.cases.instances)),
        scenarios=judged.scenarios,
        table=judge_table(lab, plan, workshop, limit) if plan.table else None,
        size=[
            Curve(curve.title, [judged.row(runs[name]) for name in curve.trainings])
            for curve in plan.size
        ],
        sources=contrast(plan.sources) if plan.sources else (),
        agreement=_agreement(plan, workshop),
        remedies=contrast(plan.remedies) if plan.remedies else (),
        calibrated=[one for both, _ in calibrations for one in both],
        abstaining=[one for _, one in calibrations],
        leaks=[contrast(planned) for planned in plan.leak],
        foreign=judge_foreign(lab, plan.foreign, foreign, limit) if plan.foreign else None,
        trainings=[
            *(
                provenance_row(f"{name}, shipped", weights.manifest, weights.digest)
                for name, weights in shipped.items()
            ),
            *(judged.provenance(run) for each in runs.values() for run in each),
        ],
        made_with=provenance_lines(),
    )


def _chosen(plan: Plan, only: Collection[str], foreign: Sequence[Path]) -> Plan:
    """The plan with the sections that are asked for, all where none is named."""
    for name in only:
        if name not in plan.sections():
            raise LearnerError(
                f"section {str(name)!r} is not planned; {nearest(name, plan.sections())}"
            )
    chosen = {Section(name) for name in only or plan.sections()}
    if Section.FOREIGN in chosen and not foreign:
        if only:
            raise LearnerError("section 'foreign' needs files of layouts: --foreign FILE")
        chosen.remove(Section.FOREIGN)
    for file in foreign:  # so that an error is raised before hours of training
        if not file.is_file():
            raise LearnerError(f"{file}: no such file of layouts")
    return plan.only(chosen)


def _agreement(plan: Plan, workshop: Workshop) -> list[Share]:
    """By source of labels, how often they are those of the set that the first training learns."""
    needed = plan.needed([Section.SOURCES])
    names = dict.fromkeys(name for each in needed for name in each.data if name != BENCHMARK)
    first = plan.trainings[plan.sources.baseline].data[0] if plan.sources else BENCHMARK
    if first == BENCHMARK:
        return []
    sets = {name: load_benchmark(workshop.set_folder(name)).cases.set_index(KEYS) for name in names}
    basis, found = sets.pop(first), []
    for name, other in sets.items():
        both = basis.index.intersection(other.index)
        mine, theirs = (each.loc[both, "failing_step"].fillna(-1) for each in (basis, other))
        same = (mine == theirs).to_numpy(bool)
        if len(both):
            found.append(Share(plan.sets[name].label, share(same, basis.loc[both, "instance"])))
    return found
