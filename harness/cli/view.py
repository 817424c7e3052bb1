"""``steadyload view``: watch a loading in the browser."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from steadyload.cli.terminal import status_line


def add_view(commands: Any) -> None:
    """Add the command to the parser's commands."""
    view = commands.add_parser("view", help="write a page that plays a loading step by step")
    view.add_argument("file", metavar="FILE", type=Path)
    view.add_argument("--layout", metavar="NAME", help="which one of a file of several")
    view.add_argument(
        "--method", "-m", metavar="SPEC", default="ps3@mujoco", help="default: ps3@mujoco"
    )
    view.add_argument("--beside", metavar="SPEC", help="another method, played side by side")
    view.add_argument(
        "--output", "-o", type=Path, metavar="FILE", default=Path("view.html"),
        help="the page (default: view.html)",
    )  # fmt: skip
    view.set_defaults(run=_view)


def _view(options: argparse.Namespace) -> None:
    from steadyload.studies.viewing import pick_layout, write_view

    layout = pick_layout(options.file, options.layout)
    methods = [options.method, *filter(None, [options.beside])]
    with status_line() as say:
        say(f"judging {layout.name}")
        print(write_view(layout, methods, options.output))
