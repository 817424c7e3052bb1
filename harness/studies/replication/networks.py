"""Networks as in the paper, trained on the folds of a split and tested on the rest."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import torch
from numpy.typing import NDArray

from steadyload.layouts.model import Layout
from steadyload.learners.features import FeatureKind, features
from steadyload.learners.inference import Network
from steadyload.learners.options import TrainingOptions, options_from, training_preset
from steadyload.learners.ranges import extent_of, trained_ranges
from steadyload.learners.scoring import items_safe
from steadyload.learners.sequences import Sequences
from steadyload.learners.training import Training
from steadyload.methods.spec import as_plain
from steadyload.runs.store import locked
from steadyload.studies.replication.splits import Fold, steps_safe

MEMBERS: tuple[tuple[int, float], ...] = (
    (125, 0.35e-3),
    (175, 0.15e-3),
    (150, 0.67e-3),
    (150, 0.19e-3),
    (200, 0.71e-3),
)
"""Hidden size and learning rate of the networks of Table 4; the first one is LSTM_1."""

PATIENCE = 100
"""Epochs without a better one before a training ends; the paper trains for all 700."""

Steps = NDArray[np.int64]
"""Items that a network says are placed safely, (cases,)."""


@dataclass(frozen=True, slots=True)
class Budget:
    """Limits of a training: ``epochs``, and wall seconds (``seconds``)."""

    epochs: int
    seconds: float


@dataclass(frozen=True, slots=True)
class Effort:
    """Epochs that a training took, the best of them, its time [s], and whether time cut it off."""

    epochs: int
    best_epoch: int
    seconds: float
    cut_off: bool


@dataclass(frozen=True)
class Material:
    """Labelled cases as sequences of features, made once for each kind of features.

    Args:
        cases: of :func:`steadyload.studies.replication.splits.labelled_cases`.
        layouts: of the cases, in their order.
    """

    cases: pd.DataFrame
    layouts: Sequence[Layout]

    def sequences(self, kind: FeatureKind) -> Sequences:
        """All cases, in their order."""
        return _sequences(self, kind)

    def __hash__(self) -> int:
        return id(self)

    def __eq__(self, other: object) -> bool:
        return self is other


@cache
def _sequences(material: Material, kind: FeatureKind) -> Sequences:
    rows, extents = [], []
    for layout in material.layouts:
        rows.append(features(layout, kind))
        extents.append(
            extent_of(
                layout.lower, layout.upper, layout.weights, layout.mass_offsets,
                layout.floor.corners, max(layout.pallet.size),
            )
        )  # fmt: skip
    cases = material.cases
    return Sequences(
        kind=kind,
        rows=np.concatenate(rows),
        starts=np.concatenate(([0], np.cumsum([len(row) for row in rows]))),
        safe=steps_safe(cases),
        scenarios=cases["scenario"].to_numpy(dtype=object),
        instances=cases["instance"].to_numpy(dtype=object),
        geometries=cases["geometry"].to_numpy(dtype=object),
        sets=np.full(len(cases), "files", dtype=object),
        ranges=trained_ranges(extents, kind),
    )


def paper_options(member: int, seed: int, **changes: Any) -> TrainingOptions:
    """The options of a network of Table 4, with some changed.

    Args:
        member: of :data:`MEMBERS`.
        seed: of the training.
        changes: of the options.

    Raises:
        LearnerError: a change that is not allowed.
    """
    hidden, rate = MEMBERS[member]
    own = {"hidden": hidden, "learning_rate": rate, "seed": seed, "patience": PATIENCE}
    return options_from(
        as_plain(training_preset("paper").options) | own | changes, where="replication"
    )


def network_steps(
    material: Material,
    fold: Fold,
    options: Sequence[TrainingOptions],
    work: Path,
    budget: Budget,
    progress: Callable[[], None] = lambda: None,
) -> tuple[Steps, list[Effort]]:
    """Train networks on a fold, or take up their trainings, and let their mean judge its test.

    Args:
        material: all cases.
        fold: of a split.
        options: of the networks; their probabilities are averaged (Eq. 8).
        work: folder of the trainings; each has a folder of its own, named by all it depends on.
        budget: of every network.
        progress: called after every epoch.

    Returns:
        Items placed safely, by case of the test, and the effort of every training.

    Raises:
        ResultsError: another run is at work in the folder.
    """
    data = material.sequences(options[0].features)
    learnt, stopping = data.chosen(fold.train), data.chosen(fold.validation)
    asked = data.chosen(fold.test)
    probabilities, efforts = [], []
    for own in options:
        folder = work / _folder(fold, own, learnt, stopping)
        torch.set_num_threads(1)
        with locked(folder):
            training = Training(folder, own, learnt, stopping, held_out=None)
            trained = training.run(budget=budget.seconds, progress=lambda epoch: progress())
        last = trained.history[-1]
        efforts.append(
            Effort(last.number, last.best_epoch, last.seconds, cut_off=not training.finished)
        )
        arrays: Mapping[str, np.ndarray] = trained.arrays
        probabilities.append(Network(arrays).probabilities_of_many(asked.padded()))
    return items_safe(np.mean(probabilities, axis=0), asked.counts), efforts


def _folder(fold: Fold, own: TrainingOptions, learnt: Sequences, stopping: Sequences) -> str:
    identity = [as_plain(own), learnt.fingerprint(), stopping.fingerprint()]
    text = json.dumps(identity, sort_keys=True, default=str)
    digest = hashlib.sha256(text.encode()).hexdigest()[:10]
    return f"{fold.kind}-{fold.number}-{own.features}-{own.hidden}-{own.seed}-{digest}"
