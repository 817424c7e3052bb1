"""Configuration of the study of uncertain verdicts."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.config import methods_option, option
from steadyload.progress import NamedProgress, silent
from steadyload.studies.study import Study


@dataclass(frozen=True)
class UncertainConfig:
    """Deviations, methods and numbers of cases; None for the defaults."""

    uncertain: str | None = option(
        None, "what deviates (default: com=5mm,position=3mm)", metavar="WHAT"
    )
    methods: tuple[str, ...] = methods_option(
        "may be repeated (default: a rule, the equilibrium with time, a network, an engine)"
    )
    cases: int | None = option(
        None, "a scenario, for methods without an engine (default: 100)", least=1
    )
    engine_cases: int | None = option(
        None, "a scenario, for methods with one (default: 20)", least=1
    )
    checked: int | None = option(
        None, "layouts that are held against many random samples (default: 50)", least=0
    )


class Uncertain(Study[UncertainConfig, Any]):
    """The reliability of verdicts on loads that deviate from their plans."""

    name = "uncertain"
    question = "How sure is a verdict when a load deviates from its plan?"
    about = "how sure verdicts on labelled cases are: accuracy, probability, cost"
    Config = UncertainConfig

    def run(
        self,
        config: UncertainConfig,
        work: Path,
        *,
        workers: int = 1,
        progress: NamedProgress = silent,
    ) -> Any:
        """The summary of the samples, and provenance."""
        from steadyload.runs.provenance import provenance_lines
        from steadyload.studies.uncertain.sampling import UncertainOptions, run_uncertain
        from steadyload.studies.uncertain.summary import summarise

        made_with = provenance_lines()  # of the code at the time of sampling
        given: dict[str, Any] = {
            "uncertainty": config.uncertain,
            "methods": tuple(dict.fromkeys(config.methods)) or None,
            "cases": config.cases,
            "engine_cases": config.engine_cases,
            "checked": config.checked,
        }
        asked = UncertainOptions(
            **{key: value for key, value in given.items() if value is not None}
        )
        sampled = run_uncertain(
            asked, work, workers=workers, progress=lambda *of: progress("sampling", *of)
        )
        return summarise(asked, sampled), made_with

    def page(self, result: Any) -> Any:
        """The page of accuracy, probabilities and their cost."""
        from steadyload.studies.uncertain.page import uncertain_page

        return uncertain_page(*result)


STUDY = Uncertain()
