"""A part of the labelled set, and the verdicts of trained weights on its cases."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from steadyload.layouts.benchmark import Part
from steadyload.learners.features import Array32, FeatureKind
from steadyload.learners.jobs import BENCHMARK
from steadyload.learners.scoring import names_the_label
from steadyload.learners.sequences import Sequences, load_sequences
from steadyload.learners.weights import Weights, load_weights
from steadyload.runs.accuracy import accuracy_of_seeds, difference_of_seeds
from steadyload.runs.evaluation import ALL
from steadyload.studies.learned.summary import ProvenanceRow, TrainedRow
from steadyload.studies.learned.trainings import Run

Rights = NDArray[np.bool_]
"""Mask of scores that are the label's, shape (seeds, cases)."""


class JudgedPart:
    """Cases with labels, in one order for all methods.

    Layouts outside of the training range are judged, too: a small training set has a narrow range
    whatever the features are.

    Args:
        part: of the labelled set.
        limit: largest number of cases a scenario; None for all.
    """

    def __init__(self, part: Part, limit: int | None = None) -> None:
        self.part, self._limit = part, limit
        self._sequences: dict[FeatureKind, Sequences] = {}
        self._known: dict[Path, NDArray[np.bool_]] = {}

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
        return np.array([self._right(run.weights) for run in runs])

    def _right(self, folder: Path) -> NDArray[np.bool_]:
        if folder not in self._known:
            told = self.probabilities(load_weights(folder))
            self._known[folder] = names_the_label(told, self.cases)
        return self._known[folder]

    def row(self, runs: Sequence[Run], against: Sequence[Run] = ()) -> TrainedRow:
        """Result of a training.

        Args:
            runs: its seeds.
            against: the seeds of the training that it is compared with.
        """
        rights, others = self.rights(runs), self.rights(against)
        lists, groups = self.cases.instances, self._groups()
        manifest = load_weights(runs[0].weights).manifest
        options = manifest["members"][0]["options"]
        return TrainedRow(
            title=runs[0].training.title,
            features=manifest["features"],
            network=manifest["network"],
            symmetries=int(options["symmetries"]),
            labels=_label_sources(manifest["data"], runs[0]),
            item_lists=manifest["item_lists"],
            cases=manifest["cases"],
            accuracy={g: accuracy_of_seeds(rights[:, m], lists[m]) for g, m in groups.items()},
            seeds={g: tuple(rights[:, m].mean(axis=1).tolist()) for g, m in groups.items()},
            difference={
                group: difference_of_seeds(rights[:, mask], others[:, mask], lists[mask])
                for group, mask in groups.items()
            }
            if against
            else None,
        )

    def _groups(self) -> dict[str, NDArray[np.bool_]]:
        scenarios = self.cases.scenarios
        return {ALL: np.ones(len(scenarios), dtype=bool)} | {
            s: np.asarray(scenarios == s) for s in self.scenarios
        }


def provenance_row(title: str, weights: Weights) -> ProvenanceRow:
    """Provenance of weights."""
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


def _label_sources(data: Sequence[Mapping[str, object]], run: Run) -> str:
    """Sources of the labels of a training, those of the training that it continues first."""
    own = " and ".join(
        "labelled set" if source["name"] == BENCHMARK else str(source.get("label", source["name"]))
        for source in data
    )
    if run.start is None:
        return own
    before = load_weights(run.start).manifest["data"]
    return f"{_label_sources(before, dataclasses.replace(run, start=None))}, then {own}"
