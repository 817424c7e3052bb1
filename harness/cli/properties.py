"""``steadyload properties``: what must hold of a judge, asked on layouts drawn at random."""

from __future__ import annotations

import argparse
import importlib.util
import os
from pathlib import Path
from typing import Any

from steadyload.cli.terminal import at_least, progress_bar, resumable, say
from steadyload.properties import PropertyError

_PROFILES = ("quick", "ci", "deep")


def add_properties(commands: Any) -> None:
    """Add the command to the parser's commands."""
    properties = commands.add_parser(
        "properties", help="property tests of methods and engines, on layouts drawn at random"
    )
    properties.add_argument(
        "--engine", action="append", metavar="NAME",
        help="only the label's way on this engine; may be repeated",
    )  # fmt: skip
    properties.add_argument(
        "--method", "-m", action="append", metavar="SPEC",
        help="only this method, for example ps3@mujoco; may be repeated "
        "(default: all static methods, and the label's way on every engine)",
    )  # fmt: skip
    properties.add_argument(
        "--property", action="append", metavar="NAME", help="only this; may be repeated"
    )
    properties.add_argument(
        "--profile", choices=_PROFILES, default="quick",
        help="cases a property and method: quick 20, ci 100, deep 1000 (default: quick)",
    )  # fmt: skip
    properties.add_argument(
        "--examples", type=at_least(1), metavar="N", help="so many cases, whatever the profile"
    )
    properties.add_argument("--seed", type=at_least(0), default=0, help="of the cases (default: 0)")
    properties.add_argument(
        "--output", "-o", type=Path, metavar="DIR", default=Path("runs/properties"),
        help="folder of the page (default: runs/properties)",
    )  # fmt: skip
    properties.add_argument(
        "--work", type=Path, metavar="DIR",
        help="folder of the results; an interrupted run goes on from it (default: --output)",
    )  # fmt: skip
    properties.add_argument(
        "--workers", "-j", type=at_least(1), default=os.cpu_count() or 1, help="default: all cores"
    )
    properties.set_defaults(run=_properties)


def _properties(options: argparse.Namespace) -> int:
    if importlib.util.find_spec("hypothesis") is None:
        raise PropertyError("property tests need hypothesis: pip install 'steadyload[properties]'")
    from steadyload.properties.registry import chosen
    from steadyload.properties.search import PROFILES
    from steadyload.reports.page import write_page
    from steadyload.studies.properties.page import properties_page, refusals, violations
    from steadyload.studies.properties.study import (
        PropertyStudy,
        made_with,
        methods_on,
        run_properties,
    )

    methods = list(options.method or ())
    if options.engine or not methods:
        methods += methods_on(options.engine)
    study = PropertyStudy(
        methods=tuple(dict.fromkeys(methods)),
        properties=tuple(chosen(options.property)),
        examples=options.examples or PROFILES[options.profile],
        seed=options.seed,
    )
    manifest = made_with(study)
    work = options.work or options.output
    with resumable(work), progress_bar("asking") as advance:
        table = run_properties(
            study, work, output=options.output, workers=options.workers, progress=advance
        )
    print(write_page(properties_page(table, manifest), options.output))
    for spec, (refused, tried) in refusals(table.rows).items():
        say(f"{spec}: not asked on {refused} of {tried} cases, which lie outside its range")
    violated = violations(table.rows)
    for row in violated:
        found = row.smallest.found if row.smallest else row.why
        say(f"{row.property}, {row.method.spec}: {found}")
    return 1 if violated else 0
