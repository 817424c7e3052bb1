"""The sets and trainings of a plan, made where they are missing; each has a folder of its own.

A folder's name holds a hash of everything that it depends on: after a change of the plan unchanged
trainings are found again, and other folders stay. The loop of :mod:`steadyload.runs.store` does not
apply: results are folders, not shards, and later trainings start from the weights of earlier ones.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.layouts.benchmark.tables import BenchmarkError, read_tables
from steadyload.learners import LearnerError
from steadyload.learners.generation import generate_labelled
from steadyload.learners.jobs import BENCHMARK, TrainingJob, train_weights
from steadyload.learners.options import training_preset
from steadyload.learners.plans.plan import Plan, PlannedTraining, Section
from steadyload.learners.weights import MANIFEST
from steadyload.methods.contract.spec import as_plain
from steadyload.progress import Progress, silent
from steadyload.runs.pool import SinglePart, run_units
from steadyload.runs.store import CHECKPOINTS


@dataclass(frozen=True, slots=True)
class Run(SinglePart):
    """One seed of a training.

    Attributes:
        training: the planned training.
        seed: of its options.
        folder: holds checkpoints, and ``weights`` in the end. It is among the checkpoints of the
            study where the weights are no method of it: what they say is kept, they need not be.
        data: names of its sets as a :class:`TrainingJob` has them.
        start: the run whose weights it starts from; None for none.
        judges: its weights are a method of the study.
    """

    training: PlannedTraining
    seed: int
    folder: Path
    data: tuple[str, ...]
    start: Run | None
    judges: bool

    @property
    def title(self) -> str:
        """Title of the training, and the seed."""
        return f"{self.training.title}, seed {self.seed}"

    @property
    def weights(self) -> Path:
        """The folder of its weights."""
        return self.folder / "weights"

    @property
    def finished(self) -> bool:
        """True if its weights exist."""
        return (self.weights / MANIFEST).exists()

    @property
    def depth(self) -> int:
        """Number of trainings that it continues one after the other."""
        return 1 + self.start.depth if self.start else 0

    def describe(self, part: int) -> str:
        """Description of the run for messages."""
        return f"training {self.training.name!r}, seed {self.seed}"

    def job(self) -> TrainingJob:
        """The training job; the weights that it starts from must exist."""
        planned = self.training
        return TrainingJob.of(
            training_preset(planned.preset),
            {**planned.options, "seed": self.seed},
            **planned.of_job(),
            data=self.data,
            start=str(self.start.weights) if self.start else "",
        )


@dataclass(frozen=True)
class Workshop:
    """The folder in which a plan's sets and trainings are.

    Args:
        plan: of them.
        folder: holds ``sets``, ``trainings`` whose weights are methods, and the others' weights.
    """

    plan: Plan
    folder: Path

    def set_folder(self, name: str) -> Path:
        """The folder of a generated set."""
        identity = self.plan.sets[name].identity()
        return self.folder / "sets" / f"{name}-{_digest(identity)}"

    def runs(self, name: str) -> list[Run]:
        """All seeds of a training."""
        return [self._run(name, seed) for seed in self.plan.trainings[name].seeds]

    def make(
        self,
        sections: Collection[Section],
        *,
        workers: int,
        known: Callable[[Run], bool] = lambda run: False,
        made: Callable[[Run], None] = lambda run: None,
        generating: Progress = silent,
        training: Progress = silent,
    ) -> None:
        """Make the missing sets and trainings of sections; interrupted ones are resumed.

        Args:
            sections: of the plan.
            known: tells the runs whose weights are needed no more, unless they are a method or
                another one starts from them.
            made: called with every run as soon as it is trained, so that what its weights say can
                be kept before the others are.
            workers: processes beside this one; each trains with one thread.
            generating: called with item lists done and item lists in all, for every set.
            training: called with trainings done and trainings in all.

        Raises:
            LearnerError: a training is not allowed, or one ended its process twice.
            as :func:`steadyload.learners.generation.generate_labelled` and
            :func:`steadyload.learners.jobs.train_weights`.
        """
        needed = self.plan.needed(sections)
        for name in dict.fromkeys(n for t in needed for n in t.data if n != BENCHMARK):
            if self._lists(name) != self.plan.sets[name].lists:
                generate_labelled(
                    self.plan.sets[name],
                    self.set_folder(name),
                    workers=workers,
                    progress=generating,
                )
        runs = [run for planned in needed for run in self.runs(planned.name)]
        missing: dict[Path, Run] = {}
        for run in runs:
            chain = run if run.judges or not known(run) else None
            while chain and not chain.finished:
                missing[chain.folder], chain = chain, chain.start
        done = len(runs) - len(missing)
        training(done, len(runs))
        waves: dict[int, list[Run]] = {}
        for run in missing.values():
            waves.setdefault(run.depth, []).append(run)
        for _, wave in sorted(waves.items()):
            for run, (reason,) in run_units(
                _train, wave, workers=workers, crashed=lambda run, part, reason: reason
            ):
                if reason:
                    raise LearnerError(f"{run.describe(0)}: {reason}")
                made(run)
                done += 1
                training(done, len(runs))

    def _run(self, name: str, seed: int) -> Run:
        planned = self.plan.trainings[name]
        judges = name in self.plan.judging() and seed == planned.seeds[0]
        start = self._run(planned.start, seed) if planned.start else None
        identity = {
            "options": as_plain(training_preset(planned.preset).options) | dict(planned.options),
            **planned.of_job(),
            "data": [self._data_identity(each) for each in planned.data],
            "start": start.folder.name if start else "",
        }
        return Run(
            training=planned,
            seed=seed,
            folder=self.folder
            / ("trainings" if judges else CHECKPOINTS)
            / f"{name}-{seed}-{_digest(identity)}",
            data=tuple(
                each if each == BENCHMARK else str(self.set_folder(each)) for each in planned.data
            ),
            start=start,
            judges=judges,
        )

    def _data_identity(self, name: str) -> Any:
        if name == BENCHMARK:
            return name
        return {**self.plan.sets[name].identity(), "lists": self.plan.sets[name].lists}

    def _lists(self, name: str) -> int | None:
        """Number of item lists of a complete set; None without one."""
        try:
            return int(read_tables(self.set_folder(name))[3]["lists"])
        except BenchmarkError:
            return None


def _train(run: Run) -> Iterator[str]:
    """Train one seed; the result is empty."""
    train_weights(run.job(), run.folder, threads=1)
    yield ""


def _digest(identity: Mapping[str, Any]) -> str:
    text = json.dumps(identity, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:10]
