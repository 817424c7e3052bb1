"""Configuration of the study of scopes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.config import methods_option, option
from steadyload.studies.study import Progress, Study, silent


@dataclass(frozen=True)
class ScopeConfig:
    """The labelled set, the cases that are drawn from it, and the options that are compared."""

    benchmark: str = option(
        "real", "the labelled set: its name, or its folder (default: real)", metavar="SET"
    )
    most_items: int = option(45, "boxes that a case may have (default: 45)", least=1, metavar="J")
    cases: int = option(
        300, "that are drawn of train and validation, evenly over sources (default: 300)", least=1
    )
    standing_cases: int = option(
        300, "of them that are asked whether the load stands (default: 300)", least=1
    )
    seconds: float = option(
        30.0, "CPU time that a verdict may take (default: 30)", unit="s", least=0.001
    )
    methods: tuple[str, ...] = methods_option(
        "compare only this option; may be repeated (default: those of the published page)"
    )


class ScopeStudy(Study[ScopeConfig, Any]):
    """Verdicts that change, and cost that is saved, when a part of a pile is simulated."""

    name = "scope"
    question = "Which way to leave things out of a simulation costs which verdicts, and saves what?"
    about = "simulations of only what a step changes, beside those of the whole pile"
    Config = ScopeConfig

    def run(
        self, config: ScopeConfig, work: Path, *, workers: int = 1, progress: Progress = silent
    ) -> Any:
        """The options beside the whole pile, by question, and the steps that balance."""
        from steadyload.studies.scope.study import OPTIONS, ScopeOptions, run_scope

        asked = ScopeOptions(
            config.benchmark,
            config.most_items,
            config.cases,
            config.standing_cases,
            config.seconds,
            config.methods or OPTIONS,
        )
        return run_scope(asked, work, workers=workers, progress=progress)

    def page(self, result: Any) -> Any:
        """The page of verdicts that change and of cost that is saved."""
        from steadyload.studies.scope.page import scope_page

        return scope_page(result)


STUDY = ScopeStudy()
