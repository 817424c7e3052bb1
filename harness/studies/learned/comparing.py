"""The study of learned methods: from a plan to the rows of its page.

Shares are 0 to 1. In mappings by group the key :data:`ALL` means all cases together.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.learners import LearnerError
from steadyload.learners.plans.plan import Contrast, Plan, Section
from steadyload.learners.plans.trainings import Run, Workshop
from steadyload.learners.plans.verdicts import JudgedPart
from steadyload.learners.scoring import confidence, names_the_label
from steadyload.learners.sequences import BENCHMARK
from steadyload.learners.weights import Weights, load_weights, shipped_weights
from steadyload.reports.columns import cell, column, duration, names, percent, plain_percent, row
from steadyload.runs.accuracy import accuracy_of_seeds
from steadyload.runs.comparison import difference
from steadyload.runs.evaluation import ALL
from steadyload.runs.provenance import provenance_lines
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share
from steadyload.statistics.reliability import abstention, reliability
from steadyload.studies.kit import Lab
from steadyload.studies.learned.foreign import Agreeing, Foreign, judge_foreign
from steadyload.studies.learned.table import Table, judge_table
from steadyload.studies.reliability import Abstaining, Bin, Calibrated, abstaining, calibrated


def _spread(seeds: Sequence[float]) -> str:
    if len(seeds) < 2:
        return cell(None)
    return f"{100 * min(seeds):.1f} to {100 * max(seeds):.1f} ({len(seeds)})"


def _listed(numbers: Sequence[int]) -> str:
    return names(map(str, numbers))


@row
class Trained:
    """Trainings that differ in their seed alone, on the cases that are judged."""

    title: str = column("training")
    features: str = column()
    network: str = column()
    symmetries: int = column(about="of the pallet, of 8, that are drawn from; 1 is none")
    labels: str = column(about="their source")
    cases: int = column(about="that were learnt from")
    item_lists: int = column("item lists", about="of these")
    accuracy: Mapping[str, Estimate] = column("{} %", percent, "mean of the seeds")
    lost: float = column("S1 minus S2b", plain_percent, "of the accuracies")
    all_seeds: Sequence[float] = column("all seeds", _spread, "accuracy of each", notable=True)
    seeds: Mapping[str, Sequence[float]] = column("{} seeds", _spread, "by scenario")
    difference: Mapping[str, Estimate] | None = column(
        "{}", percent, "its accuracy minus that of the training that it is compared with",
        default=None,
    )  # fmt: skip

    @property
    def n(self) -> int:
        """Number of cases that are judged."""
        return self.accuracy[ALL].n


@row
class Provenance:
    """Where weights come from; a number a member where there are several."""

    title: str = column("training")
    seeds: Sequence[int] = column(form=_listed, left=True)
    commit: str = column()
    digest: str = column("weights")
    cases: int = column()
    item_lists: int | None = column("item lists", about="None where weights do not state it")
    epochs: Sequence[int] = column(form=_listed)
    best_epochs: Sequence[int] = column("best epoch", _listed)
    validation: float = column("validation %", plain_percent, "accuracy on that part")
    seconds: float = column("time", duration, "of all epochs")
    command: str


class Curve(NamedTuple):
    """Trainings that differ in the size of their training set."""

    title: str
    rows: Sequence[Trained]


class Scored(NamedTuple):
    """Accuracy of a training on the cases of one scenario."""

    scenario: str
    title: str
    accuracy: Estimate
    seeds: Sequence[float]


@row
class Found:
    """All results on learned methods; parts that were not asked for are empty.

    ``labelled_set``: word or folder, None for the large set of the package; ``part``: of it, on
    which all are evaluated; ``item_lists``: number of clusters, ``leak_lists``: of those on which
    leaks are. ``sources``, ``remedies``: the first training, and others that are compared with it;
    ``leaks``: likewise, the others also learnt from layouts of held-out item lists.
    ``agreement``: by source of labels, how often they are those of the first one.
    """

    labelled_set: str | None
    part: str
    cases: int
    item_lists: int
    scenarios: Sequence[str]
    table: Table | None = None
    size: Sequence[Curve] = ()
    sources: Sequence[Trained] = ()
    agreement: Sequence[Agreeing] = ()
    remedies: Sequence[Trained] = ()
    calibrated: Sequence[Calibrated] = ()
    abstaining: Sequence[Abstaining] = ()
    leaks: Sequence[Sequence[Trained]] = ()
    leak_lists: int = 0
    foreign: Foreign | None = None
    trainings: Sequence[Provenance] = ()
    made_with: Mapping[str, str] = dataclasses.field(default_factory=dict)

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


def compare(lab: Lab, plan: Plan, foreign: Sequence[Path] = (), limit: int | None = None) -> Found:
    """Make the missing trainings of a plan, then judge; an interrupted study is resumed.

    The options are those of the study.
    """
    workshop = Workshop(plan, lab.work)  # of the whole plan, which says what is a method
    for file in foreign:  # so that an error is raised before hours of training
        if not file.is_file():
            raise LearnerError(f"{file}: no such file of layouts")
    if not foreign:
        plan = dataclasses.replace(plan, foreign=None)
    sections = plan.sections()
    judged = JudgedPart(plan.part, lab.work, limit, plan.directory)
    # Only the large set has held-out item lists that trainings can leak from.
    of_leaks = JudgedPart(plan.part, lab.work, limit) if plan.directory else judged
    runs = {each.name: workshop.runs(each.name) for each in plan.needed(sections)}
    places = [
        (place, [run for each in plan.needed(chosen) for run in runs[each.name]])
        for place, chosen in (
            (judged, [s for s in sections if s != Section.LEAK]),
            (of_leaks, [s for s in sections if s == Section.LEAK]),
        )
    ]

    def keep(run: Run) -> None:
        for place, judging in places:
            if run in judging:
                place.keep(run)

    workshop.make(
        sections,
        workers=lab.workers,
        known=lambda run: all(place.knows(run) for place, own in places if run in own),
        made=keep,
        generating=partial(lab.progress, "item lists"),
        training=partial(lab.progress, "trainings"),
    )
    every: dict[Path, tuple[JudgedPart, Run]] = {}
    for place, judging in places:
        for run in judging:
            place.keep(run)  # also those that were trained before
            every.setdefault(run.folder, (place, run))

    def contrast(planned: Contrast, judged: JudgedPart) -> list[Trained]:
        first = runs[planned.baseline]
        others = (_trained(judged, runs[name], first) for name in planned.trainings)
        return [_trained(judged, first), *others]

    calibrations = []
    for name in plan.calibration.judges if plan.calibration else ():
        own = runs[name][0] if name in runs else None
        weights = load_weights(own.weights if own else name)
        calibrations.append(_calibration(judged, own.title if own else name, weights))
    named = dict.fromkeys(plan.method_names(sections))
    shipped = {name: load_weights(name) for name in named if name in shipped_weights()}
    return Found(
        labelled_set=plan.directory,
        part=str(plan.part),
        cases=len(judged.cases),
        item_lists=len(set(judged.cases.instances)),
        scenarios=tuple(dict.fromkeys(map(str, judged.cases.scenarios))),
        table=judge_table(lab, plan, workshop, limit) if plan.table else None,
        size=[
            Curve(curve.title, [_trained(judged, runs[name]) for name in curve.trainings])
            for curve in plan.size
        ],
        sources=contrast(plan.sources, judged) if plan.sources else (),
        agreement=_agreement(plan, workshop),
        remedies=contrast(plan.remedies, judged) if plan.remedies else (),
        calibrated=[each for *both, _ in calibrations for each in both],
        abstaining=[each for *_, each in calibrations],
        leaks=[contrast(planned, of_leaks) for planned in plan.leak],
        leak_lists=len(set(of_leaks.cases.instances)) if plan.leak else 0,
        foreign=judge_foreign(lab, plan.foreign, foreign, limit) if plan.foreign else None,
        trainings=[
            *(
                _provenance(f"{name}, shipped", weights.manifest, weights.digest)
                for name, weights in shipped.items()
            ),
            *(
                _provenance(run.training.title, *place.said(run)[:2])
                for place, run in every.values()
            ),
        ],
        made_with=provenance_lines(),
    )


def _agreement(plan: Plan, workshop: Workshop) -> list[Agreeing]:
    """By source of labels, how often they are those of the set that the first training learns."""
    baseline = plan.trainings[plan.sources.baseline].data if plan.sources else ()
    generated = [name for name in baseline if name != BENCHMARK]
    if not generated:
        return []
    needed = plan.needed([Section.SOURCES])
    learnt = dict.fromkeys(name for each in needed for name in each.data if name != BENCHMARK)
    sets = {
        name: load_benchmark(workshop.set_folder(name)).cases.set_index(KEYS) for name in learnt
    }
    basis, found = sets.pop(generated[0]), []
    for name, other in sets.items():
        both = basis.join(other["failing_step"].rename("other"), how="inner")
        same = both["failing_step"].fillna(-1) == both["other"].fillna(-1)
        if len(both):
            found.append(Agreeing(plan.sets[name].label, share(same, both["instance"])))
    return found


def _trained(judged: JudgedPart, runs: Sequence[Run], against: Sequence[Run] = ()) -> Trained:
    """How often the seeds of a training are right, and those that they are compared with."""
    said = [judged.said(run) for run in runs]
    right = np.array([each.right for each in said])
    others = np.array([judged.said(run).right for run in against])
    lists, scenarios = judged.cases.instances, judged.cases.scenarios
    groups = {ALL: np.ones(len(lists), bool)}
    groups |= {str(name): scenarios == name for name in dict.fromkeys(scenarios)}
    seeds = {g: right[:, m].mean(axis=1).tolist() for g, m in groups.items()}
    accuracy = {g: accuracy_of_seeds(right[:, m], lists[m]) for g, m in groups.items()}
    manifest = said[0].manifest
    return Trained(
        title=runs[0].training.title,
        features=manifest["features"],
        network=manifest["network"],
        symmetries=int(manifest["members"][0]["options"]["symmetries"]),
        labels=judged.label_sources(runs[0]),
        cases=manifest["cases"],
        item_lists=manifest["item_lists"],
        accuracy=accuracy,
        lost=accuracy["S1"].value - accuracy["S2b"].value,
        all_seeds=seeds.pop(ALL),
        seeds=seeds,
        difference={g: difference(right[:, m], others[:, m], lists[m]) for g, m in groups.items()}
        if against
        else None,
    )


def _calibration(
    judged: JudgedPart, title: str, weights: Weights
) -> tuple[Calibrated, Calibrated, Abstaining]:
    """Calibration of a learned method's probabilities, of steps and of scores."""
    data, probabilities = judged.cases, judged.probabilities(weights)
    steps = np.arange(probabilities.shape[1])
    labelled = steps < data.valid()[:, None]
    unstable = steps >= data.safe[:, None]
    lists = np.broadcast_to(data.instances[:, None], labelled.shape)
    sure, right = confidence(probabilities, data.counts), names_the_label(probabilities, data)
    of_steps = reliability(probabilities[labelled], unstable[labelled], lists[labelled])
    of_scores = reliability(sure, right, data.instances)
    return (
        calibrated(title, "a step is unstable", of_steps),
        calibrated(title, "a score is right", of_scores),
        abstaining(title, abstention(sure, right, data.instances)),
    )


def _provenance(title: str, manifest: Mapping[str, Any], digest: str) -> Provenance:
    members = manifest["members"]
    return Provenance(
        title=title,
        seeds=[int(member["options"]["seed"]) for member in members],
        commit=str(manifest["made_by"]["git"] or "installed package"),
        digest=digest,
        cases=manifest["cases"],
        item_lists=manifest.get("item_lists"),
        epochs=[member["epochs"] for member in members],
        best_epochs=[member["best_epoch"] for member in members],
        validation=manifest["validation"]["mean"]["all"],
        seconds=sum(member["seconds"] for member in members),
        command=manifest["command"],
    )
