"""What the command's parts share: numbers in, tables and progress out."""

from __future__ import annotations

import argparse
import logging
import math
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table


def at_least(least: int) -> Callable[[str], int]:
    """A type for an argument: whole numbers from ``least`` on."""

    def whole(text: str) -> int:
        if not (text.isascii() and text.isdigit() and int(text) >= least):
            raise argparse.ArgumentTypeError(f"{text!r}; allowed: a whole number, {least} or more")
        return int(text)

    return whole


def positive_number(text: str) -> float:
    """A type for an argument: numbers above 0."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < 1e9:
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: a number above 0")
    return value


_SECONDS = {"s": 1.0, "m": 60.0, "h": 3600.0}


def duration(text: str) -> float:
    """A type for an argument: seconds, from ``90``, ``90s``, ``20m`` or ``1.5h``."""
    match = re.fullmatch(r"(\d+(?:\.\d+)?)([smh]?)", text)
    if match is None or not float(match[1]):
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: a time such as 90s, 20m or 1.5h")
    return float(match[1]) * _SECONDS[match[2] or "s"]


_errors = Console(stderr=True, soft_wrap=True, highlight=False, markup=False)


def say(sentence: str) -> None:
    """Tell the user something on stderr, where no pipe reads it."""
    _errors.print(sentence)


class _Sentences(logging.Handler):
    """Says what the library warns of."""

    def emit(self, record: logging.LogRecord) -> None:
        say(f"steadyload: {record.getMessage()}")


def say_warnings() -> None:
    """From now on tell the user what the library warns of, such as a file that is damaged."""
    log = logging.getLogger("steadyload")
    if not any(isinstance(handler, _Sentences) for handler in log.handlers):
        log.addHandler(_Sentences(logging.WARNING))


@contextmanager
def resumable(where: Path) -> Iterator[None]:
    """Work whose interruption loses nothing: says so, where what is finished stays."""
    try:
        yield
    except KeyboardInterrupt:
        say(f"What is finished stays in {where}; run the same command to go on.")
        raise


def print_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table on stdout, for people and for pipes."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for title in header:
        table.add_column(title, overflow="fold")
    for row in rows:
        table.add_row(*row)
    # A pipe has no width: never cut what a program reads.
    console = Console(highlight=False, markup=False, width=None if sys.stdout.isatty() else 4000)
    with console.capture() as capture:
        console.print(table)
    print("\n".join(line.rstrip() for line in capture.get().splitlines()))


@contextmanager
def progress_bar(label: str) -> Iterator[Callable[[int, int], None]]:
    """A progress bar on stderr, shown only where somebody can see it."""
    console = Console(stderr=True)
    columns = (TextColumn(label), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as bar:
        task = bar.add_task(label, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


@contextmanager
def status_line() -> Iterator[Callable[[str], None]]:
    """A line on stderr that says what is being measured, where somebody can see it."""
    console = Console(stderr=True)
    with console.status("") as status:
        yield lambda what: status.update(what)
