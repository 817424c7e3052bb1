"""Configuration of the study of engines."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.config import option
from steadyload.progress import NamedProgress, silent
from steadyload.studies.study import PublishedPage, Study

PARTS = ("sources", "agreement", "options", "speed", "throughput")
_SEED = 7


@dataclass(frozen=True)
class EnginesConfig:
    """Parts of the comparison, and how much is measured."""

    parts: tuple[str, ...] = option(
        (), "measure only this; may be repeated (default: speed and throughput)",
        names=("--part",), choices=PARTS,
    )  # fmt: skip
    layouts: int = option(
        300, "generated layouts for agreement and options (default: 300)", least=1
    )
    cases: int = option(
        100, "cases a scenario of part test for sources, on the set of many lists (default: 100)",
        least=2,
    )  # fmt: skip
    real_cases: int = option(
        0, "the same of the set of real size, where DART takes 20 s a case (default: 0, none)",
        least=0,
    )  # fmt: skip
    most_items: int = option(
        200, "largest layout of the speed part (default: 200)", least=20, metavar="J"
    )


class EngineStudy(Study[EnginesConfig, Any]):
    """One loading algorithm, equal values, every engine; what is timed is timed in one process."""

    name = "engines"
    question = "Do engines agree, what does each option change, and what does a simulation cost?"
    about = "compare engines: agreement, options, speed"
    command = "compare-engines"
    Config = EnginesConfig
    published = (
        PublishedPage(
            "engines",
            "--part sources --real-cases 20 --part agreement --part options --part speed "
            "--part throughput",
        ),
    )

    def run(
        self,
        config: EnginesConfig,
        work: Path,
        *,
        workers: int = 1,
        progress: NamedProgress = silent,
    ) -> Any:
        """The arguments of the page, in its order."""
        from steadyload.layouts.benchmark.dataset import LISTS, REAL
        from steadyload.runs.provenance import provenance_lines
        from steadyload.studies.engines.sources import sources_of_differences
        from steadyload.studies.engines.speed import ITEM_COUNTS, speed_curves, throughput
        from steadyload.studies.engines.study import Drawn, engine_agreement, option_effects

        parts = config.parts or ("speed", "throughput")
        made_with = provenance_lines()  # of the code that measures
        drawn = Drawn(config.layouts, _SEED)
        judging: dict[str, Any] = {"workers": workers, "progress": progress}
        counts = [n for n in ITEM_COUNTS if n <= config.most_items]
        return (
            engine_agreement(drawn, work, **judging) if "agreement" in parts else [],
            option_effects(drawn, work, **judging) if "options" in parts else [],
            speed_curves(work / "speed", counts, progress=progress) if "speed" in parts else [],
            throughput(work / "throughput", progress=progress) if "throughput" in parts else [],
            sources_of_differences(
                {LISTS: config.cases} | ({REAL: config.real_cases} if config.real_cases else {}),
                work / "sources",
                **judging,
            )
            if "sources" in parts
            else [],
            {"generated layouts": f"{config.layouts}, seed {_SEED}"} | made_with,
        )

    def page(self, result: Any) -> Any:
        """The page of agreement, options and speed, as far as they were measured."""
        from steadyload.studies.engines.page import engine_study_page

        return engine_study_page(*result)


STUDY = EngineStudy()
