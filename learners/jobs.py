"""From data to weights in a folder: the members of a training, one after the other.

Not the loop of :mod:`steadyload.runs.store`: a member goes on in the middle, from its checkpoint.
"""

from __future__ import annotations

import dataclasses
import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch

from steadyload.layouts.model.question import Question
from steadyload.learners import LearnerError
from steadyload.learners.features import names
from steadyload.learners.inference import Network
from steadyload.learners.material import Material, load_material, split_of
from steadyload.learners.options import (
    TrainingOptions,
    TrainingPreset,
    options_from,
    training_preset,
)
from steadyload.learners.scoring import THRESHOLD, accuracies
from steadyload.learners.search import search_hyperparameters
from steadyload.learners.sequences import BENCHMARK, Sequences, repeated
from steadyload.learners.training import VERSION, Epoch, Trained, Training
from steadyload.learners.weights import (
    WEIGHTS,
    load_arrays,
    load_weights,
    save_weights,
)
from steadyload.methods.contract.spec import as_plain
from steadyload.progress import Progress, silent
from steadyload.runs.provenance import provenance
from steadyload.runs.store import locked
from steadyload.stored import store_list, stored_list

_MADE_BY = "made_by.json"

Report = Callable[[int, Epoch], None]


@dataclass(frozen=True)
class TrainingJob:
    """Training job: the networks to train, and their data.

    Args:
        options: of every member; the seeds of the members are drawn from that of the options.
        members: networks.
        left_out: see :class:`steadyload.learners.options.TrainingPreset`.
        budget: seconds over all members, see :meth:`.Training.run`.
        data: names and folders of labelled sets, see
            :func:`steadyload.learners.sequences.load_sequences`; of each its training part is
            taken.
        limit: only so many cases a scenario of every set, those of the first ranks.
        lists: only the cases of so many item lists of every set.
        start: weights to train on from, member by member, and again from the first where they have
            fewer; features, network and sizes are theirs. Empty: none.
        leaky: learn from the item lists of validation and test, too, though not from their cases;
            for a study of what that is worth, never shipped.
        question: whose labels are learnt.
        preset: that it began with; where its networks have options of their own, these hold.
    """

    options: TrainingOptions
    members: int = 1
    left_out: float = 0.0
    budget: float = 600.0
    data: tuple[str, ...] = (BENCHMARK,)
    limit: int | None = None
    lists: int | None = None
    start: str = ""
    leaky: bool = False
    question: Question = Question.WITHIN
    preset: str = "quick"

    @classmethod
    def of(cls, preset: TrainingPreset, changes: Mapping[str, Any], **others: Any) -> TrainingJob:
        """The job of a preset, with some options and arguments changed.

        Raises:
            LearnerError: an option or argument that cannot be.
        """
        for name in set(changes) & set().union(*preset.networks):
            raise LearnerError(f"{name} is given; preset {preset.name} has one for every network")
        values = as_plain(preset.options) | dict(changes)
        if others.get("start"):
            made = load_weights(others["start"]).manifest["members"][0]["options"]
            theirs = {key: made[key] for key in ("features", "network", "hidden", "layers")}
            for key, value in theirs.items():
                if str(changes.get(key, value)) != str(value):
                    raise LearnerError(
                        f"{key} is {changes[key]}; weights {others['start']!r}, which it starts "
                        f"from, have {value}"
                    )
            values |= theirs
        options = options_from(values, where=f"preset {preset.name}")
        given = {key: value for key, value in others.items() if value is not None}
        own = {key: getattr(preset, key) for key in ("members", "left_out", "budget")}
        return cls(options, **own | given, preset=preset.name if preset.networks else "quick")

    def __post_init__(self) -> None:
        if self.members < 1:
            raise LearnerError(f"members is {self.members}; allowed: 1 or more")
        if self.members > len(self.networks) > 0:
            raise LearnerError(
                f"members is {self.members}; allowed: 1 to {len(self.networks)}, as many as preset "
                f"{self.preset} has networks"
            )
        if not 0.0 <= self.left_out <= 0.5:
            raise LearnerError(f"left_out is {self.left_out:g}; allowed: 0 to 0.5")
        if not self.data:
            raise LearnerError("no data are named; allowed: one set or more")

    @property
    def networks(self) -> tuple[Mapping[str, Any], ...]:
        """See :attr:`.TrainingPreset.networks`."""
        return training_preset(self.preset).networks

    def member_options(self, number: int) -> TrainingOptions:
        """Options of a member: its own, and a seed of its own; the first keeps that of the job."""
        own = self.networks[number] if self.networks else {}
        if number:
            sequence = np.random.SeedSequence([self.options.seed, number])
            own = {**own, "seed": int(sequence.generate_state(1)[0])}
        return dataclasses.replace(self.options, **own)

    def material(self, loading: Progress = silent) -> Material:
        """Its data; see :func:`steadyload.learners.material.load_material`."""
        return load_material(
            self.options.features, self.data, limit=self.limit, lists=self.lists,
            leaky=self.leaky, question=self.question, loading=loading,
        )  # fmt: skip

    @property
    def command(self) -> str:
        """Command that trains the same weights again, but for the time that a budget cuts off."""
        words = ["steadyload", "train", "--preset", self.preset]
        own = set().union(*self.networks)
        for field, value in as_plain(self.options).items():
            words += [] if field in own else ["--option", f"{field}={value}"]
        words += ["--members", str(self.members), "--left-out", f"{self.left_out:g}"]
        words += ["--budget", f"{self.budget:.10g}"]
        for name in self.data:
            words += ["--data", name]
        words += ["--limit", str(self.limit)] if self.limit else []
        words += ["--lists", str(self.lists)] if self.lists else []
        words += ["--start", self.start] if self.start else []
        words += ["--leaky"] if self.leaky else []
        words += ["--question", self.question] if self.question != Question.WITHIN else []
        return shlex.join(words)


