"""Learned methods: what they are worth, and what makes them so."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, PublishedPage, Study, option

if TYPE_CHECKING:
    from steadyload.studies.learned.comparing import Found


class LearnedStudy(Study["Found"]):
    """Which plan, which parts of the page, and which cases are judged."""

    answers = "What are learned judges worth, and what makes them so?"
    about = "train what a plan asks for, judge, and write the page of learned judges"
    workers = 0
    pages = (PublishedPage("learned", "--foreign ../shared/data/aclpp/*.yaml"),)

    plan: Path | None = option(None, "TOML file (default: the one of the package)", metavar="FILE")
    foreign: tuple[Path, ...] = option(
        (), "layouts of another kind, which learners judge, too", metavar="FILE", fewest=0
    )
    limit: int | None = option(None, "judge only the first N cases a scenario", least=2)

    def run(self, lab: Lab) -> Found:
        """The trainings with their verdicts; missing ones are made."""
        from steadyload.learners import require_training

        require_training()
        from steadyload.learners.plans.plan_file import load_plan
        from steadyload.studies.learned.comparing import compare

        return compare(lab, load_plan(self.plan), self.foreign, self.limit)
