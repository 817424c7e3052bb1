"""Configuration of the study of rules."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.config import methods_option, option, set_option
from steadyload.progress import NamedProgress as Progress
from steadyload.progress import silent
from steadyload.studies.study import PublishedPage, Study


@dataclass(frozen=True)
class SensitivityConfig:
    """Which methods, and on how many cases of the test part of which set."""

    methods: tuple[str, ...] = methods_option(
        "may be repeated (default: the paper's methods, and the best of ours)"
    )
    limit: int = option(50, "cases a scenario, those of the first ranks (default: 50)", least=2)
    directory: str = set_option()


class Sensitivity(Study[SensitivityConfig, Any]):
    """Accuracy and rank of methods by the rule that labels are made by."""

    name = "sensitivity"
    question = "Which conclusions survive another time, threshold or point that is measured?"
    about = "rank of every method over the rule by which a loading fails, told the rule and not"
    Config = SensitivityConfig
    workers = 0
    published = (PublishedPage("sensitivity", "--limit 100"),)

    def run(
        self,
        config: SensitivityConfig,
        work: Path,
        *,
        workers: int = 1,
        progress: Progress = silent,
    ) -> Any:
        """Accuracy of every method by every rule, as it stands and told the rule."""
        from steadyload.layouts.benchmark.dataset import set_named
        from steadyload.studies.sensitivity.study import METHODS, run_sensitivity

        return run_sensitivity(
            config.methods or METHODS, config.limit, work, benchmark=set_named(config.directory),
            workers=workers, progress=progress,
        )  # fmt: skip

    def page(self, result: Any) -> Any:
        """The page of ranks over rules, and of the conclusions that survive."""
        from steadyload.studies.sensitivity.page import sensitivity_page

        return sensitivity_page(result)


STUDY = Sensitivity()
