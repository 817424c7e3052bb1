"""``steadyload train`` and ``generate``: learned judges, and larger sets to train them on."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import Any

from steadyload.cli.terminal import at_least, duration, progress_bar, resumable, say
from steadyload.methods.spec import nearest

_WORK = Path("runs")


def _share(text: str) -> float:
    """A type for an argument: a share from 0 to 0.5."""
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0.0 <= value <= 0.5:
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: a number from 0 to 0.5")
    return value


def _setting(text: str) -> tuple[str, str]:
    """A type for an argument: ``KEY=VALUE``."""
    key, equals, value = text.partition("=")
    if not (key and equals and value):
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: KEY=VALUE, such as hidden=100")
    return key, value


def add_train(commands: Any) -> None:
    """Add the command to the parser's commands."""
    train = commands.add_parser(
        "train", help="train a learned judge (lstm_1, lstm_e) on labelled layouts"
    )
    train.add_argument(
        "--preset", default="quick", metavar="NAME",
        help="what the options start from; --preset list names all (default: quick)",
    )  # fmt: skip
    train.add_argument(
        "--data", action="append", metavar="SET",
        help="folder of a labelled set, or the word benchmark for the training part of the "
        "shipped one; may be repeated (default: benchmark)",
    )  # fmt: skip
    train.add_argument(
        "--limit", type=at_least(1), metavar="N", help="only N cases a scenario of every set"
    )
    train.add_argument(
        "--lists", type=at_least(1), metavar="N", help="only N item lists of every set"
    )
    train.add_argument("--features", metavar="KIND", help="plain (the paper's), or support")
    train.add_argument("--network", metavar="KIND", help="lstm (the paper's), or attention")
    train.add_argument("--seed", type=at_least(0), help="of the first member")
    train.add_argument(
        "--option", action="append", type=_setting, default=[], metavar="KEY=VALUE",
        help="any option of a training, such as hidden=100 or epochs=700; may be repeated",
    )  # fmt: skip
    train.add_argument("--members", type=at_least(1), metavar="N", help="networks that vote")
    train.add_argument(
        "--left-out", type=_share, metavar="SHARE",
        help="of the item lists, for every member its own: they stop it (0: validation does)",
    )  # fmt: skip
    train.add_argument(
        "--budget", type=duration, metavar="TIME", help="over all members, such as 10m"
    )
    train.add_argument(
        "--search", type=at_least(1), metavar="N",
        help="first search learning rate, hidden size and optimiser (Table 4) in N trials",
    )  # fmt: skip
    train.add_argument(
        "--start", default="", metavar="WEIGHTS", help="train on from shipped weights, or a folder"
    )
    train.add_argument("--device", default="cpu", help="cpu or cuda (default: cpu)")
    train.add_argument(
        "--threads", type=at_least(1), default=os.cpu_count() or 1, help="default: all cores"
    )
    train.add_argument(
        "--leaky", action="store_true",
        help="learn from layouts of held-out item lists, too: to study what a leak is worth",
    )  # fmt: skip
    train.add_argument(
        "--output", "-o", type=Path, metavar="DIR",
        help="folder of the training; an interrupted one goes on (default: runs/train/PRESET-SEED)",
    )  # fmt: skip
    train.add_argument(
        "--ship", nargs="?", const="", metavar="NAME",
        help="make the weights part of the package (default name: lstm_1, of several members "
        "lstm_e)",
    )  # fmt: skip
    train.set_defaults(run=_train)


