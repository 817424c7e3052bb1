"""``steadyload pages``: list, remake and index the published pages."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from contextlib import ExitStack, nullcontext
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

from steadyload.atomic import write_atomically
from steadyload.cli.interrupts import working
from steadyload.cli.running import run
from steadyload.cli.terminal import print_table, say
from steadyload.config import REQUIRED, operand, option, output_option
from steadyload.errors import UserError
from steadyload.escaping import printable
from steadyload.studies.published import (
    FOLDER,
    INDEX,
    ROWS,
    Entry,
    entries,
    named,
    remaking,
    write_index,
)


def _folder() -> Any:
    return output_option(FOLDER, f"folder of the pages (default: {FOLDER})", metavar="DIR")


@dataclass(frozen=True)
class List:
    """Where the pages lie."""

    output: Path = _folder()

    def run(self) -> None:
        """Print them."""
        print_table(
            ("page", "made", "answers", "command"),
            [
                (
                    entry.name,
                    "yes" if entry.text(self.output) else "no",
                    entry.answers,
                    f"steadyload {shlex.join(entry.command)}",
                )
                for entry in entries()
            ],
        )


def _rows() -> Any:
    return option(ROWS, f"folder of the packed rows (default: {ROWS})", metavar="DIR")


@dataclass(frozen=True)
class Remake:
    """Which pages, and where they and the rows behind them lie."""

    names: tuple[str, ...] = operand((), "only these (default: all)", metavar="PAGE")
    output: Path = _folder()
    rows: Path = _rows()
    judge: bool = option(False, "judge, measure and time what is not among the kept rows")
    keep: bool = option(False, "pack the rows of every page that was remade, for the next time")
    dry_run: bool = option(False, "print the commands, and run none")

    def run(self) -> int:
        """Remake the pages, and write the index where one was remade.

        Rows that are packed are unpacked first, unless their work folder is there already, which is
        said. A page with kept rows is made of these alone, whichever engines are installed, or is
        refused before anything is written; with ``judge`` of what is missing, too, which is refused
        where an engine of the rows is not installed. Returns the first exit status that is not 0;
        the other pages are remade nevertheless.
        """
        working()
        if self.dry_run:
            for entry in named(self.names):
                print(f"steadyload {shlex.join(remaking(entry, self.output))}")
            return 0
        status, remade = 0, False
        for work, pages in groupby(named(self.names), key=lambda entry: entry.work):
            made = []
            together = list(pages)
            self._tell_unread(together[0])
            for entry in together:
                ended = self._remake(entry)
                status = status or ended
                made += [] if ended else [entry]
            if self.keep and made and work.is_dir():
                _kept(made[:1], self.rows)
            remade = remade or bool(made)
        if remade:
            print(write_index(self.output))
        return status

    def _tell_unread(self, entry: Entry) -> None:
        """Say that the packed rows of a page are not read, where its work folder is there."""
        from steadyload.studies.kept_rows import archive_of

        archive = archive_of(entry, self.rows)
        if entry.work.exists() and archive.exists():
            say(printable(f"uses the rows in {entry.work}; {archive} is not unpacked over them"))

    def _remake(self, entry: Entry) -> int:
        """Run the command of a page; its exit status."""
        try:
            made_of_rows = self._made_of_rows(entry)
        except UserError as error:
            say(f"steadyload: {printable(str(error))}")
            return 2
        with made_of_rows:
            words = remaking(entry, self.output)
            say(f"steadyload {shlex.join(words)}")
            return run(words)

    def _made_of_rows(self, entry: Entry) -> ExitStack:
        """Unpack the rows of a page unless they are there; a context that makes it of them alone.

        Raises:
            RowsError: the archive cannot be unpacked.
            UserError: something is to be judged, and an engine of the rows is not installed.
        """
        from steadyload.engines.registry import engines, engines_here
        from steadyload.runs.kept_only import kept_only
        from steadyload.runs.provenance import of_rows
        from steadyload.studies.kept_rows import made_with, unpack

        unpack(entry, self.rows)
        context = ExitStack()
        if not entry.work.exists():
            return context
        made, here = made_with(entry.work), set(engines_here())
        unknown = set(made.engines if made else ()) - engines().keys()
        with of_rows(made) if made else nullcontext():
            theirs = set(engines_here()) | unknown
        if self.judge:
            if theirs - here:
                raise UserError(
                    f"page {entry.name!r} has kept rows of {', '.join(sorted(theirs - here))}, not "
                    "installed here; without --judge it is made of what is kept"
                )
            return context
        remedy = f"steadyload pages remake {entry.name} --judge judges and times them here"
        context.enter_context(kept_only(remedy))
        for name in sorted(here - theirs):
            say(f"page {entry.name!r} has no kept rows of {name}; {remedy}")
        for name in sorted(unknown):
            say(f"page {entry.name!r} is made without its rows of {name}, an unknown engine")
        if made:
            context.enter_context(of_rows(made))
        return context


@dataclass(frozen=True)
class Keep:
    """Which pages, and where their rows are packed."""

    names: tuple[str, ...] = operand(REQUIRED, "pages", metavar="PAGE")
    rows: Path = _rows()

    def run(self) -> None:
        """Pack the rows of pages, and write what is kept beside them."""
        _kept(named(self.names), self.rows)


def _kept(pages: Sequence[Entry], rows: Path) -> None:
    from steadyload.studies.kept_rows import keep, kept

    for entry in pages:
        print(keep(entry, rows))
    write_atomically(rows / INDEX, kept(rows).encode())


@dataclass(frozen=True)
class Index:
    """Where the pages lie."""

    output: Path = _folder()

    def run(self) -> None:
        """Write the index."""
        print(write_index(self.output))
