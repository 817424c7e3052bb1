"""The command of a study: its options, folders and workers in, the path of its page out."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any, get_type_hints

from steadyload.cli.flags import CONFIG
from steadyload.cli.terminal import resumable, say, study_progress
from steadyload.config import option, output_option
from steadyload.runs.kept_only import results_made
from steadyload.studies.kit import Lab, Study
from steadyload.studies.registry import AnyStudy

_CORES = os.cpu_count() or 1
_ABOUT_CONFIG = (
    "TOML file whose keys are flags of this command, with underscores; flags override it"
)


def page_option(folder: Path | None = None) -> Any:
    """Option of the folder of the page; without a default it is the work folder."""
    about = f"folder of the page (default: {folder or '--work'})"
    return output_option(folder, about, metavar="DIR")


def workers_option(workers: int | None) -> Any:
    """Option of the number of processes that judge, with its default; 0 for one a core."""
    return option(
        workers or _CORES, f"default: {workers or 'all cores'}", names=("--workers", "-j"), least=1
    )


def _configured(study: AnyStudy, command: Any) -> Study[Any]:
    """A study with its options of a command."""
    return study(**{one.name: getattr(command, one.name) for one in dataclasses.fields(study)})  # type: ignore[arg-type]


def study_command(study: AnyStudy) -> type[Any]:
    """The command of a study, made of its options."""
    fields = [*_options(study), *_places(study), (CONFIG, Path | None, option(None, _ABOUT_CONFIG))]

    def check(command: Any) -> None:
        _configured(study, command)

    def run(command: Any) -> int:
        work = command.work if study.resumable else command.output
        workers = command.workers if study.workers is not None else 1
        before = results_made()
        ended = write(_configured(study, command), work, command.output or work, workers)
        if study.resumable and work.is_dir():
            from steadyload.studies.kept_rows import made_with, state_made

            if results_made() > before or made_with(work) is None:
                state_made(work)
        return ended

    return dataclasses.make_dataclass(
        study.name, fields, namespace={"__post_init__": check, "run": run},
        frozen=True, kw_only=True,
    )  # fmt: skip


def _options(study: AnyStudy) -> Iterator[tuple[str, Any, Any]]:
    """Name, type and field of every option of a study."""
    hints = get_type_hints(study)
    for one in dataclasses.fields(study):  # type: ignore[arg-type]
        if one.default_factory is not dataclasses.MISSING:
            made = dataclasses.field(default_factory=one.default_factory, metadata=one.metadata)
        else:
            made = dataclasses.field(default=one.default, metadata=one.metadata)
        yield one.name, hints[one.name], made


def _places(study: AnyStudy) -> Iterator[tuple[str, Any, Any]]:
    """Options of the folders and the workers of a study."""
    if study.resumable:
        about = f"folder of what is judged; an interrupted run goes on (default: {study.work})"
        yield "work", Path, option(study.work, about, metavar="DIR")
        yield "output", Path | None, page_option()
    else:
        yield "output", Path, page_option(study.work)
    if study.workers is not None:
        yield "workers", int, workers_option(study.workers)


def write(study: Study[Any], work: Path, output: Path, workers: int) -> int:
    """Run a study, write its page, and print what it says of that; the exit status.

    Args:
        study: with its options.
        work: folder of what is judged.
        output: folder of the page.
        workers: processes that judge.

    Raises:
        OSError: the page could not be written, which is known before anything is judged.
    """
    from steadyload.reports.pages.writing import check_folder, write_page

    check_folder(output)
    with ExitStack() as stack:
        if study.resumable:
            stack.enter_context(resumable(work))
        progress = stack.enter_context(study_progress())
        found = study.run(Lab(work, workers, progress))
    study.beside(found, output)
    print(study.printed(found, write_page(study.page(found), output)))
    for remark in study.remarks(found):
        say(remark)
    return study.status(found)
