"""Configuration of the study of the labelled set."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.config import operand
from steadyload.progress import NamedProgress as Progress
from steadyload.progress import silent
from steadyload.studies.study import Study


@dataclass(frozen=True)
class BenchmarkConfig:
    """Which labelled set."""

    directory: str | None = operand(
        None,
        "folder of a labelled set, or planar for that of the package (default: its large one)",
        metavar="DIR",
    )


class BenchmarkStudy(Study[BenchmarkConfig, Any]):
    """Contents of a labelled set, and how far its labels can be trusted."""

    name = "benchmark"
    question = "What does the labelled set hold, and how sure are its labels?"
    about = "write the page of a set"
    command = "benchmark page"
    Config = BenchmarkConfig
    resumable = False
    workers = None

    def run(
        self, config: BenchmarkConfig, work: Path, *, workers: int = 1, progress: Progress = silent
    ) -> Any:
        """The summary of the set and its provenance."""
        from steadyload.layouts.benchmark import load_benchmark
        from steadyload.runs.labels import made_with
        from steadyload.studies.benchmark.summary import summarise

        found = load_benchmark(config.directory)
        return summarise(found), made_with(found), found.notes

    def page(self, result: Any) -> Any:
        """The page of cases, splits, labels and their confidence."""
        from steadyload.studies.benchmark.page import benchmark_page

        return benchmark_page(*result)


STUDY = BenchmarkStudy()
