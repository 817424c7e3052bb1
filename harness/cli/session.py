"""``steadyload session``: what sessions cost, and what packing heuristics gain by them."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from steadyload.cli.terminal import at_least, status_line

_PARTS = ("cost", "gain")


def add_session(commands: Any) -> None:
    """Add the command to the parser's commands."""
    session = commands.add_parser(
        "session",
        help="pack with and without rejecting what is not stable; what a placement costs",
    )
    session.add_argument("--output", "-o", type=Path, metavar="DIR", default=Path("runs/session"))
    session.add_argument(
        "--part", action="append", choices=_PARTS, help="only this; may be repeated"
    )
    session.add_argument(
        "--method", "-m", action="append", metavar="SPEC",
        help="measure only this; may be repeated (default: those of the published page)",
    )  # fmt: skip
    session.add_argument(
        "--judge", metavar="SPEC", help="judges what was packed (default: label@reference)"
    )
    session.add_argument(
        "--lists", type=at_least(1), default=5, metavar="N",
        help="item lists of each class that are packed (default: 5)",
    )  # fmt: skip
    session.add_argument(
        "--most-items", type=at_least(40), default=200, metavar="J",
        help="items that are loaded where cost is measured (default: 200)",
    )  # fmt: skip
    session.set_defaults(run=_session)


def _session(options: argparse.Namespace) -> None:
    from steadyload.reports.page import write_page
    from steadyload.runs.provenance import provenance_lines
    from steadyload.studies.session.packing_gains import JUDGE, REJECTING, packing_gains
    from steadyload.studies.session.page import session_page
    from steadyload.studies.session.study import COSTED, SCENES, session_curves

    parts = options.part or _PARTS
    made_with = provenance_lines()  # of the code that measures, not of what it has become meanwhile
    with status_line() as say:
        curves = (
            session_curves(options.method or COSTED, count=options.most_items, progress=say)
            if "cost" in parts
            else []
        )
        tasks = (
            packing_gains(
                options.method or REJECTING,
                judge=options.judge or JUDGE,
                instances=options.lists,
                progress=say,
            )
            if "gain" in parts
            else []
        )
    page = session_page(curves, {s.name: s.about for s in SCENES}, tasks, made_with)
    print(write_page(page, options.output))
