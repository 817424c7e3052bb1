"""Configuration of the study of layouts of real size."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.config import methods_option, option, positive_number, set_option
from steadyload.progress import NamedProgress, silent
from steadyload.studies.study import PublishedPage, Study


@dataclass(frozen=True)
class RealConfig:
    """Which methods, on which cases, and how long a judgement may take."""

    methods: tuple[str, ...] = methods_option(
        "may be repeated (default: rules, equilibrium, settling, tuned simulations, "
        "networks, the cascade)"
    )
    directory: str = set_option("real")
    timeout: float = option(
        20.0, "CPU seconds a judgement may take (default: 20)", metavar="S", read=positive_number
    )
    limit: int | None = option(None, "only the first N cases a scenario", least=1)
    small: int = option(
        60, "cases a scenario of the small layouts of the package, for comparison (default: 60)",
        least=0,
    )  # fmt: skip
    sizes: tuple[int, ...] = option(
        (), "largest numbers of boxes of the bins (default: 37 62 87 125 150)", fewest=1, least=1
    )
    pallets: int = option(
        60, "customers' pallets that are judged on several floors, too (default: 60)", least=0
    )


class Real(Study[RealConfig, Any]):
    """All methods on labelled layouts of real size, asked both questions."""

    name = "real"
    question = "Which method judges a pallet of real size, how right is it, and at what cost?"
    about = "all methods on labelled layouts of real size, by number of boxes"
    Config = RealConfig
    published = (PublishedPage("real", "--workers 1"),)

    def run(
        self, config: RealConfig, work: Path, *, workers: int = 1, progress: NamedProgress = silent
    ) -> Any:
        """The summary of what was judged, by question and number of boxes."""
        from steadyload.studies.real.study import RealStudyOptions, judge_real
        from steadyload.studies.real.summary import summarise

        asked = RealStudyOptions(**vars(config))
        judged = judge_real(
            asked, work, workers=workers, progress=lambda *of: progress("judging", *of)
        )
        return summarise(asked, judged)

    def page(self, result: Any) -> Any:
        """The page of accuracy and cost, by question and number of boxes."""
        from steadyload.studies.real.page import real_page

        return real_page(result)


STUDY = Real()
