"""Configuration of the study of transport."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.config import option
from steadyload.progress import NamedProgress, silent
from steadyload.studies.study import Study


@dataclass(frozen=True)
class TransportConfig:
    """How many loads, in how many directions, on which engines."""

    loads: int = option(200, "loads of real size (default: 200)", least=1)
    small: int = option(60, "loads of at most 20 boxes (default: 60)", least=1)
    referenced: int = option(
        100, "loads of real size, those of fewest boxes, that the reference is asked of as well "
        "(default: 100; a load takes it a minute or several)", least=0,
    )  # fmt: skip
    directions: int = option(8, "directions around a load (default: 8)", least=1, most=360)
    engines: tuple[str, ...] = option(
        (), "engine for the loads of real size; may be repeated (default: those whose tuned "
        "simulation no cheaper one beats on the largest loads that recommend knows; small loads "
        "are asked of all)", names=("--engine",), metavar="NAME",
    )  # fmt: skip


class TransportStudy(Study[TransportConfig, Any]):
    """Limits of loads by statics, rule of thumb and simulation, beside the reference's."""

    name = "transport"
    question = "What acceleration does a complete load hold, and which method finds it?"
    about = "compare limits of acceleration by equilibrium, engines and the reference, and why"
    command = "compare-limits"
    Config = TransportConfig

    def run(
        self,
        config: TransportConfig,
        work: Path,
        *,
        workers: int = 1,
        progress: NamedProgress = silent,
    ) -> Any:
        """The arguments of the page, in its order."""
        from steadyload.runs.provenance import provenance_lines
        from steadyload.studies.transport.study import limits_of_loads
        from steadyload.studies.transport.summary import summarise

        made_with = provenance_lines()
        found = limits_of_loads(**vars(config), work=work, workers=workers, progress=progress)
        return summarise(found), made_with

    def page(self, result: Any) -> Any:
        """The page of limits, of their distance from the reference's, and of what they hang on."""
        from steadyload.studies.transport.page import transport_page

        return transport_page(*result)


STUDY = TransportStudy()
