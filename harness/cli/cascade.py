"""``steadyload cascade``: fit what the stages of a cascade hold sure, and write its page."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from steadyload.cli.terminal import at_least, print_table, progress_bar, resumable


def add_cascade(commands: Any) -> None:
    """Add the command to the parser's commands."""
    cascade = commands.add_parser(
        "cascade", help="fit the thresholds of cascades, or write the page of one"
    )
    actions = cascade.add_subparsers(required=True, metavar="ACTION")
    _add_fit(actions)
    _add_page(actions)


def _add_fit(actions: Any) -> None:
    fit = actions.add_parser(
        "fit", help="find what each stage may hold sure, at the least cost within an error budget"
    )
    fit.add_argument(
        "--engine", action="append", metavar="NAME",
        help="engine of the last stage; may be repeated (default: mujoco)",
    )  # fmt: skip
    fit.add_argument(
        "--error-budget", type=float, nargs="+", metavar="POINTS",
        help="accuracy that the stages before the last may cost, in percentage points; of several "
        "the first is the default (default: 0.5 1 2 5)",
    )  # fmt: skip
    fit.add_argument(
        "--confidence", type=float, metavar="C",
        help="that lost accuracy keeps within the budget (default: 0.5)",
    )  # fmt: skip
    fit.add_argument(
        "--candidate", action="append", metavar="SPEC",
        help="a method that may become a stage, in order; may be repeated (default: fbs, "
        "equilibrium, lstm_1, lstm_e, equilibrium:time=0.3, the last one with scope=local)",
    )  # fmt: skip
    fit.add_argument(
        "--benchmark", metavar="SET",
        help="labelled set whose validation part is fitted on (default: the shipped one; for a 2-D "
        "engine the planar one)",
    )  # fmt: skip
    fit.add_argument(
        "--data", action="append", metavar="DIR", default=[],
        help="folder of a further labelled set, such as one of steadyload generate, that no judge "
        "has learnt from; may be repeated",
    )  # fmt: skip
    fit.add_argument(
        "--limit", type=at_least(2), metavar="N", help="only the first N cases a scenario"
    )
    fit.add_argument(
        "--output", "-o", type=Path, metavar="FILE",
        help="file of thresholds (default: the one of the package)",
    )  # fmt: skip
    fit.set_defaults(run=_fit)


def _fit(options: argparse.Namespace) -> None:
    from steadyload.methods.thresholds import FILE, write_thresholds
    from steadyload.runs.provenance import provenance
    from steadyload.tuning.cascade.fitted import (
        BUDGETS,
        CANDIDATES,
        CONFIDENCE,
        FitOptions,
        check_remakable,
        fit_cascade,
    )

    if options.output is None:  # said before minutes are spent
        check_remakable(provenance())
    asked = [
        FitOptions(
            engine,
            tuple(options.error_budget or BUDGETS),
            CONFIDENCE if options.confidence is None else options.confidence,
            tuple(options.candidate or CANDIDATES),
            options.benchmark,
            tuple(options.data),
            options.limit,
        )
        for engine in options.engine or ["mujoco"]
    ]
    fitted = {}
    for one in asked:
        with progress_bar(f"asking for {one.engine}") as advance:
            fitted[one.engine] = fit_cascade(one, progress=advance)
    for engine, thresholds in fitted.items():
        file = write_thresholds(engine, thresholds, options.output or FILE)
        print_table(
            ("cascade", "budget", "stages", "lost", "of", "left out", "accuracy %", "alone %",
             "ms", "alone"),
            [
                (
                    f"cascade@{engine}",
                    f"{budget:g}",
                    ", ".join(stage.method for stage in ladder.stages) or "-",
                    str(ladder.found["lost"]),
                    str(ladder.found["cases"]),
                    "{lost} of {cases}".format(**ladder.found["left_out"]),
                    f"{100 * ladder.found['accuracy']:.2f}",
                    f"{100 * ladder.found['alone']:.2f}",
                    f"{ladder.found['milliseconds']:.2f}",
                    f"{ladder.found['milliseconds_alone']:.2f}",
                )
                for budget, ladder in thresholds.ladders.items()
            ],
        )  # fmt: skip
    print(file)


def _add_page(actions: Any) -> None:
    page = actions.add_parser(
        "page", help="hold a cascade against its stages and simulations on test, and write its page"
    )
    page.add_argument("--engine", default="mujoco", metavar="NAME", help="default: mujoco")
    page.add_argument(
        "--method", "-m", action="append", metavar="SPEC", default=[],
        help="a further method on the page; may be repeated",
    )  # fmt: skip
    page.add_argument(
        "--thresholds", type=Path, metavar="FILE",
        help="file of thresholds (default: the one of the package)",
    )  # fmt: skip
    page.add_argument(
        "--judge-on", metavar="PART", default="test",
        help="part of the labelled set, such as validation (default: test)",
    )  # fmt: skip
    page.add_argument(
        "--limit", type=at_least(2), default=300, metavar="N",
        help="cases a scenario (default: 300)",
    )  # fmt: skip
    page.add_argument(
        "--work", type=Path, metavar="DIR", default=Path("runs/cascade"),
        help="folder of what is judged; an interrupted run goes on (default: runs/cascade)",
    )  # fmt: skip
    page.add_argument(
        "--output", "-o", type=Path, metavar="DIR", help="folder of the page (default: --work)"
    )
    page.set_defaults(run=_page)


def _page(options: argparse.Namespace) -> None:
    from steadyload.reports.page import write_page
    from steadyload.runs.provenance import provenance_lines
    from steadyload.studies.cascade.page import cascade_page
    from steadyload.studies.cascade.study import cascade_study

    with resumable(options.work), progress_bar("judging") as advance:
        record = cascade_study(
            options.engine,
            options.work,
            others=options.method,
            part=options.judge_on,
            thresholds=str(options.thresholds or ""),
            limit=options.limit,
            progress=advance,
        )
    page = cascade_page(record, provenance_lines())
    print(write_page(page, options.output or options.work))
