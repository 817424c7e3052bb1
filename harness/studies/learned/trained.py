"""Verdicts of trained weights on a part of the labelled set, and how often they are right.

Shares are 0 to 1. In mappings by group the key :data:`ALL` means all cases together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numpy as np

from steadyload.layouts.benchmark import Part
from steadyload.learners.features import VERSION as FEATURES
from steadyload.learners.features import Array32, FeatureKind
from steadyload.learners.inference import VERSION as INFERENCE
from steadyload.learners.plans.trainings import Run
from steadyload.learners.scoring import confidence, items_safe, names_the_label
from steadyload.learners.sequences import BENCHMARK, Sequences, load_sequences
from steadyload.learners.weights import Weights, load_weights
from steadyload.reports.columns import cell, column, duration, names, percent, plain_percent, row
from steadyload.runs.accuracy import accuracy_of_seeds
from steadyload.runs.comparison import difference
from steadyload.runs.evaluation import ALL
from steadyload.runs.provenance import key_of
from steadyload.runs.store import JSON, Store, locked
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.reliability import abstention, reliability
from steadyload.studies.reliability import Abstaining, Calibrated, abstaining, calibrated

VERSION = 1
"""Version of what is kept of trainings: raised when its meaning changes."""


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
    symmetries: int = column(left=True, about="of the pallet, of 8, that are drawn from; 1 is none")
    labels: str = column(about="their source")
    cases: int = column(about="that were learnt from")
    item_lists: int = column("item lists", about="of these")
    accuracy: Mapping[str, Estimate] = column("{} %", percent, "mean of the seeds")
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


class JudgedPart:
    """Cases with labels, in one order for all methods, and the verdicts of trained weights on them.

    Layouts outside of the training range are judged, too: a small training set has a narrow range
    whatever the features are.

    Args:
        part: of the labelled set.
        folder: of what is kept of runs, which then need no weights.
        limit: largest number of cases a scenario; None for all.
    """

    def __init__(self, part: Part, folder: Path, limit: int | None = None) -> None:
        self._folder = folder
        self._sequences = cache(lambda kind: load_sequences(kind, part, limit=limit))
        self._store: Store[dict[str, Any], list[Any]] = Store(folder / "said", JSON)

    @cached_property
    def cases(self) -> Sequences:
        """The cases with their labels, scenarios and item lists, whatever the features."""
        return self._sequences(FeatureKind.PLAIN)

    @property
    def scenarios(self) -> tuple[str, ...]:
        """All scenarios of the cases."""
        return tuple(dict.fromkeys(map(str, self.cases.scenarios)))

    def knows(self, run: Run) -> bool:
        """True if the verdicts of a run are kept."""
        return not self._store.missing([self._key(run)])

    def keep(self, run: Run) -> None:
        """Judge the part by the weights of a run, and keep the verdicts, unless they are kept.

        Raises:
            ResultsError: another run is at work in the folder.
            LearnerError: the weights cannot be read.
        """
        if self.knows(run):
            return
        weights = load_weights(run.weights)
        safe = items_safe(self._probabilities(weights), self.cases.counts)
        said = {"manifest": weights.manifest, "digest": weights.digest, "safe": safe.tolist()}
        with locked(self._folder):
            self._store.write(self._key(run), [said])

    def _said(self, run: Run) -> Mapping[str, Any]:
        (found,) = self._store.read(self._key(run))
        return found

    def _key(self, run: Run) -> str:
        return key_of(
            {
                "training": run.folder.name,
                "cases": self.cases.fingerprint(),
                "version": VERSION,
                "features": FEATURES,
                "inference": INFERENCE,
            }
        )

    def _probabilities(self, weights: Weights) -> Array32:
        """Probabilities that steps are unstable, (cases, most items): mean of all members."""
        rows = self._sequences(weights.kind).padded()
        found: Array32 = np.mean([n.probabilities_of_many(rows) for n in weights.networks], axis=0)
        return found

    def row(self, runs: Sequence[Run], against: Sequence[Run] = ()) -> Trained:
        """How often the seeds of a training are right, and those that they are compared with."""
        rights, others = (
            np.array([np.equal(self._said(run)["safe"], self.cases.safe) for run in each])
            for each in (runs, against)
        )
        lists, scenarios = self.cases.instances, self.cases.scenarios
        groups = {ALL: np.ones(len(lists), bool)} | {s: scenarios == s for s in self.scenarios}
        seeds = {g: tuple(rights[:, m].mean(axis=1).tolist()) for g, m in groups.items()}
        manifest = self._said(runs[0])["manifest"]
        return Trained(
            title=runs[0].training.title,
            features=manifest["features"],
            network=manifest["network"],
            symmetries=int(manifest["members"][0]["options"]["symmetries"]),
            labels=self._label_sources(runs[0]),
            cases=manifest["cases"],
            item_lists=manifest["item_lists"],
            accuracy={g: accuracy_of_seeds(rights[:, m], lists[m]) for g, m in groups.items()},
            all_seeds=seeds.pop(ALL),
            seeds=seeds,
            difference={
                g: difference(rights[:, m], others[:, m], lists[m]) for g, m in groups.items()
            }
            if against
            else None,
        )

    def _label_sources(self, run: Run) -> str:
        """Sources of the labels of a training, those of the training that it continues first."""
        own = " and ".join(
            "labelled set" if data["name"] == BENCHMARK else str(data.get("label", data["name"]))
            for data in self._said(run)["manifest"]["data"]
        )
        return f"{self._label_sources(run.start)}, then {own}" if run.start else own

    def provenance(self, run: Run) -> Provenance:
        """Where the weights of a run come from, without them."""
        said = self._said(run)
        return provenance_row(run.training.title, said["manifest"], said["digest"])

    def calibration(
        self, judge: str, weights: Weights
    ) -> tuple[tuple[Calibrated, Calibrated], Abstaining]:
        """Calibration of a learned method's probabilities, of steps and of scores."""
        data, probabilities = self.cases, self._probabilities(weights)
        steps = np.arange(probabilities.shape[1])
        labelled = steps < data.valid()[:, None]
        unstable = steps >= data.safe[:, None]
        lists = np.broadcast_to(data.instances[:, None], labelled.shape)
        sure, right = confidence(probabilities, data.counts), names_the_label(probabilities, data)
        of_steps = reliability(probabilities[labelled], unstable[labelled], lists[labelled])
        of_scores = reliability(sure, right, data.instances)
        return (
            calibrated(judge, "a step is unstable", of_steps),
            calibrated(judge, "a score is right", of_scores),
        ), abstaining(judge, abstention(sure, right, data.instances))


def provenance_row(title: str, manifest: Mapping[str, Any], digest: str) -> Provenance:
    """Where weights come from, by their manifest and digest."""
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
