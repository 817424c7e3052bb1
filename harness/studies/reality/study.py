"""Engines compared with recorded motion of a real body that is thrown onto a floor."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, Study, option

if TYPE_CHECKING:
    from steadyload.studies.reality.comparing import Found

FILE = "tosses.csv"
"""File beside the page: a line a toss and engine."""


class Reality(Study["Found"]):
    """A record of thrown bodies, and the engines that are released like them."""

    answers = "How closely do engines predict where a real box comes to rest?"
    about = "compare engines with recorded motion of a real body that is thrown onto a floor"

    data: Path | None = option(
        None, "file of recorded motion, see docs/measured.md (default: that of the rows in --work)",
        metavar="FILE",
    )  # fmt: skip
    profile: Path | None = option(
        None, "TOML file that says how it is read, such as docs/measured/tosses.toml",
        metavar="FILE",
    )  # fmt: skip
    reference: bool = option(
        False,
        "also the reference and engines that only check others, where rows of them are missing: "
        "once for each trial, without jitters",
    )
    limit: int | None = option(
        None, "only so many trials, the first, and layouts (default: all trials, 300 layouts)",
        least=8, metavar="N",
    )  # fmt: skip

    def run(self, lab: Lab) -> Found:
        """Missing trials are simulated, and all are compared with the record."""
        from steadyload.studies.reality.comparing import compare
        from steadyload.studies.reality.running import measured

        return compare(measured(lab, self.data, self.profile, self.limit, self.reference))

    def beside(self, found: Found, folder: Path) -> None:
        """All trials by all engines, as a CSV file."""
        from steadyload.atomic import write_atomically
        from steadyload.studies.reality.tosses import as_csv

        folder.mkdir(parents=True, exist_ok=True)
        write_atomically(folder / FILE, as_csv(found.measured).encode())
