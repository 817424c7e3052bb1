"""``steadyload recommend``: which method to use, by what was measured."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import Any

from steadyload.cli.terminal import print_table, say

_MILLISECONDS = {"us": 1e-3, "ms": 1.0, "s": 1e3}


def add_recommend(commands: Any) -> None:
    """Add the command to the parser's commands."""
    recommend = commands.add_parser(
        "recommend", help="name the method to use for a time a layout, or for an accuracy"
    )
    recommend.add_argument(
        "--budget", type=milliseconds, metavar="TIME",
        help="CPU time a layout, such as 5ms: the most accurate method within it",
    )  # fmt: skip
    recommend.add_argument(
        "--accuracy", type=share, metavar="SHARE",
        help="such as 0.95 or 95%%: the cheapest method that is right as often",
    )  # fmt: skip
    recommend.add_argument(
        "--engine", metavar="NAME", help="only methods on this engine, and those that need none"
    )
    recommend.add_argument(
        "--from", dest="run_folder", type=Path, metavar="RUN",
        help="run folder of a study on a labelled set (default: what comes with the package)",
    )  # fmt: skip
    recommend.add_argument(
        "--write", action="store_true", help="make the run what comes with the package"
    )
    recommend.set_defaults(run=_recommend)


def milliseconds(text: str) -> float:
    """A type for an argument: milliseconds, from ``5ms``, ``0.01s`` or ``300us``."""
    match = re.fullmatch(r"(\d+(?:\.\d+)?|\.\d+)(us|ms|s)", text)
    if match is None or not float(match[1]):
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: a time such as 5ms, 0.01s or 300us")
    return float(match[1]) * _MILLISECONDS[match[2]]


def share(text: str) -> float:
    """A type for an argument: a share, from ``0.95`` or ``95%``."""
    match = re.fullmatch(r"(\d+(?:\.\d+)?|\.\d+)(%?)", text)
    value = float(match[1]) * (0.01 if match[2] else 1.0) if match else 0.0
    if not 0.0 < value <= 1.0:
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: above 0, to 1, or per cent")
    return value


def _recommend(options: argparse.Namespace) -> None:
    from steadyload.studies.table5.front import (
        FrontError,
        best,
        load_front,
        measured_in,
        recommend,
        told,
    )
    from steadyload.studies.table5.front import write_front as write

    if options.write and options.run_folder is None:
        raise FrontError("--write needs --from RUN: the run to be kept")
    front = measured_in(options.run_folder) if options.run_folder else load_front()
    if options.write:
        print(write(front))
        return
    chosen = recommend(
        front, budget=options.budget, accuracy=options.accuracy, engine=options.engine
    )
    print(told(chosen) + "\n")
    print_table(
        ("", "method", "accuracy %", "95 % interval", "CPU ms"),
        [
            (
                "->" if entry == chosen else "",
                entry.method,
                f"{100 * entry.accuracy.value:.1f}",
                f"{100 * entry.accuracy.low:.1f} to {100 * entry.accuracy.high:.1f}",
                f"{entry.cpu.value:.3g}",
            )
            for entry in best(front, options.engine)
        ],
    )
    if options.accuracy is not None and chosen.accuracy.low < options.accuracy:
        say(f"The interval of {chosen.method} reaches below {100 * options.accuracy:g} %.")
    about = [front.about["measured on"]]
    if "timed on" in front.about:
        about.append(f"timed on {front.about['timed on']}")
    print("\n" + "; ".join([*about, front.about["machine"]]))
