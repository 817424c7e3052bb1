"""``steadyload study table5``: the paper's Table 5 for every engine, and its page."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from steadyload.cli.config_file import config_option
from steadyload.cli.studies import configuration, output_option, work_option
from steadyload.cli.terminal import progress_bar, resumable, say, study_progress
from steadyload.config import option
from steadyload.studies.table5.study import STUDY, Table5Config


@dataclass(frozen=True, kw_only=True)
class Table5(Table5Config):
    """The study, and pages that play some of its cases."""

    work: Path = work_option(STUDY.work, "what is judged and timed")
    output: Path | None = output_option()
    workers: int | None = option(
        None, "processes that judge; timing always has one (default: one a core)",
        names=("--workers", "-j"), least=1,
    )  # fmt: skip
    views: int = option(
        0, "write pages that play N of the cases that divide the methods, and link them "
        "(default: 0)", least=0,
    )  # fmt: skip
    config: Path | None = config_option()

    def run(self) -> None:
        """Judge, time, and write the pages."""
        from steadyload.reports.pages.writing import write_page
        from steadyload.reports.viewer.three_js import three_js
        from steadyload.runs.pool import all_cores
        from steadyload.studies.table5.views import with_views

        config = configuration(Table5Config, self)
        asked = config.options()
        if self.views:
            three_js()  # so that a missing package is reported before hours of work
        for spec, why in asked.left_out.items():
            say(f"{spec} is left out: {why}")
        workers = self.workers or all_cores()
        with resumable(self.work), study_progress() as progress:
            found = STUDY.run(config, self.work, workers=workers, progress=progress)
        output = self.output or self.work
        with progress_bar("views") as advance:
            found = with_views(found, output, self.views, progress=advance)
        print(write_page(STUDY.page(found), output))
