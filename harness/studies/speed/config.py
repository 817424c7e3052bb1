"""Configuration of the benchmark."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.config import methods_option, option
from steadyload.progress import NamedProgress, silent
from steadyload.studies.study import PublishedPage, Study

METHODS = ("fbs", "pbs0.7", "sme", "equilibrium", "equilibrium:time=0.3")
"""Methods that are measured by default."""

_FEW = 10


@dataclass(frozen=True)
class SpeedConfig:
    """Methods, layouts, and how much is measured."""

    methods: tuple[str, ...] = methods_option(
        f"measure only this; may be repeated (default: {', '.join(METHODS)})"
    )
    layouts: tuple[Path, ...] = option(
        (), "measure on the layouts of this file, too; may be repeated", metavar="FILE"
    )
    quick: bool = option(False, "few layouts and repeats, up to 50 items: seconds")
    last: bool = option(
        False, "make the page of the last run once more; measures where there is none"
    )


class Speed(Study[SpeedConfig, Any]):
    """Cost of a judgement: one by one, in batches, in sessions, and by number of items."""

    name = "speed"
    question = "What does a judgement cost, and how does that grow with the number of items?"
    about = "measure what judgements cost"
    command = "bench"
    folder = "bench"
    Config = SpeedConfig
    resumable = False
    workers = None
    published = (PublishedPage("speed", "--last --layouts ../shared/data/pallets/pallets.json"),)

    def run(
        self, config: SpeedConfig, work: Path, *, workers: int = 1, progress: NamedProgress = silent
    ) -> Any:
        """The run, which is kept in ``work``, or the last one that was."""
        from steadyload.studies.speed.kept import keep, last_run
        from steadyload.studies.speed.scenes import cases_of, check_names, labelled_cases
        from steadyload.studies.speed.study import FULL, QUICK, speed_run

        last = last_run(work) if config.last else None
        if last is not None:
            return last
        limit = _FEW if config.quick else None
        sets = [labelled_cases(limit), *(cases_of(path, limit) for path in config.layouts)]
        check_names(sets)
        extent = QUICK if config.quick else FULL
        found = speed_run(config.methods or METHODS, sets, extent, progress)
        keep(found, work)
        return found

    def page(self, result: Any) -> Any:
        """The page of costs and growth."""
        from steadyload.studies.speed.page import speed_page

        return speed_page(result)


STUDY = Speed()