def train_weights(
    job: TrainingJob,
    directory: Path,
    *,
    threads: int = 1,
    device: str = "cpu",
    loading: Progress = silent,
    progress: Report = lambda member, epoch: None,
) -> Path:
    """Train all members and write their weights; an interrupted run is resumed.

    Args:
        job: what.
        directory: holds a checkpoint a member, and ``weights`` in the end.
        threads: of torch; weights may differ by rounding from one number to another.
        device: as torch names it.
        loading: called with layouts read and layouts in all, for every set.
        progress: called with the member, counted from 0, after each of its epochs.

    Returns:
        The folder of the weights.

    Raises:
        LeakError: what is held out is in the data.
        LearnerError: the folder holds another training, no such device, or no data are left.
        BenchmarkError: a set that is none.
        ResultsError: another run is at work in the folder.
    """
    _check_device(device)
    torch.set_num_threads(threads)
    # Of the code that trains, not of what it has become when it is done.
    own = provenance() | {"training": VERSION, "torch": torch.__version__}
    with locked(directory):
        material = job.material(loading)
        data, validation = material.data, material.validation
        starts = _starts(job.start)
        began = dict(load_weights(job.start).manifest) if job.start else {}
        members, networks, rest = [], [], job.budget
        for number in range(job.members):
            learnt, stopping, lists = split_of(
                material, number, left_out=job.left_out, seed=job.options.seed
            )
            training = Training(
                directory / f"member_{number}",
                job.member_options(number),
                repeated(learnt, job.options.least_share),
                stopping,
                held_out=None if job.leaky else material.held_out,
                start=starts[number % len(starts)],
                device=device,
            )
            if not training.finished:
                _note(directory, own)
            trained = training.run(
                budget=rest / (job.members - number),
                progress=lambda epoch, number=number: progress(number, epoch),  # type: ignore[misc]
            )
            rest = max(rest - trained.history[-1].seconds, 0.0)
            members.append(_member(training.options, trained, learnt, lists))
            networks.append(trained.arrays)
        made_by, *gone_on_by = _noted(directory) or [own]
        manifest = {
            "features": str(job.options.features),
            "feature_names": list(names(job.options.features)),
            "network": str(job.options.network),
            "hidden": job.options.hidden,
            "command": job.command,
            "question": str(job.question),
            "threshold": THRESHOLD,
            "ranges": data.ranges,
            "data": material.sources,
            "cases": len(data),
            "item_lists": len(set(data.instances)),
            "leaky": job.leaky or began.get("leaky", False),
            "members": members,
            "validation": _validated(networks, validation),
            "seconds": round(sum(member["seconds"] for member in members), 1),
            "device": device,
            "made_by": made_by,
        }
        if gone_on_by:
            manifest["gone_on_by"] = gone_on_by
        if job.start:
            keys = ("command", "made_by", "gone_on_by", "started_from")
            manifest["started_from"] = {"digest": load_weights(job.start).digest} | {
                key: began[key] for key in keys if key in began
            }
        return save_weights(directory / WEIGHTS, networks, manifest)


