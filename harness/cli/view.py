"""``steadyload view``: watch a loading in the browser."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from steadyload.cli.reading import ReadingFlags
from steadyload.cli.terminal import status_line
from steadyload.studies.options import DEFAULT_METHOD, REQUIRED, operand, option


@dataclass(frozen=True, kw_only=True)
class View(ReadingFlags):
    """Layouts, and the methods that judge them."""

    file: Path = operand(REQUIRED, "layouts; - reads standard input", metavar="FILE")
    layouts: tuple[str, ...] = option(
        (), "only this one of a file of several; may be repeated", names=("--layout",),
        metavar="NAME",
    )  # fmt: skip
    method: str = option(
        DEFAULT_METHOD, f"default: {DEFAULT_METHOD}", names=("--method", "-m"), metavar="SPEC"
    )
    beside: str | None = option(None, "another method, played side by side", metavar="SPEC")
    output: Path = option(
        Path("view.html"), "the page (default: view.html)", names=("--output", "-o")
    )

    def run(self) -> None:
        """Write the page."""
        from steadyload.layouts.model import Layout
        from steadyload.studies.viewing import pick_layouts, write_view, write_views

        entries = pick_layouts(self.file, self.layouts, **self.reading())
        methods = [self.method, *filter(None, [self.beside])]
        with status_line() as say:
            if len(entries) == 1 and isinstance(entries[0], Layout):
                say(f"judging {entries[0].name}")
                print(write_view(entries[0], methods, self.output))
                return
            page = write_views(
                entries, methods, self.output, progress=lambda name: say(f"judging {name}")
            )
            print(page)
