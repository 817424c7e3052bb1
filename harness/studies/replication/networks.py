"""Networks as in the paper, trained on the folds of a split and tested on the rest."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import torch
from numpy.typing import NDArray

from steadyload.layouts.model.layout import Layout
from steadyload.learners.features import Array32, FeatureKind, features
from steadyload.learners.inference import Network
from steadyload.learners.options import TrainingOptions, options_from, training_preset
from steadyload.learners.ranges import extent_of, trained_ranges
from steadyload.learners.scoring import items_safe
from steadyload.learners.sequences import Sequences
from steadyload.learners.training import VERSION, Training
from steadyload.methods.contract.spec import as_plain
from steadyload.progress import Progress, silent
from steadyload.runs.pool import SinglePart
from steadyload.runs.provenance import key_of
from steadyload.runs.store import CHECKPOINTS, Store, locked, parquet
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
    """The training of a network on a fold of a split, and what it says of the fold's test.

    Attributes:
        key: of its shard: a hash of all that it depends on.
        fold: number and kind of its fold, and the size of the network, for messages.
        options: of the network.
        learnt: what it learns from.
        stopping: what says which epoch is best.
        asked: what it is tested on.
        folder: of its checkpoint.
        budget: seconds of CPU time, over all runs.
    """

    key: str
    fold: str
    options: TrainingOptions
    learnt: Sequences
    stopping: Sequences
    asked: Sequences
    folder: Path
    budget: float

    @classmethod
    def of(
        cls, fold: Fold, options: TrainingOptions, material: Material, work: Path, budget: float
    ) -> NetworkTraining:
        """The training of a network on a fold, with its checkpoint below ``work``."""
        every = material.sequences(options.features)
        learnt, stopping, asked = map(every.chosen, (fold.train, fold.validation, fold.test))
        identity = [as_plain(options), learnt.fingerprint(), stopping.fingerprint()]
        key = key_of(
            {
                "training": json.loads(json.dumps(identity, default=str)),
                "tested on": asked.fingerprint(),
                "budget": budget,
                "version": VERSION,
                "torch": torch.__version__.partition("+")[0],
            }
        )
        return cls(
            key,
            f"{fold.kind} {fold.number}, {options.hidden} cells",
            options,
            learnt,
            stopping,
            asked,
            work / f"{fold.kind}-{fold.number}-{options.features}-{options.hidden}-{key}",
            budget,
        )

    def describe(self, part: int) -> str:
        """Description of the training for messages."""
        return self.fold


@dataclass(frozen=True)
class FoldNetwork:
    """Probabilities that a trained network gives the test of its fold, and its effort.

    Attributes:
        effort: of its training.
        probabilities: that steps are unstable, (cases, most items), by case of the fold's test.
    """

    effort: Effort
    probabilities: Array32


_TESTED = pa.schema(
    [
        pa.field("epochs", pa.int32(), nullable=False),
        pa.field("best_epoch", pa.int32(), nullable=False),
        pa.field("seconds", pa.float64(), nullable=False),
        pa.field("cut_off", pa.bool_(), nullable=False),
        pa.field("cases", pa.int32(), nullable=False),
        pa.field("probabilities", pa.list_(pa.float32()), nullable=False),
    ]
)
"""A network a row; the probabilities of its cases follow each other."""


def networks_on_folds(
    material: Material,
    wanted: Sequence[tuple[Fold, TrainingOptions]],
    work: Path,
    budget: float,
    *,
    workers: int = 0,
    progress: Progress = silent,
) -> Iterator[FoldNetwork]:
    """Train and test the networks that are missing, each with one thread, and return all.

    Args:
        material: all cases.
        wanted: folds and options of networks.
        work: folder of what networks say, ``tested``, and of checkpoints, :data:`CHECKPOINTS`,
            which an interrupted training continues from.
        budget: seconds of CPU time of every network, over all runs.
        workers: processes that train; 0 trains in this one.
        progress: called with networks done and networks in all.

    Yields:
        Every network, in the order in which they are wanted.

    Raises:
        ResultsError: another run is at work in the folder, or a training ended its process twice.
        LearnerError: the checkpoint of a training is damaged.
    """

    def units() -> Iterator[NetworkTraining]:
        # One after the other: together their sequences take gigabytes.
        for fold, options in wanted:
            yield NetworkTraining.of(fold, options, material, work / CHECKPOINTS, budget)

    with locked(work):
        store = Store(work / "tested", parquet(_TESTED))
        survey = store.survey(units())
        store.complete(units(), _train, workers=workers, progress=progress, survey=survey)
    for key in survey.keys:
        (row,) = store.read(key).to_dict("records")
        effort = Effort(*(row[name] for name in ("epochs", "best_epoch", "seconds", "cut_off")))
        told = np.asarray(row["probabilities"], dtype=np.float32)
        yield FoldNetwork(effort, told.reshape(row["cases"], -1))


def items_safe_by(networks: Sequence[FoldNetwork], fold: Fold, cases: pd.DataFrame) -> Steps:
    """Items placed safely, by case of the fold's test, by the mean of networks (Eq. 8).

    Args:
        networks: that were tested on the fold.
        fold: of a split of ``cases``.
        cases: of :func:`steadyload.studies.replication.splits.labelled_cases`.
    """
    counts = cases.loc[fold.test, "item_count"].to_numpy()
    return items_safe(np.mean([each.probabilities for each in networks], axis=0), counts)


def _train(training: NetworkTraining) -> Iterator[dict[str, Any]]:
    return (_trained(training) for _ in range(1))


def _trained(asked: NetworkTraining) -> dict[str, Any]:
    torch.set_num_threads(1)
    with locked(asked.folder):
        training = Training(
            asked.folder, asked.options, asked.learnt, asked.stopping, held_out=None
        )
        trained = training.run(budget=asked.budget)
    last = trained.history[-1]
    told = Network(trained.arrays).probabilities_of_many(asked.asked.padded())
    told[np.arange(told.shape[1]) >= asked.asked.counts[:, None]] = 0.0
    return {
        "epochs": last.number,
        "best_epoch": last.best_epoch,
        "seconds": last.seconds,
        "cut_off": not training.finished,
        "cases": len(told),
        "probabilities": told.ravel(),
    }
