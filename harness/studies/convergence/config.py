"""Configuration of the study of convergence."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.config import option
from steadyload.progress import NamedProgress as Progress
from steadyload.progress import silent
from steadyload.studies.study import PublishedPage, Study


@dataclass(frozen=True)
class ConvergenceConfig:
    """Number of layouts, and further methods to compare with."""

    layouts: int = option(900, "default: 900", least=1)
    sample: int = option(
        50, "layouts that slow judges are asked; 0 asks none (default: 50)", least=0
    )
    second_model: bool = option(False, "ask Drake, too (needs the extra `drake`)")


class ConvergenceStudy(Study[ConvergenceConfig, Any]):
    """The reference under other numerics and other models, and compared with other methods."""

    name = "convergence"
    question = "Are the reference's labels converged?"
    about = "change the reference one parameter at a time; ask other judges"
    command = "verify convergence"
    Config = ConvergenceConfig
    workers = 0
    published = (PublishedPage("convergence", "--second-model"),)

    def run(
        self,
        config: ConvergenceConfig,
        work: Path,
        *,
        workers: int = 1,
        progress: Progress = silent,
    ) -> Any:
        """The changes of labels, and provenance."""
        from steadyload.studies.convergence.study import (
            OPINIONS,
            SECOND_MODEL,
            made_with,
            run_convergence,
        )
        from steadyload.studies.convergence.summary import convergence

        results = run_convergence(
            work,
            layouts=config.layouts,
            sample=config.sample,
            opinions=(*OPINIONS, SECOND_MODEL) if config.second_model else OPINIONS,
            workers=workers,
            progress=lambda *of: progress("judging", *of),
        )
        return convergence(*results), made_with(work)

    def page(self, result: Any) -> Any:
        """The page of the shares of labels that change."""
        from steadyload.studies.convergence.page import convergence_page

        return convergence_page(*result)


STUDY = ConvergenceStudy()
