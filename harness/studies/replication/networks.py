"""Networks as in the paper, trained on the folds of a split and tested on the rest."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import torch
from numpy.typing import NDArray

from steadyload.layouts.model import Layout
from steadyload.learners import LearnerError
from steadyload.learners.features import FeatureKind, features
from steadyload.learners.inference import Network
from steadyload.learners.options import TrainingOptions, options_from, training_preset
from steadyload.learners.ranges import extent_of, trained_ranges
from steadyload.learners.scoring import items_safe
from steadyload.learners.sequences import Sequences
from steadyload.learners.training import Training
from steadyload.methods.spec import as_plain
from steadyload.runs.pool import SinglePart, run_units
from steadyload.runs.store import locked
from steadyload.studies.replication.splits import Fold, steps_safe

NETWORKS = training_preset("paper-ensemble").networks
"""Hidden size and learning rate of the networks of Table 4; the first one is LSTM_1."""

PATIENCE = 100
"""Epochs without a better one before a training ends; the paper trains for all 700."""

Steps = NDArray[np.int64]
"""Items that a network says are placed safely, (cases,)."""


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
        member: of :data:`NETWORKS`.
        seed: of the training.
        changes: of the options.

    Raises:
        LearnerError: a change that is not allowed.
    """
    preset = training_preset("paper-ensemble")
    own = {**preset.networks[member], "seed": seed, "patience": PATIENCE}
    return options_from(as_plain(preset.options) | own | changes, where="replication")


@dataclass(frozen=True)
class NetworkTraining(SinglePart):
    """The training of a network on a fold of a split, in a folder of its own.

    Attributes:
        fold: of a split.
        options: of the network.
        learnt: what it learns from.
        stopping: what says which epoch is best.
        work: folder of all trainings; that of this one is named by all it depends on.
        budget: seconds of CPU time, over all runs.
    """

    fold: Fold
    options: TrainingOptions
    learnt: Sequences
    stopping: Sequences
    work: Path
    budget: float

    def describe(self, part: int) -> str:
        """Description of the training for messages."""
        return f"{self.fold.kind} {self.fold.number}, {self.options.hidden} cells"


@dataclass(frozen=True)
class TrainedNetwork:
    """A network with its weights by name, and the effort of its training."""

    options: TrainingOptions
    arrays: Mapping[str, np.ndarray]
    effort: Effort


def train_networks(
    material: Material,
    wanted: Iterable[tuple[Fold, TrainingOptions]],
    work: Path,
    budget: float,
    *,
    workers: int = 0,
) -> Iterator[tuple[Fold, TrainedNetwork]]:
    """Train networks, or take up their trainings, each with one thread.

    Args:
        material: all cases.
        wanted: folds and options of networks.
        work: folder of the trainings.
        budget: seconds of CPU time of every network, over all runs.
        workers: processes that train; 0 trains in this one.

    Yields:
        Every network with its fold, in the order in which they are trained.

    Raises:
        ResultsError: another run is at work in the folder of a training.
        LearnerError: a training ended its process twice.
    """
    trainings = (
        NetworkTraining(
            fold,
            options,
            material.sequences(options.features).chosen(fold.train),
            material.sequences(options.features).chosen(fold.validation),
            work,
            budget,
        )
        for fold, options in wanted
    )
    for training, (network,) in run_units(_train, trainings, workers=workers, crashed=_refuse):
        yield training.fold, network


def items_safe_by(networks: Sequence[TrainedNetwork], material: Material, fold: Fold) -> Steps:
    """Items placed safely, by case of the fold's test, by the mean of networks (Eq. 8)."""
    asked = material.sequences(networks[0].options.features).chosen(fold.test)
    rows = asked.padded()
    found = [Network(network.arrays).probabilities_of_many(rows) for network in networks]
    return items_safe(np.mean(found, axis=0), asked.counts)


def _train(training: NetworkTraining) -> Iterator[TrainedNetwork]:
    return (_trained(training) for _ in range(1))


def _trained(asked: NetworkTraining) -> TrainedNetwork:
    folder = asked.work / _folder(asked.fold, asked.options, asked.learnt, asked.stopping)
    torch.set_num_threads(1)
    with locked(folder):
        training = Training(folder, asked.options, asked.learnt, asked.stopping, held_out=None)
        trained = training.run(budget=asked.budget)
    last = trained.history[-1]
    effort = Effort(last.number, last.best_epoch, last.seconds, cut_off=not training.finished)
    return TrainedNetwork(asked.options, trained.arrays, effort)


def _refuse(training: NetworkTraining, part: int, reason: str) -> TrainedNetwork:
    raise LearnerError(f"{training.describe(part)}: {reason}")


def _folder(fold: Fold, own: TrainingOptions, learnt: Sequences, stopping: Sequences) -> str:
    identity = [as_plain(own), learnt.fingerprint(), stopping.fingerprint()]
    text = json.dumps(identity, sort_keys=True, default=str)
    digest = hashlib.sha256(text.encode()).hexdigest()[:10]
    return f"{fold.kind}-{fold.number}-{own.features}-{own.hidden}-{own.seed}-{digest}"
