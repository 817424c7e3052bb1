"""Configuration of the study of cascades."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.config import methods_option, option, set_option
from steadyload.studies.study import Progress, PublishedPage, Study, silent


@dataclass(frozen=True)
class CascadeConfig:
    """Which cascade is compared with which methods, on which cases."""

    engine: str = option("mujoco", "default: mujoco", metavar="NAME")
    methods: tuple[str, ...] = methods_option("a further method on the page; may be repeated")
    thresholds: Path | None = option(
        None, "file of thresholds (default: the one of the package)", metavar="FILE"
    )
    directory: str = set_option()
    judge_on: str = option(
        "test", "part of the labelled set, such as validation (default: test)", metavar="PART"
    )
    limit: int = option(300, "cases a scenario (default: 300)", least=2)


class CascadeStudy(Study[CascadeConfig, Any]):
    """A cascade compared with its stages and simulations, on cases on which nothing was fitted."""

    name = "cascade"
    question = "What does a cascade save, and what accuracy does it cost?"
    about = "compare a cascade with its stages and with simulations on test, and write its page"
    command = "cascade page"
    Config = CascadeConfig
    workers = None
    published = (PublishedPage("cascade", "--directory lists"),)

    def run(
        self, config: CascadeConfig, work: Path, *, workers: int = 1, progress: Progress = silent
    ) -> Any:
        """Verdicts and provenance; judged in one process, because times are shown."""
        from steadyload.runs.provenance import provenance_lines
        from steadyload.studies.cascade.study import cascade_study

        record = cascade_study(
            config.engine,
            work,
            others=config.methods,
            directory=config.directory,
            part=config.judge_on,
            thresholds=str(config.thresholds or ""),
            limit=config.limit,
            progress=lambda *of: progress("judging", *of),
        )
        return record, provenance_lines()

    def page(self, result: Any) -> Any:
        """The page of accuracy against cost and of the steps that every stage decides."""
        from steadyload.studies.cascade.page import cascade_page

        return cascade_page(*result)


STUDY = CascadeStudy()
