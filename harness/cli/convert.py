"""``steadyload convert``: layout files in another format."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from steadyload.cli.deck import Deck
from steadyload.cli.interrupts import working
from steadyload.cli.snap import Snap
from steadyload.studies.options import REQUIRED, operand, option

WRITABLE = ("native", "csv", "job")
"""Formats that can be written."""


def output_format(output: Path, named: str | None) -> str:
    """The named format, else that of the suffix of the output."""
    return named or ("csv" if output.suffix.lower() == ".csv" else "native")


@dataclass(frozen=True, kw_only=True)
class Convert(Deck, Snap):
    """Files in, a file out."""

    files: tuple[Path, ...] = operand(REQUIRED, "layouts", metavar="FILE")
    output: Path = option(REQUIRED, "the file that is written", names=("--output", "-o"))
    to: str | None = option(
        None, "format of the output (default: csv for *.csv, else native)", choices=WRITABLE
    )

    def run(self) -> None:
        """Read all files, and write their layouts."""
        from steadyload.layouts.formats import Format, read_layouts, write_layouts

        working()
        layouts = [
            layout
            for file in self.files
            for layout in read_layouts(file, snap_gap=self.gap, **self.deck)
        ]
        write_layouts(self.output, layouts, Format(output_format(self.output, self.to)))
        print(f"{len(layouts)} layouts -> {self.output}")
