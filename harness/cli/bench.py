"""``steadyload bench``: what judgements cost."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from steadyload.cli.config_file import config_option
from steadyload.cli.studies import configuration, output_option
from steadyload.cli.terminal import study_progress
from steadyload.config import option
from steadyload.studies.speed.config import STUDY, SpeedConfig


@dataclass(frozen=True, kw_only=True)
class Bench(SpeedConfig):
    """The study, and in which form its figures are printed."""

    output: Path = output_option(STUDY.work)
    json: bool = option(False, "print the figures as one JSON object, in place of the page's path")
    config: Path | None = config_option()

    def run(self) -> None:
        """Measure, keep the figures, and write the page."""
        from steadyload.reports.pages.writing import write_page

        with study_progress() as progress:
            result = STUDY.run(configuration(SpeedConfig, self), self.output, progress=progress)
        page = write_page(STUDY.page(result), self.output)
        print(json.dumps(result.to_json(), indent=1) if self.json else page)
