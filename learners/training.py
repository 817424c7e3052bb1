"""Training of one network: it can be killed at any time, and resumes to the same weights."""

from __future__ import annotations

import copy
import hashlib
import io
import math
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from steadyload.atomic import CHECKSUM_DIGITS, checksum, clear_unfinished, write_atomically
from steadyload.learners import LearnerError
from steadyload.learners.features import symmetry_matrices
from steadyload.learners.network import NETWORKS, LstmNetwork
from steadyload.learners.options import Optimizer, Schedule, TrainingOptions
from steadyload.learners.scoring import accuracies
from steadyload.learners.sequences import HeldOut, Sequences
from steadyload.methods.contract.spec import as_plain
from steadyload.reading import MAX_TABLE_BYTES, content_of
from steadyload.runs.provenance import raised
from steadyload.stored import differing

VERSION = 1
"""Of trainings: raised when the same options, seed and data come to other weights."""

CHECKPOINT = "checkpoint.pt"

_BUCKET = 16
"""Batches within which layouts are sorted by length: less is padded, and order stays random."""

_ZIP = b"PK"
"""How a file of torch begins."""

_EVALUATED = 2048
"""Layouts at once where nothing is learnt."""


@dataclass(frozen=True, slots=True)
class Epoch:
    """Progress of a training.

    Attributes:
        number: epochs done, from 1.
        loss: mean cross entropy of the epoch's steps.
        accuracy: share of the stopping layouts whose score is the label's.
        best: the best accuracy by now, and ``best_epoch`` when it was reached.
        seconds: time of all epochs by now, over all runs, as a budget counts it.
    """

    number: int
    loss: float
    accuracy: float
    best: float
    best_epoch: int
    seconds: float


@dataclass(frozen=True)
class Trained:
    """A trained network: the weights of its best epoch, by name, and all epochs."""

    arrays: Mapping[str, np.ndarray]
    history: tuple[Epoch, ...]

    @property
    def best(self) -> Epoch:
        """The epoch that the weights are of."""
        return self.history[self.history[-1].best_epoch - 1]


