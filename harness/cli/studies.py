"""The command of a study: its options, folders and workers in, the path of its page out."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

from steadyload.cli.config_file import FIELD, config_option
from steadyload.cli.terminal import resumable, say, study_progress
from steadyload.config import option
from steadyload.studies.kit import Lab
from steadyload.studies.registry import AnyStudy

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


def study_command(study: AnyStudy) -> type[Any]:
    """The command of a study, made of its options."""
    config = study if isinstance(study, type) else study.Config
    fields = [*_options(config), *_places(study), (FIELD, Path | None, config_option())]

    def check(command: Any) -> None:
        configuration(config, command)

    def run(command: Any) -> int:
        work = command.work if study.resumable else command.output
        workers = command.workers if study.workers is not None else 1
        return write(study, configuration(config, command), work, command.output or work, workers)

    return dataclasses.make_dataclass(
        study.name, fields, namespace={"__post_init__": check, "run": run},
        frozen=True, kw_only=True,
    )  # fmt: skip


def _options(config: type) -> Iterator[tuple[str, Any, Any]]:
    """Name, type and field of every option of a configuration."""
    hints = get_type_hints(config)
    for one in dataclasses.fields(config):
        if one.default_factory is not dataclasses.MISSING:
            made = dataclasses.field(default_factory=one.default_factory, metadata=one.metadata)
        else:
            made = dataclasses.field(default=one.default, metadata=one.metadata)
        yield one.name, hints[one.name], made


def _places(study: AnyStudy) -> Iterator[tuple[str, Any, Any]]:
    """Options of the folders and the workers of a study."""
    if study.resumable:
        yield "work", Path, work_option(study.work)
        yield "output", Path | None, output_option()
    else:
        yield "output", Path, output_option(study.work)
    if study.workers is not None:
        yield "workers", int, workers_option(study.workers)


def write(study: AnyStudy, config: Any, work: Path, output: Path, workers: int) -> int:
    """Run a study, write its page, and print what it says of that; the exit status.

    Args:
        study: in either form.
        config: its configuration; of a class an object of it.
        work: folder of what is judged.
        output: folder of the page.
        workers: processes that judge.
    """
    from steadyload.reports.pages.writing import write_page

    with ExitStack() as stack:
        if study.resumable:
            stack.enter_context(resumable(work))
        progress = stack.enter_context(study_progress())
        if isinstance(study, type):
            found = config.run(Lab(work, workers, progress))
        else:
            found = study.run(config, work, workers=workers, progress=progress)
    if not isinstance(study, type):
        print(write_page(study.page(found), output))
        return 0
    config.beside(found, output)
    print(config.printed(found, write_page(config.page(found), output)))
    for remark in config.remarks(found):
        say(remark)
    return int(config.status(found))
