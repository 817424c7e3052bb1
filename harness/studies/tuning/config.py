"""Configuration of the study of tuning."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.config import REQUIRED, operand, option
from steadyload.progress import NamedProgress, silent
from steadyload.studies.study import PublishedPage, Study


@dataclass(frozen=True, kw_only=True)
class TuningConfig:
    """Which searches found the presets, and on how many cases these are judged."""

    searches: tuple[Path, ...] = operand(REQUIRED, "folders of searches", metavar="DIR")
    limit: int | None = option(None, "only the first N cases a scenario", least=2)

    def check(self) -> None:
        """Check that searches have different names.

        Raises:
            TuningError: two folders have one name.
        """
        from steadyload.tuning import TuningError

        names = [folder.resolve().name for folder in self.searches]
        if len(set(names)) < len(names):
            listed = ", ".join(names)
            raise TuningError(f"folders of searches: {listed}; allowed: names that differ")


class TuningStudy(Study[TuningConfig, Any]):
    """Tuned presets on cases that were used in no search."""

    name = "tuning"
    question = "What does tuning a simulation bring, and which parameter brings it?"
    about = "compare tuned presets with other methods on test, and write the page of tuning"
    Config = TuningConfig
    workers = 0
    published = (PublishedPage("tuning", "reports/published/tuning/searches/*/ --limit 150"),)

    def run(
        self,
        config: TuningConfig,
        work: Path,
        *,
        workers: int = 1,
        progress: NamedProgress = silent,
    ) -> Any:
        """The evaluated presets, and provenance."""
        from steadyload.runs.provenance import provenance_lines
        from steadyload.studies.tuning.study import tuning_study
        from steadyload.tuning.search import Search

        config.check()
        record = tuning_study(
            [Search.of(folder) for folder in config.searches],
            work,
            workers=workers,
            limit=config.limit,
            progress=lambda *of: progress("judging", *of),
        )
        return record, provenance_lines()

    def page(self, result: Any) -> Any:
        """The page of presets beside other methods, and of the gain of each parameter."""
        from steadyload.studies.tuning.page import tuning_page

        return tuning_page(*result)


STUDY = TuningStudy()
