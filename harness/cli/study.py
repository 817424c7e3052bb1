"""``steadyload study run`` and ``study report``: compare methods, and the page of that."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from steadyload.cli.flags import UsageError
from steadyload.cli.interrupts import working
from steadyload.cli.reading import SOME_REFUSED, ReadingFlags, Strict, say_refused
from steadyload.cli.studies import write
from steadyload.cli.terminal import progress_bar, resumable, say
from steadyload.config import REQUIRED, operand, option, output_option
from steadyload.studies.report.study import RunReport


@dataclass(frozen=True, kw_only=True)
class Run(Strict, ReadingFlags):
    """A study file, the workers, and how the study's files are read."""

    study: str = operand(
        REQUIRED, "a study file, or the word 'embedded': a slice of the shipped labelled set",
        metavar="STUDY.toml",
    )  # fmt: skip
    output: Path | None = output_option(None, "default: runs/NAME", metavar="DIR")
    workers: int | None = option(
        None, "processes that judge, or workers of a Dask cluster on this machine (default: one a "
        "core)", names=("--workers", "-j"), least=1,
    )  # fmt: skip
    executor: str = option(
        "processes",
        "where to judge: in this process, in others beside it, or on a Dask cluster (default: "
        "processes)", choices="steadyload.runs.pool:EXECUTORS",
    )  # fmt: skip
    scheduler: str | None = option(
        None, "of the Dask cluster, such as tcp://10.0.0.1:8786 (default: one on this machine)",
        metavar="ADDRESS",
    )  # fmt: skip
    rerun: bool = option(False, "compute everything anew")
    resume: bool = option(
        False, "go on with a run; wrong where there is none (default: go on or begin)"
    )

    def __post_init__(self) -> None:
        if self.rerun and self.resume:
            raise UsageError("--resume: not allowed with --rerun")

    def run(self) -> int:
        """Judge the missing cases."""
        from steadyload.layouts.files.refusals import Refusals
        from steadyload.runs.definition import load_study
        from steadyload.runs.envelope_use import study_warnings
        from steadyload.runs.pool import make_executor
        from steadyload.runs.results import load_manifest
        from steadyload.runs.runner import run_study

        working()
        study = load_study(self.study)
        study = replace(study, strict=self.strict or study.strict, **self.reading(study.dialect))
        directory = self.output or Path("runs") / study.name
        told = {"workers": self.workers, "scheduler": self.scheduler}
        with (
            make_executor(self.executor, **told) as executor,
            resumable(directory),
            progress_bar("judging") as advance,
        ):
            computed = run_study(
                study,
                directory,
                workers=executor,
                rerun=self.rerun,
                resume=self.resume,
                progress=advance,
            )
        manifest = load_manifest(directory)
        refused = Refusals.restated(manifest.get("refused"))
        say_refused(refused, manifest["layouts"])
        for warning in study_warnings(manifest["envelope"]):
            say(warning)
        print(f"{computed} rows computed; results in {directory}")
        return SOME_REFUSED if refused.count else 0


@dataclass(frozen=True, kw_only=True)
class Report:
    """A run, and where its page is written."""

    directory: Path = operand(REQUIRED, "folder of a study's run", metavar="DIR")
    output: Path | None = output_option(
        None, "folder of the page (default: the study's)", metavar="DIR"
    )

    def run(self) -> None:
        """Write the page of the run."""
        folder = self.directory
        write(RunReport(directory=folder), folder, self.output or folder, 1)
