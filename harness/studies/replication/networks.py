"""Networks as in the paper, trained on the folds of a split and tested on the rest."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import pyarrow as pa
import torch

from steadyload.layouts.model.layout import Layout
from steadyload.learners.features import Array32, FeatureKind, features
from steadyload.learners.inference import Network
from steadyload.learners.options import TrainingOptions, options_from, training_preset
from steadyload.learners.ranges import extent_of, trained_ranges
from steadyload.learners.sequences import Sequences
from steadyload.learners.training import VERSION, Training
from steadyload.methods.contract.spec import as_plain
from steadyload.progress import Progress, silent
from steadyload.runs.pool import SinglePart
from steadyload.runs.provenance import key_of
from steadyload.runs.store import CHECKPOINTS, Store, locked, parquet
from steadyload.studies.replication.splits import Fold, steps_safe

PAPER = training_preset("paper-ensemble")
"""Options of the networks of Table 4, and the size and learning rate of each; the first one is
LSTM_1."""

PATIENCE = 100
"""Epochs without a better one before a training ends; the paper trains for all 700."""


def sequences_of(cases: pd.DataFrame, layouts: Sequence[Layout], kind: FeatureKind) -> Sequences:
    """Labelled cases as sequences of features.

    Args:
        cases: of :func:`steadyload.studies.replication.splits.labelled_cases`.
        layouts: of the cases, in their order.
        kind: of the features.
    """
    rows = [features(layout, kind) for layout in layouts]
    extents = [
        extent_of(
            layout.lower, layout.upper, layout.weights, layout.mass_offsets,
            layout.floor.corners, max(layout.pallet.size),
        )
        for layout in layouts
    ]  # fmt: skip
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
        member: its place in the table, from 0.
        seed: of the training.
        changes: of the options.

    Raises:
        LearnerError: a change that is not allowed.
    """
    own = {**PAPER.networks[member], "seed": seed, "patience": PATIENCE}
    return options_from(as_plain(PAPER.options) | own | changes, where="replication")


@dataclass(frozen=True)
class NetworkTraining(SinglePart):
    """The training of a network on a fold of a split, and what it says of the fold's test.

    Attributes:
        fold: kind and number of its fold, for messages and the name of its checkpoint.
        options: of the network.
        learnt: what it learns from.
        stopping: what says which epoch is best.
        asked: what it is tested on.
        folder: of checkpoints.
        budget: seconds of CPU time, over all runs.
    """

    fold: str
    options: TrainingOptions
    learnt: Sequences
    stopping: Sequences
    asked: Sequences
    folder: Path
    budget: float

    @cached_property
    def key(self) -> str:
        """The key of its row: a hash of all that it depends on."""
        plain = as_plain(self.options)
        identity = [plain, self.learnt.fingerprint(), self.stopping.fingerprint()]
        return key_of(
            {
                "training": json.loads(json.dumps(identity, default=str)),
                "tested on": self.asked.fingerprint(),
                "budget": self.budget,
                "version": VERSION,
                "torch": torch.__version__.partition("+")[0],
            }
        )

    def describe(self, part: int) -> str:
        """Description of the training for messages."""
        return f"{self.fold}, {self.options.hidden} cells"

    def measure(self) -> Iterator[dict[str, Any]]:
        """Train with one thread, go on from a checkpoint if there is one, and test: one row."""
        torch.set_num_threads(1)
        name = f"{self.fold}-{self.options.features}-{self.options.hidden}-{self.key}"
        with locked(self.folder / name):
            training = Training(
                self.folder / name, self.options, self.learnt, self.stopping, held_out=None
            )
            trained = training.run(budget=self.budget)
        last = trained.history[-1]
        told = Network(trained.arrays).probabilities_of_many(self.asked.padded())
        told[np.arange(told.shape[1]) >= self.asked.counts[:, None]] = 0.0
        yield {
            "epochs": last.number,
            "best_epoch": last.best_epoch,
            "seconds": last.seconds,
            "cut_off": not training.finished,
            "cases": len(told),
            "probabilities": told.ravel(),
        }


_TESTED = pa.schema(
    [
        pa.field(name, kind, nullable=False)
        for name, kind in {
            "epochs": pa.int32(),
            "best_epoch": pa.int32(),
            "seconds": pa.float64(),
            "cut_off": pa.bool_(),
            "cases": pa.int32(),
            "probabilities": pa.list_(pa.float32()),
        }.items()
    ]
)
"""A network a row; the probabilities of its cases follow each other."""


class FoldNetwork(NamedTuple):
    """A network that was trained and tested on a fold.

    Attributes:
        epochs: of its training.
        best_epoch: of these.
        seconds: of CPU time.
        cut_off: whether the budget of time ended the training.
        probabilities: that steps are unstable, (cases, most items), by case of the fold's test.
    """

    epochs: int
    best_epoch: int
    seconds: float
    cut_off: bool
    probabilities: Array32


def networks_on_folds(
    every: dict[FeatureKind, Sequences],
    wanted: Sequence[tuple[Fold, TrainingOptions]],
    work: Path,
    budget: float,
    *,
    workers: int = 0,
    progress: Progress = silent,
) -> Iterator[FoldNetwork]:
    """Train and test the networks that are missing, and read the others.

    Args:
        every: all cases, by the features of the networks.
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
            all_of = every[options.features].chosen
            learnt, stopping, asked = map(all_of, (fold.train, fold.validation, fold.test))
            name = f"{fold.kind}-{fold.number}"
            yield NetworkTraining(
                name, options, learnt, stopping, asked, work / CHECKPOINTS, budget
            )

    with locked(work):
        store = Store(work / "tested", parquet(_TESTED))
        survey = store.survey(units())
        store.complete(
            units(), NetworkTraining.measure, workers=workers, progress=progress, survey=survey
        )
    for key in survey.keys:
        (row,) = store.read(key).to_dict("records")
        told = np.asarray(row["probabilities"], dtype=np.float32).reshape(row.pop("cases"), -1)
        yield FoldNetwork(**row | {"probabilities": told})
