"""``steadyload train`` and ``generate``: learned methods, and larger sets for training."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from steadyload.cli.readers import duration, half_share, setting
from steadyload.cli.studies import workers_option
from steadyload.cli.terminal import progress_bar, resumable, say
from steadyload.config import REQUIRED, option, output_option, stated
from steadyload.errors import nearest

_OF_JOB = ("members", "left_out", "budget", "limit", "lists", "start", "leaky")
"""Options that are arguments of a :class:`steadyload.learners.jobs.TrainingJob`."""


@dataclass(frozen=True)
class Train:
    """Options of a training."""

    preset: str = option(
        "quick", "what the options start from; --preset list names all (default: quick)"
    )
    data: tuple[str, ...] = option(
        (), "folder of a labelled set, or benchmark or real for the training part of a shipped "
        "one; may be repeated (default: benchmark)", metavar="SET",
    )  # fmt: skip
    limit: int | None = option(None, "only N cases a scenario of every set", least=1)
    lists: int | None = option(None, "only N item lists of every set", least=1)
    features: str | None = option(None, "plain (the paper's), or support", metavar="KIND")
    network: str | None = option(None, "lstm (the paper's), or attention", metavar="KIND")
    seed: int | None = option(None, "of the first member", least=0)
    options: tuple[tuple[str, str], ...] = option(
        (), "any option of a training, such as hidden=100 or epochs=700; may be repeated",
        names=("--option",), metavar="KEY=VALUE", read=setting,
    )  # fmt: skip
    members: int | None = option(None, "networks that vote", least=1)
    left_out: float | None = option(
        None, "of the item lists, for every member its own: they stop it (0: validation does)",
        metavar="SHARE", read=half_share,
    )  # fmt: skip
    budget: float | None = option(
        None, "over all members, such as 10m", metavar="TIME", read=duration
    )
    search: int | None = option(
        None, "first search learning rate, hidden size and optimiser (Table 4) in N trials", least=1
    )
    start: str = option("", "train on from shipped weights, or a folder", metavar="WEIGHTS")
    question: str = option(
        "within", "whose labels are learnt (default: within)",
        choices="steadyload.layouts.model.question:Question",
    )  # fmt: skip
    device: str = option("cpu", "cpu or cuda (default: cpu)")
    threads: int = option(os.cpu_count() or 1, "default: all cores", least=1)
    leaky: bool = option(
        False, "learn from layouts of held-out item lists, too: to study what a leak is worth"
    )
    output: Path | None = output_option(
        None, "folder of the training; an interrupted one goes on (default: "
        "runs/train/PRESET-SEED)", metavar="DIR",
    )  # fmt: skip
    ship: str | None = option(
        None, "make the weights part of the package (default name: lstm_1, of several members "
        "lstm_e)", bare="",
    )  # fmt: skip

    def run(self) -> None:
        """Train, and print the accuracy of the weights."""
        from steadyload.learners import require_training
        from steadyload.learners.options import training_preset, training_presets

        if self.preset == "list":
            for preset in training_presets().values():
                print(f"{preset.name}: {preset.title}")
            return
        preset = training_preset(self.preset)
        require_training()
        from steadyload.layouts.model.question import Question
        from steadyload.learners.jobs import TrainingJob, search_options, train_weights
        from steadyload.learners.shipping import check_before, method_for, ship
        from steadyload.learners.weights import load_weights

        question = Question(self.question)
        changed = stated(features=self.features, network=self.network, seed=self.seed)
        job = TrainingJob.of(
            preset,
            changed | dict(self.options),
            **{name: getattr(self, name) for name in _OF_JOB},
            data=self.data or None,
            question=question,
        )
        name = method_for(job.members)
        of = "" if question == Question.WITHIN else f"-{question}"
        if self.ship is not None:
            check_before(self.ship or name + of, leaky=job.leaky)
        directory = self.output or Path("runs") / "train" / f"{preset.name}-{job.options.seed}"
        threads, device = self.threads, self.device
        with resumable(directory):
            if self.search:
                with progress_bar("searching") as advance:
                    job = search_options(
                        job, directory / "search", self.search, progress=advance,
                        threads=threads, device=device,
                    )  # fmt: skip
            total, epochs = job.members * job.options.epochs, job.options.epochs
            with progress_bar("reading") as read, progress_bar("training") as advance:
                weights = train_weights(
                    job,
                    directory,
                    loading=read,
                    progress=lambda member, epoch: advance(member * epochs + epoch.number, total),
                    threads=threads,
                    device=device,
                )
        made = load_weights(weights).manifest
        found = made["validation"]["mean"]
        by = ", ".join(f"{k} {100.0 * v:.1f} %" for k, v in found.items() if k != "all")
        print(weights)
        if self.ship is not None:
            print(ship(weights, self.ship or name + of))
        say(f"accuracy on validation: {100.0 * found['all']:.1f} % ({by}); {made['seconds']:.0f} s")
        more = "" if question == Question.WITHIN else f",question={question}"
        say(f"to judge by it: steadyload score FILE -m {name}:weights={weights}{more}")


@dataclass(frozen=True, kw_only=True)
class Generate:
    """Item lists, how they are packed, and the method that labels them."""

    lists: int = option(
        REQUIRED, "item lists of classes 1 and 2 each, and eight times as many of class 3", least=1
    )
    label: str = option(
        "label@reference", "method whose verdicts are the labels (default: label@reference)",
        metavar="SPEC",
    )  # fmt: skip
    seed: int = option(0, "default: 0", least=0)
    heuristics: int = option(
        16, "that pack a list, drawn for each (default: 16 of the 160)", least=1
    )
    most: int = option(24, "layouts kept of a list (default: 24)", least=1)
    scenarios: tuple[str, ...] = option(
        (), "where centres of mass lie; may be repeated (default: S1, S2a and S2b)",
        names=("--scenario",),
    )  # fmt: skip
    output: Path = output_option(
        REQUIRED, "folder of the set; an interrupted run goes on, and --lists may grow",
        metavar="DIR",
    )  # fmt: skip
    workers: int = workers_option(0)

    def run(self) -> None:
        """Pack the item lists, and label the layouts."""
        from steadyload.layouts.model.scenarios import Scenario
        from steadyload.learners import LearnerError
        from steadyload.learners.generation import GenerationOptions, generate_labelled

        known = [str(scenario) for scenario in Scenario]
        for scenario in self.scenarios:
            if scenario not in known:
                raise LearnerError(f"scenario is {scenario!r}; {nearest(scenario, known)}")
        own = ("lists", "label", "seed", "heuristics", "most")
        values = {name: getattr(self, name) for name in own}
        chosen = GenerationOptions(**values, scenarios=tuple(self.scenarios or known))
        with resumable(self.output), progress_bar("item lists") as advance:
            made = generate_labelled(chosen, self.output, workers=self.workers, progress=advance)
        for crash in made["crashed"]:
            say(f"left out: {crash}")
        print(f"{made['cases']} cases of {made['layouts']} layouts -> {self.output}")
