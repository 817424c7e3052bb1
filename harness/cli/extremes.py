"""``steadyload extremes``: sweeps to the limits of numerical stability, and the envelopes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from steadyload.cli.config_file import config_option
from steadyload.cli.studies import configuration, output_option, work_option, workers_option
from steadyload.cli.terminal import study_progress
from steadyload.config import option
from steadyload.studies.extremes.config import STUDY, ExtremesConfig


@dataclass(frozen=True, kw_only=True)
class Extremes(ExtremesConfig):
    """The study, and whether it becomes the envelope from which studies warn."""

    work: Path = work_option(STUDY.work, "what is measured")
    output: Path | None = output_option()
    workers: int = workers_option(1)
    write_envelope: bool = option(
        False, "write what was held to the file from which studies warn; of all sweeps and "
        "frequencies only",
    )  # fmt: skip
    config: Path | None = config_option()

    def run(self) -> None:
        """Measure, write the page, and the envelope."""
        from steadyload.reports.pages.writing import write_page
        from steadyload.runs.definition import StudyError
        from steadyload.studies.extremes.summary import write_envelopes

        if self.write_envelope and (self.sweeps or self.frequencies):
            raise StudyError("--write-envelope is of all sweeps and frequencies; leave these out")
        config = configuration(ExtremesConfig, self)
        with study_progress() as progress:
            result = STUDY.run(config, self.work, workers=self.workers, progress=progress)
        print(write_page(STUDY.page(result), self.output or self.work))
        found, made_by = result
        if self.write_envelope:
            print(write_envelopes(found.envelope, found.rests, made_by))