def _train(options: argparse.Namespace) -> None:
    from steadyload.learners import require_training
    from steadyload.learners.options import training_preset, training_presets

    if options.preset == "list":
        for preset in training_presets().values():
            print(f"{preset.name}: {preset.title}")
        return
    preset = training_preset(options.preset)
    require_training()
    from steadyload.learners.jobs import TrainingJob, search_options, train_weights
    from steadyload.learners.shipping import check_before, ship
    from steadyload.learners.weights import load_weights

    named = {key: getattr(options, key) for key in ("features", "network", "seed")}
    job = TrainingJob.of(
        preset,
        {key: value for key, value in named.items() if value is not None} | dict(options.option),
        members=options.members,
        left_out=options.left_out,
        budget=options.budget,
        data=tuple(options.data) if options.data else None,
        limit=options.limit,
        lists=options.lists,
        start=options.start,
        leaky=options.leaky,
    )
    name = "lstm_1" if job.members == 1 else "lstm_e"
    if options.ship is not None:
        check_before(options.ship or name, leaky=job.leaky)
    directory = options.output or _WORK / "train" / f"{preset.name}-{job.options.seed}"
    where = {"threads": options.threads, "device": options.device}
    with resumable(directory):
        if options.search:
            with progress_bar("searching") as advance:
                job = search_options(
                    job, directory / "search", options.search, progress=advance, **where
                )
        total = job.members * job.options.epochs
        with progress_bar("reading") as read, progress_bar("training") as advance:
            weights = train_weights(
                job,
                directory,
                loading=read,
                progress=lambda member, epoch: advance(
                    member * job.options.epochs + epoch.number, total
                ),
                **where,
            )
    made = load_weights(weights).manifest
    found = made["validation"]["mean"]
    of = ", ".join(f"{k} {100.0 * v:.1f} %" for k, v in found.items() if k != "all")
    print(weights)
    if options.ship is not None:
        print(ship(weights, options.ship or name))
    say(f"accuracy on validation: {100.0 * found['all']:.1f} % ({of}); {made['seconds']:.0f} s")
    say(f"to judge by it: steadyload score FILE -m {name}:weights={weights}")


def add_generate(commands: Any) -> None:
    """Add the command to the parser's commands."""
    generate = commands.add_parser(
        "generate", help="pack and label fresh item lists: a larger set to train on"
    )
    generate.add_argument(
        "--lists",
        type=at_least(1),
        required=True,
        metavar="N",
        help="item lists of classes 1 and 2 each, and eight times as many of class 3",
    )
    generate.add_argument(
        "--label", default="label@reference", metavar="SPEC",
        help="method whose verdicts are the labels (default: label@reference)",
    )  # fmt: skip
    generate.add_argument("--seed", type=at_least(0), default=0, help="default: 0")
    generate.add_argument(
        "--heuristics", type=at_least(1), default=16, metavar="N",
        help="that pack a list, drawn for each (default: 16 of the 160)",
    )  # fmt: skip
    generate.add_argument(
        "--most", type=at_least(1), default=24, metavar="N",
        help="layouts kept of a list (default: 24)",
    )  # fmt: skip
    generate.add_argument(
        "--scenario", action="append", metavar="NAME",
        help="where centres of mass lie; may be repeated (default: S1, S2a and S2b)",
    )  # fmt: skip
    generate.add_argument(
        "--output", "-o", type=Path, required=True, metavar="DIR",
        help="folder of the set; an interrupted run goes on, and --lists may grow",
    )  # fmt: skip
    generate.add_argument(
        "--workers", "-j", type=at_least(1), default=os.cpu_count() or 1, help="default: all cores"
    )
    generate.set_defaults(run=_generate)


def _generate(options: argparse.Namespace) -> None:
    from steadyload.layouts.scenarios import Scenario
    from steadyload.learners import LearnerError
    from steadyload.learners.generation import GenerationOptions, generate_labelled

    known = [str(scenario) for scenario in Scenario]
    for scenario in options.scenario or ():
        if scenario not in known:
            raise LearnerError(f"scenario is {scenario!r}; {nearest(scenario, known)}")
    chosen = GenerationOptions(
        lists=options.lists,
        label=options.label,
        seed=options.seed,
        heuristics=options.heuristics,
        most=options.most,
        scenarios=tuple(options.scenario or known),
    )
    with resumable(options.output), progress_bar("item lists") as advance:
        made = generate_labelled(chosen, options.output, workers=options.workers, progress=advance)
    for crash in made["crashed"]:
        say(f"left out: {crash}")
    print(f"{made['cases']} cases of {made['layouts']} layouts -> {options.output}")
