"""Engines at the edge of numerical stability."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from steadyload.config import ConfigError
from steadyload.studies.kit import Lab, PublishedPage, Study, option

if TYPE_CHECKING:
    from steadyload.studies.extremes.showing import Found


class Extremes(Study["Found"]):
    """Sweeps to where engines stop being right, and the envelopes from which studies warn."""

    answers = "Where does every engine stop being right?"
    about = "take engines to where they stop being right; their operating envelope"
    pages = (PublishedPage("extremes", "--write-envelope"),)

    write_envelope: bool = option(False, "write what was held to the file from which studies warn")
    limit: int | None = option(
        None, "only the N lowest frequencies, engines of fixed steps, and N cases a scenario of "
        "loads that are moved and scaled (default: all, and 100)", least=1, metavar="N",
    )  # fmt: skip

    def __post_init__(self) -> None:
        if self.write_envelope and self.limit is not None:
            raise ConfigError("--write-envelope is of all frequencies; leave --limit out")

    def run(self, lab: Lab) -> Found:
        """The outcomes of all cells, and the limits that each engine holds."""
        from steadyload.engines.registry import capabilities, engines_here
        from steadyload.runs.provenance import provenance
        from steadyload.studies.extremes.loads import CASES, loads_moved_and_scaled
        from steadyload.studies.extremes.running import run_extremes
        from steadyload.studies.extremes.showing import shown
        from steadyload.studies.extremes.sweeps import FREQUENCIES

        made_by = provenance()  # of the code at the time of the measurement, not of later changes
        engines = [
            name for name in engines_here()
            if self.limit is None or not capabilities(name).error_controlled
        ]  # fmt: skip
        cells = run_extremes(lab, engines, frequencies=FREQUENCIES[: self.limit])
        return shown(cells, made_by, loads_moved_and_scaled(lab, min(CASES, self.limit or CASES)))

    def beside(self, found: Found, folder: Path) -> None:
        """The file of envelopes, where that is asked for; it lies in the package."""
        from steadyload.studies.extremes.envelopes import write_envelopes

        if self.write_envelope:
            write_envelopes(found.envelope, found.rests, found.made_by)

    def remarks(self, found: Found) -> Iterable[str]:
        """The path of the envelopes that were written."""
        from steadyload.studies.extremes.envelopes import envelope_file

        return (f"envelopes: {envelope_file()}",) if self.write_envelope else ()
