"""``steadyload view``: watch a loading in the browser."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from steadyload.cli.reading import ReadingFlags
from steadyload.cli.terminal import status_line
from steadyload.studies.options import DEFAULT_METHOD, REQUIRED, operand, option


@dataclass(frozen=True, kw_only=True)
class View(ReadingFlags):
    """A layout, and the methods that judge it."""

    file: Path = operand(REQUIRED, "layouts; - reads standard input", metavar="FILE")
    layout: str | None = option(None, "which one of a file of several")
    method: str = option(
        DEFAULT_METHOD, f"default: {DEFAULT_METHOD}", names=("--method", "-m"), metavar="SPEC"
    )
    beside: str | None = option(None, "another method, played side by side", metavar="SPEC")
    output: Path = option(
        Path("view.html"), "the page (default: view.html)", names=("--output", "-o")
    )

    def run(self) -> None:
        """Write the page."""
        from steadyload.studies.viewing import pick_layout, write_view

        layout = pick_layout(self.file, self.layout, **self.reading())
        methods = [self.method, *filter(None, [self.beside])]
        with status_line() as say:
            say(f"judging {layout.name}")
            print(write_view(layout, methods, self.output))
