"""``steadyload verify``: engines against mechanics, and the reference against itself."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import Any

from steadyload.cli.terminal import at_least, progress_bar, status_line


def add_verify(commands: Any) -> None:
    """Add the command and its actions to the parser's commands."""
    verify = commands.add_parser("verify", help="check engines against mechanics and each other")
    actions = verify.add_subparsers(required=True, metavar="ACTION")

    closed = actions.add_parser(
        "closed-forms", help="hold engines against formulas: tipping, sliding, spinning, stacks"
    )
    closed.add_argument(
        "--engine", action="append", metavar="NAME", help="only this; may be repeated"
    )
    closed.add_argument(
        "--output", "-o", type=Path, metavar="DIR", default=Path("runs/closed-forms")
    )
    closed.set_defaults(run=_closed_forms)

    converged = actions.add_parser(
        "convergence", help="change the reference one parameter at a time; ask other judges"
    )
    converged.add_argument(
        "--layouts", type=at_least(1), default=900, metavar="N", help="default: 900"
    )
    converged.add_argument(
        "--sample",
        type=at_least(0),
        default=50,
        metavar="N",
        help="layouts that slow judges are asked; 0 asks none (default: 50)",
    )
    converged.add_argument(
        "--second-model", action="store_true", help="ask Drake, too (needs the extra `drake`)"
    )
    converged.add_argument(
        "--work", type=Path, metavar="DIR", default=Path("runs/convergence"),
        help="folder of the results; an interrupted run goes on from it",
    )  # fmt: skip
    converged.add_argument(
        "--output", "-o", type=Path, metavar="DIR", help="folder of the page (default: --work)"
    )
    converged.add_argument("--workers", "-j", type=at_least(1), default=os.cpu_count() or 1)
    converged.set_defaults(run=_convergence)


def _closed_forms(options: argparse.Namespace) -> None:
    from steadyload.reports.page import write_page
    from steadyload.runs.provenance import provenance_lines
    from steadyload.studies.closed_forms.page import closed_forms_page
    from steadyload.studies.closed_forms.study import closed_form_tests, closed_forms

    made_with = provenance_lines()
    with status_line() as say:
        results = closed_forms(options.engine, progress=say)
    print(write_page(closed_forms_page(closed_form_tests(), results, made_with), options.output))


def _convergence(options: argparse.Namespace) -> None:
    from steadyload.reports.page import write_page
    from steadyload.studies.convergence.page import convergence_page
    from steadyload.studies.convergence.study import (
        OPINIONS,
        SECOND_MODEL,
        made_with,
        run_convergence,
    )

    opinions = (*OPINIONS, SECOND_MODEL) if options.second_model else OPINIONS
    with progress_bar("judging") as advance:
        found = run_convergence(
            options.work,
            layouts=options.layouts,
            sample=options.sample,
            opinions=opinions,
            workers=options.workers,
            progress=advance,
        )
    page = convergence_page(found, made_with(options.work))
    print(write_page(page, options.output or options.work))
