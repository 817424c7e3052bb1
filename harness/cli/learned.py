"""``steadyload learned``: train what a plan asks for, judge, and write the page of learners."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import Any

from steadyload.cli.terminal import at_least, resumable, status_line
from steadyload.methods.spec import nearest


def add_learned(commands: Any) -> None:
    """Add the command to the parser's commands."""
    study = commands.add_parser(
        "learned", help="train what a plan asks for, judge, and write the page of learned judges"
    )
    study.add_argument(
        "--plan", type=Path, metavar="FILE", help="TOML file (default: the one of the package)"
    )
    study.add_argument(
        "--only", nargs="+", metavar="PART",
        help="only these parts of the page: table, size, sources, remedies, calibration, leak, "
        "foreign",
    )  # fmt: skip
    study.add_argument(
        "--judge-on", metavar="PART",
        help="part of the labelled set, such as validation (default: the plan's)",
    )  # fmt: skip
    study.add_argument(
        "--foreign", nargs="*", type=Path, default=[], metavar="FILE",
        help="layouts of another kind, of which learners are asked, too",
    )  # fmt: skip
    study.add_argument(
        "--work", type=Path, metavar="DIR", default=Path("runs/learned"),
        help="folder of sets, trainings and verdicts; an interrupted run goes on (default: "
        "runs/learned)",
    )  # fmt: skip
    study.add_argument(
        "--output", "-o", type=Path, metavar="DIR", help="folder of the page (default: --work)"
    )
    study.add_argument(
        "--limit", type=at_least(2), metavar="N", help="judge only the first N cases a scenario"
    )
    study.add_argument(
        "--workers", "-j", type=at_least(1), default=os.cpu_count() or 1,
        help="trainings and judges at once, one thread each (default: all cores)",
    )  # fmt: skip
    study.set_defaults(run=_learned)


def _learned(options: argparse.Namespace) -> None:
    from steadyload.learners import LearnerError, require_training

    require_training()
    from steadyload.layouts.benchmark import Part
    from steadyload.reports.page import write_page
    from steadyload.runs.provenance import provenance_lines
    from steadyload.studies.learned.page import learned_page
    from steadyload.studies.learned.plan import Section
    from steadyload.studies.learned.plan_file import check_part, load_plan
    from steadyload.studies.learned.study import learner_study

    for name in options.only or ():
        if name not in list(Section):
            raise LearnerError(f"part is {name!r}; {nearest(name, list(Section))}")
    if options.judge_on is not None:
        check_part(options.judge_on)
    plan = load_plan(options.plan)
    with resumable(options.work), status_line() as tell:
        record = learner_study(
            plan,
            options.work,
            only=[Section(name) for name in options.only or ()],
            part=Part(options.judge_on) if options.judge_on else None,
            limit=options.limit,
            foreign=options.foreign,
            workers=options.workers,
            generating=lambda done, total: tell(f"item lists: {done} of {total}"),
            training=lambda done, total: tell(f"trainings: {done} of {total}"),
            judging=lambda done, total: tell(f"verdicts: {done} of {total}"),
        )
    page = learned_page(record, provenance_lines())
    print(write_page(page, options.output or options.work))
