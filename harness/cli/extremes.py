"""``steadyload extremes``: sweeps to the edge of numerical stability."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from steadyload.cli.terminal import at_least, positive_number, progress_bar


def add_extremes(commands: Any) -> None:
    """Add the command to the parser's commands."""
    extremes = commands.add_parser(
        "extremes", help="take engines to where they stop being right; their operating envelope"
    )
    extremes.add_argument(
        "--engine", action="append", metavar="NAME", help="only this; may be repeated"
    )
    extremes.add_argument(
        "--sweep", action="append", metavar="NAME", help="only this; may be repeated"
    )
    extremes.add_argument(
        "--frequency", action="append", type=at_least(1), metavar="HZ",
        help="only at this many substeps a second; may be repeated",
    )  # fmt: skip
    extremes.add_argument(
        "--work", type=Path, metavar="DIR", default=Path("runs/extremes"),
        help="folder of what is measured; an interrupted run goes on from it",
    )  # fmt: skip
    extremes.add_argument(
        "--output", "-o", type=Path, metavar="DIR", help="folder of the page (default: --work)"
    )
    extremes.add_argument("--workers", "-j", type=at_least(1), default=1, help="default: 1")
    extremes.add_argument(
        "--timeout", type=positive_number, metavar="S", help="wall seconds a cell may take"
    )
    extremes.add_argument(
        "--write-envelope", action="store_true",
        help="write what was held to the file from which studies warn; of all sweeps and "
        "frequencies only",
    )  # fmt: skip
    extremes.set_defaults(run=_extremes)


def _extremes(options: argparse.Namespace) -> None:
    from steadyload.reports.page import write_page
    from steadyload.runs.definition import StudyError
    from steadyload.runs.provenance import provenance, provenance_lines
    from steadyload.studies.extremes.cells import run_extremes
    from steadyload.studies.extremes.envelope import extremes_record, write_envelopes
    from steadyload.studies.extremes.page import extremes_page
    from steadyload.studies.extremes.sweeps import FREQUENCIES, TIMEOUT

    if options.write_envelope and (options.sweep or options.frequency):
        raise StudyError("--write-envelope is of all sweeps and frequencies; leave these out")
    timeout = options.timeout or TIMEOUT
    made_by = provenance()  # of the code that measures, not of what it has become meanwhile
    with progress_bar("measuring") as advance:
        cells = run_extremes(
            options.work,
            only_engines=options.engine,
            only_sweeps=options.sweep,
            frequencies=sorted(set(options.frequency or FREQUENCIES)),
            timeout=timeout,
            workers=options.workers,
            progress=advance,
        )
    found = extremes_record(cells, timeout)
    print(
        write_page(extremes_page(found, provenance_lines(made_by)), options.output or options.work)
    )
    if options.write_envelope:
        print(write_envelopes(found.envelope, found.rests, made_by))
