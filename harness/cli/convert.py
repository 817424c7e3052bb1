"""``steadyload convert``: layout files in another format."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from steadyload.cli.flags import UsageError
from steadyload.cli.interrupts import working
from steadyload.cli.reading import Files, check_output
from steadyload.config import REQUIRED, option, output_option

WRITABLE = ("native", "csv", "job", "parquet")
"""Formats that can be written."""

_ENDINGS = {".csv": "csv", ".json": "native", ".parquet": "parquet", "": "native"}
"""Suffix of an output -> the format that is meant by it."""


def output_format(output: Path, named: str | None) -> str:
    """The named format, else that of the suffix of the output.

    Raises:
        UsageError: no format is named, and none that can be written has this suffix.
    """
    if named is not None:
        return named
    suffix = output.suffix.lower()
    if suffix not in _ENDINGS:
        raise UsageError(
            f"--output: {str(output)!r} ends with {suffix!r}; allowed: .csv, .json, .parquet, or "
            f"--to with one of {', '.join(WRITABLE)}"
        )
    return _ENDINGS[suffix]


@dataclass(frozen=True, kw_only=True)
class Convert(Files):
    """Files in, a file out."""

    output: Path = output_option(REQUIRED, "the file that is written")
    to: str | None = option(
        None, "format of the output (default: csv for *.csv, native for *.json, parquet for "
        "*.parquet)", choices=WRITABLE,
    )  # fmt: skip

    def run(self) -> None:
        """Read all files, and write their layouts."""
        from steadyload.layouts.formats import Format, read_layouts, write_layouts

        working()
        check_output(self.output, self.files)
        kind, reading = Format(output_format(self.output, self.to)), self.reading()
        layouts = [layout for file in self.files for layout in read_layouts(file, **reading)]
        write_layouts(self.output, layouts, kind)
        print(f"{len(layouts)} layout{'s' if len(layouts) != 1 else ''} -> {self.output}")
