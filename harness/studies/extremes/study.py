"""Engines at the edge of numerical stability."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from steadyload.config import ConfigError, positive_number
from steadyload.studies.kit import Lab, PublishedPage, Study, option

if TYPE_CHECKING:
    from steadyload.studies.extremes.showing import Found


class Extremes(Study["Found"]):
    """Sweeps to where engines stop being right, and the envelopes from which studies warn."""

    question = "Where does every engine stop being right?"
    about = "take engines to where they stop being right; their operating envelope"
    pages = (PublishedPage("extremes", "--write-envelope --loads 100"),)

    engines: tuple[str, ...] = option(
        (), "only this; may be repeated", names=("--engine",), metavar="NAME"
    )
    sweeps: tuple[str, ...] = option(
        (), "only this; may be repeated", names=("--sweep",), metavar="NAME"
    )
    frequencies: tuple[int, ...] = option(
        (), "only at this many substeps a second; may be repeated", names=("--frequency",),
        metavar="HZ", least=1,
    )  # fmt: skip
    timeout: float | None = option(
        None, "CPU seconds a cell may take (default: 30)", metavar="S", read=positive_number
    )
    write_envelope: bool = option(
        False, "write what was held to the file from which studies warn; of all sweeps and "
        "frequencies only",
    )  # fmt: skip

    loads: int = option(
        0, "cases a scenario of the set of many lists that are moved and scaled, on engines of "
        "three dimensions and fixed steps (default: 0, none)", least=0, metavar="N",
    )  # fmt: skip

    def __post_init__(self) -> None:
        if self.write_envelope and (self.sweeps or self.frequencies):
            raise ConfigError("--write-envelope is of all sweeps and frequencies; leave these out")

    def run(self, lab: Lab) -> Found:
        """The outcomes of all cells, and the limits that each engine holds."""
        from steadyload.runs.provenance import provenance
        from steadyload.studies.extremes.loads import loads_moved_and_scaled
        from steadyload.studies.extremes.running import run_extremes
        from steadyload.studies.extremes.showing import Found
        from steadyload.studies.extremes.sweeps import FREQUENCIES, TIMEOUT

        timeout = self.timeout or TIMEOUT
        made_by = provenance()  # of the code at the time of the measurement, not of later changes
        rates = sorted(set(self.frequencies or FREQUENCIES))
        cells = run_extremes(lab, self.engines, self.sweeps, frequencies=rates, timeout=timeout)
        loads = loads_moved_and_scaled(lab, self.engines, self.loads) if self.loads else None
        return Found(cells, timeout, made_by, loads)

    def beside(self, found: Found, folder: Path) -> None:
        """The file of envelopes, where that is asked for; it lies in the package."""
        from steadyload.studies.extremes.envelopes import write_envelopes

        if self.write_envelope:
            write_envelopes(found.envelope, found.rests, found.made_by)

    def remarks(self, found: Found) -> Iterable[str]:
        """The path of the envelopes that were written."""
        from steadyload.studies.extremes.envelopes import envelope_file

        return (f"envelopes: {envelope_file()}",) if self.write_envelope else ()
