"""Configuration of the study of scale."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.config import option
from steadyload.studies.study import Progress, PublishedPage, Study, silent

_FEWEST_ROWS = 10_000


@dataclass(frozen=True)
class ScaleConfig:
    """Number of rows of the largest study."""

    rows: int = option(
        100_000,
        "of the largest study; the others have a tenth, a hundredth, ... (default: 100000)",
        least=_FEWEST_ROWS,
    )


class Scale(Study[ScaleConfig, Any]):
    """Time and memory of studies, by their number of rows."""

    name = "scale"
    question = "What does a study need by its number of rows: time, memory, disk?"
    about = "measure what studies of many rows need"
    command = "study measure"
    Config = ScaleConfig
    workers = 2
    published = (PublishedPage("scale", "--rows 1000000"),)

    def run(
        self, config: ScaleConfig, work: Path, *, workers: int = 2, progress: Progress = silent
    ) -> Any:
        """The measurements, a sentence on how they were taken, and provenance."""
        from steadyload.studies.scale.study import METHODS, REPETITIONS, scale

        largest = config.rows - config.rows % _FEWEST_ROWS
        counts = [largest // 10**k for k in range(8) if largest // 10**k >= _FEWEST_ROWS]
        how = (
            f"Generated layouts, judged by {', '.join(METHODS)}, {REPETITIONS} times each, over "
            f"{workers} processes."
        )
        points, made_with = scale(counts[::-1], work, workers=workers, progress=progress)
        return points, how, made_with

    def page(self, result: Any) -> Any:
        """The page of time and memory of a run, of reading it and of its report."""
        from steadyload.studies.scale.page import scale_page

        return scale_page(*result)


STUDY = Scale()