class Training:
    """A training in a folder; a checkpoint is written after every epoch.

    On the CPU, with one number of threads, weights depend on options and data alone, however often
    the training was interrupted. On a GPU they do up to rounding.

    Args:
        directory: for the checkpoint; made when it does not exist.
        options: how.
        data: what is learnt from.
        stopping: what says which epoch is best; never learnt from.
        held_out: what must not be learnt from; None is for studies of what a leak is worth.
        start: weights to start from, instead of random ones.
        device: as torch names it.

    Raises:
        LeakError: the training data hold what is held out, or an item list of ``stopping``.
        LearnerError: the folder holds another training, or ``start`` is of another shape.
    """

    def __init__(
        self,
        directory: Path,
        options: TrainingOptions,
        data: Sequences,
        stopping: Sequences,
        *,
        held_out: HeldOut | None,
        start: Mapping[str, np.ndarray] | None = None,
        device: str = "cpu",
    ) -> None:
        if held_out is not None:
            held_out.check(data)
            HeldOut(frozenset(stopping.instances), frozenset()).check(data)
        self.options, self._data, self._stopping = options, data, stopping
        self._device = torch.device(device)
        directory.mkdir(parents=True, exist_ok=True)
        self._path = directory / CHECKPOINT
        torch.manual_seed(options.seed)
        self._network = NETWORKS[options.network](
            data.rows.shape[1], options.hidden, options.layers, options.dropout
        )
        self._network.normalise_as(data.rows)
        if start is not None:
            _take_over(self._network, start)
        self._network.to(self._device)
        self._optimizer = _optimizer(self._network, options)
        self._history: list[Epoch] = []
        self._best = _copied(self._network)
        self._identity = {
            **as_plain(options),
            "data": data.fingerprint(),
            "stopping": stopping.fingerprint(),
            "started": _fingerprint(self._network),
            "torch": torch.__version__.partition("+")[0],
            **raised(VERSION),
        }
        clear_unfinished(directory, CHECKPOINT)
        if self._path.exists():
            self._go_on()

    def run(
        self,
        *,
        budget: float = math.inf,
        progress: Callable[[Epoch], None] = lambda epoch: None,
    ) -> Trained:
        """Train to the last epoch, until nothing gets better, or until time is up.

        Args:
            budget: no epoch is begun that would likely end after this, seconds over all runs: of
                CPU time a thread, which other work on the machine does not lengthen, or of wall
                time beside a GPU.
            progress: called after every epoch.
        """
        if not self.finished:
            self._load()
        while not self.finished:
            spent = self._history[-1].seconds if self._history else 0.0
            if self._history and spent * (1.0 + 1.0 / len(self._history)) > budget:
                break
            start = self._clock()
            loss = self._learn(len(self._history))
            found = self._accuracy()
            self._end(loss, found, spent + self._clock() - start)
            progress(self._history[-1])
        return Trained(
            {name: value.cpu().numpy() for name, value in self._best.items()}, tuple(self._history)
        )

    @property
    def finished(self) -> bool:
        """The last epoch is done, or nothing got better for long."""
        done = len(self._history)
        waited = done - self._history[-1].best_epoch if done else 0
        return done >= self.options.epochs or waited >= self.options.patience

    def _clock(self) -> float:
        if self._device.type == "cpu":
            return time.process_time() / torch.get_num_threads()
        return time.perf_counter()

    def _load(self) -> None:
        """Put all data where they are used."""
        place = self._device
        self._rows = torch.from_numpy(self._data.padded()).to(place)
        self._valid = torch.from_numpy(self._data.valid()).to(place)
        self._safe = torch.from_numpy(self._data.safe).to(place)
        self._lengths = self._data.valid()
        self._turns = torch.from_numpy(symmetry_matrices(self._data.kind)).to(place)
        self._asked = torch.from_numpy(self._stopping.padded()).to(place)

    def _learn(self, epoch: int) -> float:
        """One pass; returns the mean loss of a step."""
        options = self.options
        random = np.random.default_rng(np.random.SeedSequence([options.seed, epoch]))
        torch.manual_seed(int(random.integers(2**31)))  # of dropout
        for group in self._optimizer.param_groups:
            group["lr"] = options.learning_rate * _rate(options, epoch)
        self._network.train()
        total = torch.zeros((), dtype=torch.float64, device=self._device)
        for batch in _batches(self._lengths, options.batch, random):
            steps = int(self._lengths[batch].max())
            turns = torch.from_numpy(random.integers(0, options.symmetries, len(batch)))
            chosen = torch.from_numpy(batch).to(self._device)
            rows = self._rows[chosen, :steps]
            if options.symmetries > 1:
                rows = rows @ self._turns[turns.to(self._device)]
            loss, count = self._loss(rows, self._valid[chosen], self._safe[chosen])
            self._optimizer.zero_grad(set_to_none=True)
            (loss / count).backward()
            nn.utils.clip_grad_norm_(self._network.parameters(), 1.0)
            self._optimizer.step()
            total += loss.detach()
        return float(total) / float(self._lengths.sum())

    def _loss(self, rows: Tensor, valid: Tensor, safe: Tensor) -> tuple[Tensor, Tensor]:
        """Cross entropy summed over the steps that have a label, and how many these are."""
        steps = torch.arange(rows.shape[1], device=self._device)
        counts = steps < valid[:, None]
        labels = (steps >= safe[:, None]).to(rows.dtype)
        logits = self._network(rows)
        losses = nn.functional.binary_cross_entropy_with_logits(logits, labels, reduction="none")
        return (losses * counts).sum(), counts.sum()

    def _accuracy(self) -> float:
        self._network.eval()
        with torch.inference_mode():
            parts = [
                torch.sigmoid(self._network(part)).cpu().numpy()
                for part in self._asked.split(_EVALUATED)
            ]
        return accuracies(np.concatenate(parts), self._stopping)["all"]

    def _end(self, loss: float, accuracy: float, seconds: float) -> None:
        number = len(self._history) + 1
        best, when = (
            (self._history[-1].best, self._history[-1].best_epoch) if self._history else (-1.0, 0)
        )
        if accuracy >= best:  # of equals the last: it has learnt for longer
            best, when, self._best = accuracy, number, _copied(self._network)
        self._history.append(Epoch(number, loss, accuracy, best, when, seconds))
        buffer = io.BytesIO()
        torch.save(
            {
                "identity": self._identity,
                "network": self._network.state_dict(),
                "optimizer": self._optimizer.state_dict(),
                "best": self._best,
                "history": [
                    [e.number, e.loss, e.accuracy, e.best, e.best_epoch, e.seconds]
                    for e in self._history
                ],
            },
            buffer,
        )
        content = buffer.getvalue()
        write_atomically(self._path, checksum(content).encode() + content)

    def _go_on(self) -> None:
        try:
            content = _whole(content_of(self._path, MAX_TABLE_BYTES))
            found = torch.load(io.BytesIO(content), map_location=self._device, weights_only=True)
            identity = dict(found["identity"])
            best, history = found["best"], [Epoch(*values) for values in found["history"]]
        except Exception as error:  # torch raises what the damage leads to
            raise LearnerError(f"{self._path}: is damaged; remove it to start anew") from error
        if identity != self._identity:
            differs = differing(identity, self._identity)
            raise LearnerError(
                f"{self._path}: holds another training ({differs} differ); choose "
                "another folder, or remove it"
            )
        self._network.load_state_dict(found["network"])
        self._optimizer.load_state_dict(found["optimizer"])
        self._best, self._history = best, history


