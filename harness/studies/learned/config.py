"""Configuration of the study of learned methods."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.config import option
from steadyload.progress import NamedProgress, silent
from steadyload.studies.study import PublishedPage, Study


@dataclass(frozen=True)
class LearnedConfig:
    """Which plan, which parts of the page, and which cases are judged."""

    plan: Path | None = option(None, "TOML file (default: the one of the package)", metavar="FILE")
    only: tuple[str, ...] = option(
        (), "only these parts of the page: table, size, sources, remedies, calibration, leak, "
        "foreign", metavar="PART", fewest=1,
    )  # fmt: skip
    judge_on: str | None = option(
        None, "part of the labelled set, such as validation (default: the plan's)", metavar="PART"
    )
    foreign: tuple[Path, ...] = option(
        (), "layouts of another kind, which learners judge, too", metavar="FILE", fewest=0
    )
    limit: int | None = option(None, "judge only the first N cases a scenario", least=2)


class LearnedStudy(Study[LearnedConfig, Any]):
    """The trainings of a plan, and their evaluation."""

    name = "learned"
    question = "What are learned judges worth, and what makes them so?"
    about = "train what a plan asks for, judge, and write the page of learned judges"
    Config = LearnedConfig
    workers = 0
    published = (PublishedPage("learned", "--foreign ../shared/data/aclpp/*.yaml"),)

    def run(
        self,
        config: LearnedConfig,
        work: Path,
        *,
        workers: int = 1,
        progress: NamedProgress = silent,
    ) -> Any:
        """The trainings with their verdicts, and provenance."""
        from steadyload.errors import nearest
        from steadyload.learners import LearnerError, require_training

        require_training()
        from steadyload.layouts.benchmark import Part
        from steadyload.learners.plans.plan import Section
        from steadyload.learners.plans.plan_file import check_part, load_plan
        from steadyload.runs.provenance import provenance_lines
        from steadyload.studies.learned.study import learner_study

        for name in config.only:
            if name not in list(Section):
                raise LearnerError(f"part is {name!r}; {nearest(name, list(Section))}")
        if config.judge_on is not None:
            check_part(config.judge_on)
        record = learner_study(
            load_plan(config.plan),
            work,
            only=[Section(name) for name in config.only],
            part=Part(config.judge_on) if config.judge_on else None,
            limit=config.limit,
            foreign=config.foreign,
            workers=workers,
            progress=progress,
        )
        return record, provenance_lines()

    def page(self, result: Any) -> Any:
        """The page of accuracy, cost and calibration of learned methods."""
        from steadyload.studies.learned.page import learned_page

        return learned_page(*result)


STUDY = LearnedStudy()
