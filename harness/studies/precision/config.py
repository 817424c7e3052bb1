"""Configuration of the study of precision."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.config import option, set_option
from steadyload.progress import NamedProgress, silent
from steadyload.studies.study import PublishedPage, Study


@dataclass(frozen=True)
class PrecisionConfig:
    """Which cases, on which engines."""

    directory: str = set_option()
    limit: int = option(100, "only the first N cases a scenario (default: 100)", least=2)
    engines: tuple[str, ...] = option(
        (), "only this engine; may be repeated (default: all of three dimensions and fixed steps "
        "that are installed)", names=("--engine",), metavar="NAME",
    )  # fmt: skip


class PrecisionStudy(Study[PrecisionConfig, Any]):
    """Verdicts of engines of single and double precision on loads that are moved and scaled."""

    name = "precision"
    question = "What does single precision cost, and what does a contact model?"
    about = "verdicts of single- and double-precision engines on loads that are moved and scaled"
    Config = PrecisionConfig
    published = (PublishedPage("precision", "--directory lists"),)

    def run(
        self,
        config: PrecisionConfig,
        work: Path,
        *,
        workers: int = 1,
        progress: NamedProgress = silent,
    ) -> Any:
        """The arguments of the page, in its order."""
        from steadyload.runs.able import fixed_step_engines
        from steadyload.runs.provenance import provenance_lines
        from steadyload.studies.precision.judging import judge_changed
        from steadyload.studies.precision.sizes import closed_forms_by_size
        from steadyload.studies.precision.summary import summarise

        made_with = provenance_lines()
        answers = judge_changed(
            config.directory, config.limit, work, only=config.engines, workers=workers,
            progress=progress,
        )  # fmt: skip
        sizes = closed_forms_by_size(
            fixed_step_engines(config.engines), work, workers=workers, progress=progress
        )
        return summarise(answers), len(answers.cases), len(answers.clusters), sizes, made_with

    def page(self, result: Any) -> Any:
        """The page of verdicts turned, and of accuracy by kind of load."""
        from steadyload.studies.precision.page import precision_page

        return precision_page(*result)


STUDY = PrecisionStudy()