def _whole(content: bytes) -> bytes:
    """A checkpoint without its checksum, which torch's own format has not; earlier ones have none.

    Raises:
        ValueError: it has changed since it was written.
    """
    if content.startswith(_ZIP):
        return content
    if checksum(content[CHECKSUM_DIGITS:]).encode() != content[:CHECKSUM_DIGITS]:
        raise ValueError
    return content[CHECKSUM_DIGITS:]


def _batches(lengths: np.ndarray, size: int, random: np.random.Generator) -> Iterator[np.ndarray]:
    """All layouts once, in random batches of layouts of about one length."""
    order = random.permutation(len(lengths))
    batches = []
    for start in range(0, len(order), size * _BUCKET):
        bucket = order[start : start + size * _BUCKET]
        bucket = bucket[np.argsort(lengths[bucket], kind="stable")]
        batches += [bucket[k : k + size] for k in range(0, len(bucket), size)]
    for k in random.permutation(len(batches)):
        yield batches[k]


def _optimizer(network: LstmNetwork, options: TrainingOptions) -> torch.optim.Optimizer:
    kinds: dict[Optimizer, Any] = {
        Optimizer.ADAM: torch.optim.Adam,
        Optimizer.ADAMW: torch.optim.AdamW,
    }
    return kinds[options.optimizer](
        network.parameters(), lr=options.learning_rate, weight_decay=options.weight_decay
    )


def _rate(options: TrainingOptions, epoch: int) -> float:
    """The learning rate of an epoch in shares of that of the options."""
    if options.schedule is Schedule.CONSTANT:
        return 1.0
    return 0.01 + 0.99 * 0.5 * (1.0 + math.cos(math.pi * epoch / options.epochs))


def _copied(network: LstmNetwork) -> dict[str, Tensor]:
    return copy.deepcopy(network.state_dict())


def _fingerprint(network: LstmNetwork) -> str:
    digest = hashlib.sha256()
    for value in network.state_dict().values():
        digest.update(value.cpu().numpy().tobytes())
    return digest.hexdigest()[:16]


def _take_over(network: LstmNetwork, start: Mapping[str, np.ndarray]) -> None:
    own = {name: tuple(value.shape) for name, value in network.state_dict().items()}
    theirs = {name: value.shape for name, value in start.items()}
    if own != theirs:
        differs = sorted(k for k in {*own, *theirs} if own.get(k) != theirs.get(k))
        raise LearnerError(f"weights to start from are of another shape ({', '.join(differs)})")
    network.load_state_dict({name: torch.from_numpy(value.copy()) for name, value in start.items()})
