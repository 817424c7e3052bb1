"""``steadyload properties``: tests of the properties of methods; fails on a violation."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from steadyload.cli.config_file import config_option
from steadyload.cli.studies import configuration, output_option, work_option, workers_option
from steadyload.cli.terminal import resumable, say, study_progress
from steadyload.studies.properties.config import STUDY, PropertiesConfig


@dataclass(frozen=True, kw_only=True)
class Properties(PropertiesConfig):
    """The study, and where its results and counterexamples lie."""

    output: Path = output_option(STUDY.work)
    work: Path | None = work_option(None, "the results", "--output")
    workers: int = workers_option(0)
    config: Path | None = config_option()

    def run(self) -> int:
        """Test, write the page, and print the violations."""
        from steadyload.reports.pages.writing import write_page
        from steadyload.studies.properties.page import refusals, violations

        config, work = configuration(PropertiesConfig, self), self.work or self.output
        with resumable(work), study_progress() as progress:
            result = STUDY.run_beside(
                config, work, self.output, workers=self.workers, progress=progress
            )
        print(write_page(STUDY.page(result), self.output))
        rows = result[0].rows
        for spec, (refused, tried) in refusals(rows).items():
            say(f"{spec}: not asked on {refused} of {tried} cases, which lie outside its range")
        violated = violations(rows)
        for row in violated:
            found = row.smallest.found if row.smallest else row.why
            say(f"{row.property}, {row.method.spec}: {found}")
        return 1 if violated else 0
