"""A part of the labelled set, and the verdicts of trained weights on its cases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from steadyload.layouts.benchmark import Part
from steadyload.learners.features import VERSION as FEATURES
from steadyload.learners.features import Array32, FeatureKind
from steadyload.learners.inference import VERSION as INFERENCE
from steadyload.learners.jobs import BENCHMARK
from steadyload.learners.plans.trainings import Run
from steadyload.learners.scoring import items_safe
from steadyload.learners.sequences import Sequences, load_sequences
from steadyload.learners.weights import Weights, load_weights
from steadyload.runs.accuracy import accuracy_of_seeds
from steadyload.runs.comparison import difference
from steadyload.runs.evaluation import ALL
from steadyload.runs.provenance import key_of
from steadyload.runs.store import JSON, Store, locked
from steadyload.studies.learned.summary import ProvenanceRow, TrainedRow

VERSION = 1
"""Version of what is kept of trainings: raised when its meaning changes."""

Rights = NDArray[np.bool_]
"""Mask of scores that are the label's, shape (seeds, cases)."""


@dataclass(frozen=True)
class Said:
    """Verdicts of the weights of a run on a part of the labelled set.

    Attributes:
        manifest: of the weights.
        digest: of the weights.
        right: mask of the cases whose score is the label's, (cases,).
    """

    manifest: Mapping[str, Any]
    digest: str
    right: NDArray[np.bool_]


class JudgedPart:
    """Cases with labels, in one order for all methods, and what trained weights say of them.

    Layouts outside of the training range are judged, too: a small training set has a narrow range
    whatever the features are.

    Args:
        part: of the labelled set.
        folder: of what is kept of runs, which then need no weights.
        limit: largest number of cases a scenario; None for all.
    """

    def __init__(self, part: Part, folder: Path, limit: int | None = None) -> None:
        self.part, self._folder, self._limit = part, folder, limit
        self._sequences: dict[FeatureKind, Sequences] = {}
        self._store: Store[dict[str, Any], list[Any]] = Store(folder / "said", JSON)

    def knows(self, run: Run) -> bool:
        """True if what a run says is kept."""
        return not self._store.missing([self._key(run)])

    def keep(self, run: Run) -> None:
        """Judge the part by the weights of a run, unless it is known, and keep what they say.

        Raises:
            ResultsError: another run is at work in the folder.
            LearnerError: the weights cannot be read.
        """
        if self.knows(run):
            return
        weights = load_weights(run.weights)
        safe = items_safe(self.probabilities(weights), self.cases.counts)
        said = {"manifest": weights.manifest, "digest": weights.digest, "safe": safe.tolist()}
        with locked(self._folder):
            self._store.write(self._key(run), [said])

    def said(self, run: Run) -> Said:
        """The verdicts of a run that is known."""
        (found,) = self._store.read(self._key(run))
        return Said(found["manifest"], found["digest"], np.equal(found["safe"], self.cases.safe))

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

    def sequences(self, kind: FeatureKind) -> Sequences:
        """The cases as features and labels."""
        if kind not in self._sequences:
            self._sequences[kind] = load_sequences(kind, self.part, limit=self._limit)
        return self._sequences[kind]

    @cached_property
    def cases(self) -> Sequences:
        """The cases with their labels, scenarios and item lists, whatever the features."""
        return self.sequences(FeatureKind.PLAIN)

    @property
    def scenarios(self) -> tuple[str, ...]:
        """All scenarios of the cases."""
        return tuple(dict.fromkeys(str(s) for s in self.cases.scenarios))

    def probabilities(self, weights: Weights) -> Array32:
        """Probabilities that steps are unstable, (cases, most items): mean of all members."""
        rows = self.sequences(weights.kind).padded()
        found: Array32 = np.mean([n.probabilities_of_many(rows) for n in weights.networks], axis=0)
        return found

    def rights(self, runs: Sequence[Run]) -> Rights:
        """Mask of the cases on which each seed of a training is right, (seeds, cases)."""
        return np.array([self.said(run).right for run in runs])

    def row(self, runs: Sequence[Run], against: Sequence[Run] = ()) -> TrainedRow:
        """Result of a training.

        Args:
            runs: its seeds.
            against: the seeds of the training that it is compared with.
        """
        rights, others = self.rights(runs), self.rights(against)
        lists, groups = self.cases.instances, self._groups()
        manifest = self.said(runs[0]).manifest
        options = manifest["members"][0]["options"]
        return TrainedRow(
            title=runs[0].training.title,
            features=manifest["features"],
            network=manifest["network"],
            symmetries=int(options["symmetries"]),
            labels=self._label_sources(runs[0]),
            item_lists=manifest["item_lists"],
            cases=manifest["cases"],
            accuracy={g: accuracy_of_seeds(rights[:, m], lists[m]) for g, m in groups.items()},
            seeds={g: tuple(rights[:, m].mean(axis=1).tolist()) for g, m in groups.items()},
            difference={
                group: difference(rights[:, mask], others[:, mask], lists[mask])
                for group, mask in groups.items()
            }
            if against
            else None,
        )

    def _label_sources(self, run: Run) -> str:
        """Sources of the labels of a training, those of the training that it continues first."""
        own = " and ".join(
            "labelled set" if data["name"] == BENCHMARK else str(data.get("label", data["name"]))
            for data in self.said(run).manifest["data"]
        )
        return f"{self._label_sources(run.start)}, then {own}" if run.start else own

    def _groups(self) -> dict[str, NDArray[np.bool_]]:
        scenarios = self.cases.scenarios
        return {ALL: np.ones(len(scenarios), dtype=bool)} | {
            s: np.asarray(scenarios == s) for s in self.scenarios
        }


def provenance_row(title: str, weights: Weights | Said) -> ProvenanceRow:
    """Provenance of weights, or of what is kept of them."""
    manifest = weights.manifest
    members = manifest["members"]
    return ProvenanceRow(
        title=title,
        seeds=tuple(int(m["options"]["seed"]) for m in members),
        command=manifest["command"],
        commit=str(manifest["made_by"]["git"] or "installed package"),
        cases=manifest["cases"],
        item_lists=manifest.get("item_lists"),
        epochs=tuple(m["epochs"] for m in members),
        best_epochs=tuple(m["best_epoch"] for m in members),
        validation=manifest["validation"]["mean"]["all"],
        seconds=sum(m["seconds"] for m in members),
        digest=weights.digest,
    )
