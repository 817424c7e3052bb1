"""Configuration of the study of packers' plans."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.config import operand
from steadyload.studies.study import Progress, Study, silent


@dataclass(frozen=True)
class PackersConfig:
    """Which labelled set."""

    directory: str | None = operand(
        None,
        "folder of a labelled set of real size (default: real, that of the package)",
        metavar="DIR",
    )


class PackersStudy(Study[PackersConfig, Any]):
    """Share of packers' plans that stand, box by box, by the labels of a set."""

    name = "packers"
    question = "Which share of packers' plans stands while it is loaded, box by box?"
    about = "count how many plans of packers stand, by the labels of a set, and show why not"
    Config = PackersConfig
    resumable = False
    workers = None

    def run(
        self, config: PackersConfig, work: Path, *, workers: int = 1, progress: Progress = silent
    ) -> Any:
        """The summary of the plans and the provenance of the set."""
        from steadyload.layouts.benchmark import REAL, load_benchmark
        from steadyload.studies.benchmark.summary import made_with
        from steadyload.studies.packers.summary import summarise

        found = load_benchmark(config.directory or REAL)
        return summarise(found), made_with(found)

    def page(self, result: Any) -> Any:
        """The page of shares, pairs, causes and the worst plans."""
        from steadyload.studies.packers.page import packers_page

        return packers_page(*result)


STUDY = PackersStudy()
