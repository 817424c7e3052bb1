"""``steadyload study`` and ``steadyload report``: compare methods, and the page of a comparison."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from steadyload.cli.terminal import at_least, progress_bar, resumable, say, status_line
from steadyload.runs.definition import EMBEDDED, load_study
from steadyload.runs.envelope_use import study_warnings
from steadyload.runs.executors import EXECUTORS, make_executor
from steadyload.runs.results import load_manifest

_FEWEST_ROWS = 10_000


def add_study(commands: Any) -> None:
    """Add the command ``study``."""
    study = commands.add_parser(
        "study", help="compare methods on many layouts, or on labelled ones"
    )
    actions = study.add_subparsers(required=True, metavar="ACTION")
    run = actions.add_parser("run", help="run or resume a study")
    run.add_argument(
        "study",
        metavar="STUDY.toml",
        help=f"a study file, or the word {EMBEDDED!r}: a slice of the shipped labelled set",
    )
    run.add_argument("--output", "-o", type=Path, metavar="DIR", help="default: runs/NAME")
    run.add_argument(
        "--workers",
        "-j",
        type=at_least(1),
        metavar="N",
        help="processes that judge, or workers of a Dask cluster on this machine (default: one a "
        "core)",
    )
    run.add_argument(
        "--executor",
        choices=list(EXECUTORS),
        default="processes",
        help="where to judge: in this process, in others beside it, or on a Dask cluster (default: "
        "processes)",
    )
    run.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="of the Dask cluster, such as tcp://10.0.0.1:8786 (default: one on this machine)",
    )
    past = run.add_mutually_exclusive_group()
    past.add_argument("--rerun", action="store_true", help="compute everything anew")
    past.add_argument(
        "--resume",
        action="store_true",
        help="go on with a run; wrong where there is none (default: go on or begin)",
    )
    run.set_defaults(run=_run)

    measure = actions.add_parser("measure", help="measure what studies of many rows need")
    measure.add_argument(
        "--rows",
        type=at_least(_FEWEST_ROWS),
        default=100_000,
        metavar="N",
        help="of the largest study; the others have a tenth, a hundredth, ... (default: 100000)",
    )
    measure.add_argument(
        "--workers", "-j", type=at_least(1), default=2, metavar="N",
        help="processes that judge (default: 2)",
    )  # fmt: skip
    measure.add_argument("--output", "-o", type=Path, metavar="DIR", default=Path("runs/scale"))
    measure.set_defaults(run=_measure)


def add_report(commands: Any) -> None:
    """Add the command ``report``."""
    report = commands.add_parser("report", help="write report.md of a study's folder")
    report.add_argument("directory", type=Path, metavar="DIR")
    report.add_argument(
        "--output", "-o", type=Path, metavar="DIR", help="folder of the page (default: the study's)"
    )
    report.set_defaults(run=_report)


def _run(options: argparse.Namespace) -> None:
    from steadyload.runs.runner import run_study

    study = load_study(options.study)
    directory = options.output or Path("runs") / study.name
    told = {"workers": options.workers, "scheduler": options.scheduler}
    with (
        make_executor(options.executor, **told) as executor,
        resumable(directory),
        progress_bar("judging") as advance,
    ):
        computed = run_study(
            study,
            directory,
            workers=executor,
            rerun=options.rerun,
            resume=options.resume,
            progress=advance,
        )
    for warning in study_warnings(load_manifest(directory)["envelope"]):
        say(warning)
    print(f"{computed} rows computed; results in {directory}")


def _measure(options: argparse.Namespace) -> None:
    from steadyload.reports.page import write_page
    from steadyload.runs.provenance import provenance_lines
    from steadyload.studies.scale.page import scale_page
    from steadyload.studies.scale.study import METHODS, REPETITIONS, scale

    largest = options.rows - options.rows % _FEWEST_ROWS
    counts = [largest // 10**k for k in range(8) if largest // 10**k >= _FEWEST_ROWS]
    made_with = provenance_lines()
    how = (
        f"Generated layouts, judged by {', '.join(METHODS)}, {REPETITIONS} times each, over "
        f"{options.workers} processes."
    )
    with status_line() as tell:
        points = scale(counts[::-1], workers=options.workers, progress=tell)
    print(write_page(scale_page(points, how, made_with), options.output))


def _report(options: argparse.Namespace) -> None:
    from steadyload.reports.page import write_page
    from steadyload.studies.comparison.page import study_page
    from steadyload.studies.comparison.summary import compare

    page = study_page(compare(options.directory))
    print(write_page(page, options.output or options.directory))
