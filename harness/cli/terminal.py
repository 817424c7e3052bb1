"""Output that all commands share: sentences, tables and progress.

Rich is imported when something is shown, so that wrong flags are reported at once.
"""

from __future__ import annotations

import csv
import io
import logging
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from steadyload.cli.interrupts import is_behind, working
from steadyload.escaping import printable
from steadyload.progress import NamedProgress, Progress


def say(sentence: str) -> None:
    """Print a sentence on stderr, which is no part of the output."""
    from rich.console import Console

    lines = "\n".join(map(printable, sentence.split("\n")))
    Console(stderr=True, soft_wrap=True, highlight=False, markup=False).print(lines)


class _Sentences(logging.Handler):
    """Handler that prints what the library tells."""

    def emit(self, record: logging.LogRecord) -> None:
        say(f"steadyload: {record.getMessage()}")


def say_warnings() -> None:
    """Print all further warnings of the library, such as that a file is damaged, and that
    something is compiled, which takes a while.
    """
    log = logging.getLogger("steadyload")
    if not any(isinstance(handler, _Sentences) for handler in log.handlers):
        log.addHandler(_Sentences())
    logging.getLogger("steadyload.engines.reference.compilation").setLevel(logging.INFO)


@contextmanager
def resumable(where: Path) -> Iterator[None]:
    """Context of resumable work: the line of an interrupt says where finished results are kept."""
    working()
    try:
        yield
    except (KeyboardInterrupt, Exception) as error:
        if is_behind(error):
            kept = printable(str(where))
            error.add_note(f"what is finished stays in {kept}, and the same command goes on")
        raise


@contextmanager
def kept_status() -> Iterator[None]:
    """Context of output whose reader (head, less) may close the pipe; the status stays."""
    try:
        yield
        sys.stdout.flush()
    except BrokenPipeError:
        drop_output()


def drop_output() -> None:
    """Send all further output nowhere; Python must not report a closed pipe again at its exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


ROW, NAME = 80, 20
"""Characters of a row of a table at most, and of a name where what follows it is long."""

_FILE = 20
"""Characters of the name of a file in a table."""


def file_names(files: Sequence[str]) -> list[str]:
    """The file of every row as a table has it, by its end; none where all rows are of one."""
    from steadyload.layouts.files.sources import distinct_names

    names = {file: printable(name) for file, name in distinct_names(files).items()}
    if len(names) < 2:
        return []
    cut = {f: n if len(n) <= _FILE else f"...{n[3 - _FILE :]}" for f, n in names.items()}
    # Where that makes two the same, names are whole.
    return [(cut if len(set(cut.values())) == len(cut) else names)[file] for file in files]


def print_table(
    header: Sequence[str], rows: Sequence[Sequence[str]], files: Sequence[str] = ()
) -> None:
    """Print a table on stdout, for terminals and for pipes.

    Args:
        header: titles of the columns.
        rows: texts, one a column.
        files: of the rows, which are named where there are several; empty for none.
    """
    if names := file_names(files):
        header = ("file", *header)
        rows = [(name, *row) for name, row in zip(names, rows, strict=True)]
    cells = [tuple(map(printable, row)) for row in rows]
    # A pipe has no width: its text is never folded.
    print(_folded(header, cells) if sys.stdout.isatty() else _aligned([tuple(header), *cells]))


def _folded(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table as wide as the terminal."""
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold")
    for title in header:
        table.add_column(title, overflow="fold")
    for row in rows:
        table.add_row(*row)
    console = Console(highlight=False, markup=False)
    with console.capture() as capture:
        console.print(table)
    return "\n".join(line.rstrip() for line in capture.get().splitlines())


def _aligned(lines: Sequence[Sequence[str]]) -> str:
    """A table with a line a row, however long, in a hundredth of the time."""
    from rich.cells import cell_len

    lengths = [list(map(cell_len, line)) for line in lines]
    widths = [max(column) for column in zip(*lengths, strict=True)]
    return "\n".join(
        "  ".join(
            text + " " * (width - length)
            for text, width, length in zip(line, widths, own, strict=True)
        ).rstrip()
        for line, own in zip(lines, lengths, strict=True)
    )


def csv_text(records: Sequence[Mapping[str, Any]]) -> str:
    """Records as CSV, the keys of the first as the header; lists are texts with semicolons."""
    text = io.StringIO()
    if records:
        writer = csv.DictWriter(text, list(records[0]), lineterminator="\n")
        writer.writeheader()
        for record in records:
            writer.writerow({key: _cell(value) for key, value in record.items()})
    return text.getvalue()


def _cell(value: Any) -> Any:
    """A value; of a text one that no spreadsheet takes for a formula."""
    if isinstance(value, list):
        value = "; ".join(map(str, value))
    if not isinstance(value, str):
        return value
    return "'" * value.startswith(("=", "+", "-", "@")) + printable(value)


@contextmanager
def study_progress(*, shown: bool = True) -> Iterator[NamedProgress]:
    """A line of progress on stderr, shown in terminals only: the work, and the amount done.

    Args:
        shown: False where the terminal shows results as they come.
    """
    from rich import progress
    from rich.console import Console

    working()
    console = Console(stderr=True)
    columns = (
        progress.TextColumn("{task.description}", markup=False),
        progress.BarColumn(), progress.MofNCompleteColumn(), progress.TimeRemainingColumn(),
    )  # fmt: skip
    with progress.Progress(
        *columns, console=console, transient=True, disable=not (shown and console.is_terminal)
    ) as bar:
        task = bar.add_task("", total=None)

        def show(what: str, done: int = 0, total: int = 0, /) -> None:
            bar.update(task, description=printable(what), completed=done, total=total or None)

        yield show


@contextmanager
def progress_bar(label: str, *, shown: bool = True) -> Iterator[Progress]:
    """A progress bar on stderr, shown in terminals only; see :func:`study_progress`."""
    with study_progress(shown=shown) as show:
        show(label)
        yield lambda done, total: show(label, done, total)
