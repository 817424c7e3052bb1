"""Networks that are trained on some cases and tested on others, kept by all that they depend on."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import torch

from steadyload.learners.features import Array32
from steadyload.learners.inference import Network
from steadyload.learners.options import TrainingOptions
from steadyload.learners.sequences import Sequences
from steadyload.learners.training import VERSION, Training
from steadyload.methods.contract.spec import as_plain
from steadyload.progress import Progress, silent
from steadyload.runs.pool import SinglePart
from steadyload.runs.provenance import key_of
from steadyload.runs.store import Store, locked, parquet


@dataclass(frozen=True)
class NetworkTraining(SinglePart):
    """The training of a network, and what it says of other cases; it learns from what it is given.

    Attributes:
        name: for messages, and of its checkpoint.
        options: of the network.
        learnt: what it learns from.
        stopping: what says which epoch is best.
        asked: what it is tested on.
        folder: of checkpoints.
        budget: seconds of CPU time, over all runs.
    """

    name: str
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
        return f"{self.name}, {self.options.hidden} cells"

    def measure(self) -> Iterator[dict[str, Any]]:
        """Train with one thread, go on from a checkpoint if there is one, and test: one row."""
        torch.set_num_threads(1)
        name = f"{self.name}-{self.options.features}-{self.options.hidden}-{self.key}"
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


class TestedNetwork(NamedTuple):
    """A network that was trained and tested.

    Attributes:
        epochs: of its training.
        best_epoch: of these.
        seconds: of CPU time.
        cut_off: whether the budget of time ended the training.
        probabilities: that steps are unstable, (cases, most items).
    """

    epochs: int
    best_epoch: int
    seconds: float
    cut_off: bool
    probabilities: Array32


def train_and_test(
    trainings: Callable[[], Iterable[NetworkTraining]],
    work: Path,
    *,
    workers: int = 0,
    progress: Progress = silent,
) -> Iterator[TestedNetwork]:
    """Train and test the networks that are missing, and read the others.

    Args:
        trainings: gives those that are wanted, one after the other, since together their sequences
            may take gigabytes; called twice.
        work: folder of what networks say, ``tested``.
        workers: processes that train; 0 trains in this one.
        progress: called with networks done and networks in all.

    Yields:
        Every network, in the order in which they are wanted.

    Raises:
        ResultsError: another run is at work in the folder, or a training ended its process twice.
        LearnerError: the checkpoint of a training is damaged.
    """
    with locked(work):
        store = Store(work / "tested", parquet(_TESTED))
        survey = store.survey(trainings())
        store.complete(
            trainings(), NetworkTraining.measure, workers=workers, progress=progress, survey=survey
        )
    for key in survey.keys:
        (row,) = store.read(key).to_dict("records")
        told = np.asarray(row["probabilities"], dtype=np.float32).reshape(row.pop("cases"), -1)
        yield TestedNetwork(**row | {"probabilities": told})
