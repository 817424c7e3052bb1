"""Configuration of the comparison of methods on many layouts."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.config import REQUIRED, operand
from steadyload.progress import NamedProgress as Progress
from steadyload.progress import silent
from steadyload.studies.study import PublishedPage, Study


@dataclass(frozen=True)
class ComparisonConfig:
    """Which run is compared."""

    directory: Path = operand(REQUIRED, "folder of a study's run", metavar="DIR")


class Comparison(Study[ComparisonConfig, Any]):
    """The page of a study that was run; the run itself is ``steadyload study run``."""

    name = "comparison"
    question = "How do methods compare on many layouts: accuracy, cost, and where they disagree?"
    about = "write report.md of a study's folder"
    command = "report"
    Config = ComparisonConfig
    workers = None
    published = (
        PublishedPage(
            "accuracy", "runs/accuracy",
            ("study run reports/published/accuracy/study.toml -o runs/accuracy",),
            rows="runs/accuracy",
        ),
    )  # fmt: skip

    def run(
        self, config: ComparisonConfig, work: Path, *, workers: int = 1, progress: Progress = silent
    ) -> Any:
        """The summary of the rows of a run."""
        from steadyload.studies.comparison.summary import compare

        return compare(config.directory)

    def page(self, result: Any) -> Any:
        """The page of accuracy, cost and disagreements."""
        from steadyload.studies.comparison.page import study_page

        return study_page(result)


STUDY = Comparison()
