"""``steadyload table5``: the paper's Table 5 for every engine, and its page."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from steadyload.cli.terminal import at_least, progress_bar, resumable, say


def add_table5(commands: Any) -> None:
    """Add the command to the parser's commands."""
    table5 = commands.add_parser(
        "table5",
        help="all methods on the labelled test split, as Table 5 of the paper, every engine",
    )
    table5.add_argument(
        "--method", "-m", action="append", metavar="SPEC", default=[],
        help="may be repeated (default: the paper's methods on every engine, and our own)",
    )  # fmt: skip
    table5.add_argument(
        "--limit", type=at_least(2), metavar="N", help="only the first N cases a scenario"
    )
    table5.add_argument(
        "--timed", type=at_least(1), default=100, metavar="N",
        help="cases a scenario that are timed, in one process (default: 100)",
    )  # fmt: skip
    table5.add_argument(
        "--repeats", type=at_least(1), default=3, metavar="N",
        help="how often they are timed (default: 3)",
    )  # fmt: skip
    table5.add_argument(
        "--work", type=Path, metavar="DIR", default=Path("runs/table5"),
        help="folder of what is judged and timed; an interrupted run goes on "
        "(default: runs/table5)",
    )  # fmt: skip
    table5.add_argument(
        "--output", "-o", type=Path, metavar="DIR", help="folder of the page (default: --work)"
    )
    table5.add_argument(
        "--workers", "-j", type=at_least(1), metavar="N",
        help="processes that judge; timing always has one (default: one a core)",
    )  # fmt: skip
    table5.add_argument(
        "--views", type=at_least(0), default=0, metavar="N",
        help="write pages that play N of the cases that divide the methods, and link them "
        "(default: 0; needs trimesh: pip install 'steadyload[view]')",
    )  # fmt: skip
    table5.set_defaults(run=_table5)


def _table5(options: argparse.Namespace) -> None:
    from steadyload.reports.page import write_page
    from steadyload.reports.viewer.three_js import three_js
    from steadyload.runs.pool import all_cores
    from steadyload.studies.table5.front import NAME, timed_front, write_front
    from steadyload.studies.table5.page import table5_page
    from steadyload.studies.table5.study import Questions, judge_table5, time_table5
    from steadyload.studies.table5.summary import summarise
    from steadyload.studies.table5.views import with_views

    asked = Questions(
        methods=tuple(options.method),
        limit=options.limit,
        timed=options.timed,
        repeats=options.repeats,
    )
    if options.views:
        three_js()  # what is missing is better known before hours of work
    for spec, why in asked.left_out.items():
        say(f"{spec} is left out: {why}")
    workers = options.workers or all_cores()
    with resumable(options.work):
        with progress_bar("judging") as advance:
            judge_table5(asked, options.work, workers=workers, progress=advance)
        with progress_bar("timing") as advance:
            spatial, planar = time_table5(asked, options.work, progress=advance)
    output = options.output or options.work
    with progress_bar("views") as advance:
        found = with_views(
            summarise(asked, spatial, planar), output, options.views, progress=advance
        )
    write_front(timed_front(found), options.work / NAME)
    print(write_page(table5_page(found), output))
