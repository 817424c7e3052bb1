"""Engines compared with recorded motion of a real body that is thrown onto a floor."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, PublishedPage, Study, option

if TYPE_CHECKING:
    from steadyload.studies.reality.comparing import Found

FILE = "tosses.csv"
"""File beside the page: a line a toss and engine."""


class Reality(Study["Found"]):
    """A record of thrown bodies, and the engines that are released like them."""

    question = "How closely do engines predict where a real box comes to rest?"
    about = "compare engines with recorded motion of a real body that is thrown onto a floor"
    pages = (PublishedPage("reality", "--labels 300"),)

    data: Path | None = option(
        None, "file of recorded motion, see docs/measured.md (default: that of the rows in --work)",
        metavar="FILE",
    )  # fmt: skip
    profile: Path | None = option(
        None, "TOML file that says how it is read, such as docs/measured/tosses.toml",
        metavar="FILE",
    )  # fmt: skip
    engines: tuple[str, ...] = option(
        (), "only this; may be repeated (default: all of three dimensions that are here)",
        names=("--engine",), metavar="NAME",
    )  # fmt: skip
    trials: int | None = option(
        None, "only so many trials, the first (default: all)", least=8, metavar="N"
    )
    jitters: int = option(
        24, "released states within the noise for each trial (default: 24)", least=2, most=1000
    )
    seed: int = option(0, "of the halves, the search and the jitters (default: 0)", least=0)
    reference: bool = option(
        False,
        "also the reference and engines that only check others, where rows of them are missing: "
        "once for each trial, without jitters",
    )
    labels: int = option(
        0, "layouts of the labelled set that are judged with fitted contacts, too (default: 0)",
        least=0, metavar="N",
    )  # fmt: skip

    def run(self, lab: Lab) -> Found:
        """Missing trials are simulated, and all are compared with the record."""
        from steadyload.studies.reality.comparing import compare
        from steadyload.studies.reality.running import measured

        return compare(
            measured(
                lab, data=self.data, profile=self.profile, limit=self.trials, engines=self.engines,
                jitters=self.jitters, seed=self.seed, reference=self.reference, labels=self.labels,
            )
        )  # fmt: skip

    def beside(self, found: Found, folder: Path) -> None:
        """All trials by all engines, as a CSV file."""
        from steadyload.atomic import write_atomically
        from steadyload.studies.reality.tosses import as_csv

        folder.mkdir(parents=True, exist_ok=True)
        write_atomically(folder / FILE, as_csv(found.measured).encode())
