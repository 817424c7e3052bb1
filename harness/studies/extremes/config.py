"""Configuration of the study of extremes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.config import option, positive_number
from steadyload.progress import NamedProgress, silent
from steadyload.studies.study import PublishedPage, Study


@dataclass(frozen=True)
class ExtremesConfig:
    """Which engines and sweeps, and how long a cell may take."""

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
        None, "CPU seconds a cell may take", metavar="S", read=positive_number
    )


class Extremes(Study[ExtremesConfig, Any]):
    """Sweeps to the edge of numerical stability."""

    name = "extremes"
    question = "Where does every engine stop being right?"
    about = "take engines to where they stop being right; their operating envelope"
    Config = ExtremesConfig
    published = (PublishedPage("extremes", "--write-envelope"),)

    def run(
        self,
        config: ExtremesConfig,
        work: Path,
        *,
        workers: int = 1,
        progress: NamedProgress = silent,
    ) -> Any:
        """The limits that each engine holds, and provenance."""
        from steadyload.runs.provenance import provenance
        from steadyload.studies.extremes.study import run_extremes
        from steadyload.studies.extremes.summary import extremes_record
        from steadyload.studies.extremes.sweeps import FREQUENCIES, TIMEOUT

        timeout = config.timeout or TIMEOUT
        made_by = provenance()  # of the code at the time of the measurement, not of later changes
        cells = run_extremes(
            work,
            only_engines=config.engines or None,
            only_sweeps=config.sweeps or None,
            frequencies=sorted(set(config.frequencies or FREQUENCIES)),
            timeout=timeout,
            workers=workers,
            progress=lambda *of: progress("measuring", *of),
        )
        return extremes_record(cells, timeout), made_by

    def page(self, result: Any) -> Any:
        """The page of the limits that every engine holds, sweep by sweep."""
        from steadyload.runs.provenance import provenance_lines
        from steadyload.studies.extremes.page import extremes_page

        found, made_by = result
        return extremes_page(found, provenance_lines(made_by))


STUDY = Extremes()