def search_options(
    job: TrainingJob,
    directory: Path,
    trials: int,
    *,
    threads: int = 1,
    device: str = "cpu",
    progress: Progress = silent,
) -> TrainingJob:
    """The job with the learning rate, hidden size and optimiser that a search finds best.

    Every trial is one member's training, stopped as the job's first member is.

    Args:
        job: what is trained in the end; half its budget goes to the search, counted anew in every
            run, and half is left to the training.
        directory: of the search.
        trials: in all.
        threads: see :func:`train_weights`.
        device: likewise.
        progress: called with trials done and trials in all.

    Raises:
        LearnerError: the job starts from weights, or from a preset of networks of different
            sizes: a search cannot choose these.
        UserError: as :func:`steadyload.learners.search.search_hyperparameters` and
            :func:`train_weights`.
    """
    if job.start:
        raise LearnerError(
            f"a search chooses the hidden size, and weights {job.start!r} have theirs; start from "
            "none, or search nothing"
        )
    if job.networks:
        raise LearnerError(
            f"a search chooses the hidden size, and preset {job.preset} has one for every network; "
            "start from another preset"
        )
    _check_device(device)
    torch.set_num_threads(threads)
    with locked(directory):
        material = job.material()
        learnt, stopping, _ = split_of(material, 0, left_out=job.left_out, seed=job.options.seed)
        found = search_hyperparameters(
            job.options,
            directory,
            repeated(learnt, job.options.least_share),
            stopping,
            held_out=None if job.leaky else material.held_out,
            trials=trials,
            budget=0.5 * job.budget,
            seed=job.options.seed,
            device=device,
            progress=progress,
        )
    return dataclasses.replace(job, options=found[0].options, budget=0.5 * job.budget)


def _check_device(device: str) -> None:
    kind = device.partition(":")[0]
    if kind not in ("cpu", "cuda"):
        raise LearnerError(f"device is {device!r}; allowed: cpu, cuda")
    if kind == "cuda" and not torch.cuda.is_available():
        raise LearnerError(f"device is {device!r}; torch finds no GPU here; allowed: cpu")


def _starts(where: str) -> list[Mapping[str, np.ndarray] | None]:
    """Weights that the members start from, in turns; None for random weights."""
    if not where:
        return [None]
    return [load_arrays(where, k) for k in range(len(load_weights(where).networks))]


def _noted(directory: Path) -> list[dict[str, Any]]:
    """The provenances of all runs that trained in a folder, the first one first."""
    remedy = "remove it, and which earlier runs trained is unknown"
    return stored_list(directory / _MADE_BY, "runs", remedy)


def _note(directory: Path, own: dict[str, Any]) -> None:
    noted = _noted(directory)
    if own not in noted:
        store_list(directory / _MADE_BY, "runs", [*noted, own])


def _member(
    options: TrainingOptions, trained: Trained, learnt: Sequences, lists: list[str]
) -> dict[str, Any]:
    best, last = trained.best, trained.history[-1]
    return {
        "options": as_plain(options),
        "cases": len(learnt),
        "left_out": lists if len(lists) <= 64 else len(lists),
        "epochs": last.number,
        "best_epoch": best.number,
        "stopping_accuracy": round(best.accuracy, 5),
        "loss": round(best.loss, 6),
        "seconds": round(last.seconds, 1),
    }


def _validated(networks: list[Any], validation: Sequences) -> dict[str, Any]:
    """Accuracy of every member, and of their mean, on the validation part."""
    rows = validation.padded()
    found = [Network(arrays).probabilities_of_many(rows) for arrays in networks]
    return {
        "members": [_rounded(accuracies(p, validation)) for p in found],
        "mean": _rounded(accuracies(np.mean(found, axis=0), validation)),
    }


def _rounded(values: Mapping[str, float]) -> dict[str, float]:
    return {name: round(value, 5) for name, value in values.items()}
