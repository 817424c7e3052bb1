"""The command of a study: its configuration, folders and workers in, the path of its page out."""

from __future__ import annotations

import dataclasses
import os
from contextlib import ExitStack
from pathlib import Path
from typing import Any, TypeVar

from steadyload.cli.config_file import FIELD, config_option
from steadyload.cli.terminal import resumable, study_progress
from steadyload.config import option
from steadyload.studies.study import Study

C = TypeVar("C")

_CORES = os.cpu_count() or 1


def output_option(folder: Path | None = None) -> Any:
    """Option of the folder of the page; without a default it is the work folder."""
    return option(
        folder, f"folder of the page (default: {folder or '--work'})", names=("--output", "-o"),
        metavar="DIR",
    )  # fmt: skip


def work_option(folder: Path | None, what: str = "what is judged", default: str = "") -> Any:
    """Option of the work folder, from which an interrupted run is resumed."""
    return option(
        folder, f"folder of {what}; an interrupted run goes on (default: {default or folder})",
        metavar="DIR",
    )  # fmt: skip


def workers_option(workers: int | None) -> Any:
    """Option of the number of processes that judge, with its default; 0 for one a core."""
    return option(
        workers or _CORES, f"default: {workers or 'all cores'}", names=("--workers", "-j"), least=1
    )


def configuration(config: type[C], command: Any) -> C:
    """The part of a command that is a study's configuration."""
    names = [field.name for field in dataclasses.fields(config) if field.init]  # type: ignore[arg-type]
    return config(**{name: getattr(command, name) for name in names})


def study_command(study: Study[Any, Any]) -> type[Any]:
    """The command of a study, made of its configuration."""
    fields: list[tuple[str, Any, Any]] = []
    if study.resumable:
        fields.append(("work", Path, work_option(study.work)))
        fields.append(("output", Path | None, output_option()))
    else:
        fields.append(("output", Path, output_option(study.work)))
    if study.workers is not None:
        fields.append(("workers", int, workers_option(study.workers)))

    fields.append((FIELD, Path | None, config_option()))

    def run(command: Any) -> None:
        work = command.work if study.resumable else command.output
        workers = command.workers if study.workers is not None else 1
        write(study, configuration(study.Config, command), work, command.output or work, workers)

    return dataclasses.make_dataclass(
        type(study).__name__, fields, bases=(study.Config,), namespace={"run": run},
        frozen=True, kw_only=True,
    )  # fmt: skip


def write(study: Study[C, Any], config: C, work: Path, output: Path, workers: int) -> None:
    """Run a study, write its page, and print the path of that."""
    from steadyload.reports.writing import write_page

    with ExitStack() as stack:
        if study.resumable:
            stack.enter_context(resumable(work))
        progress = stack.enter_context(study_progress())
        result = study.run(config, work, workers=workers, progress=progress)
    print(write_page(study.page(result), output))
