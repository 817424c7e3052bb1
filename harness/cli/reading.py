"""Flags of commands that read layouts: dialect, gaps, deck, and what ends the command."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from steadyload.cli.flags import UsageError
from steadyload.cli.terminal import say
from steadyload.config import (
    REQUIRED,
    number_from_zero,
    operand,
    option,
    positive_number,
    stated,
)

if TYPE_CHECKING:
    from steadyload.layouts.files.dialect import Dialect
    from steadyload.layouts.files.refusals import Refusals

_WORDS = "steadyload.layouts.files.dialect:"


@dataclass(frozen=True, kw_only=True)
class ReadingFlags:
    """The dialect of CSV files, the gaps that are closed, and the deck.

    Single keys of the dialect override those of its profile.
    """

    profile: Path | None = option(
        None, "of CSV files: TOML file whose keys are the eight flags below, which override it"
    )
    units: str | None = option(None, "of lengths (default: cm)", choices=_WORDS + "UNITS")
    weight: str | None = option(None, "of boxes (default: kg)", choices=_WORDS + "WEIGHT_UNITS")
    up: str | None = option(None, "axis that points up (default: y)", choices=_WORDS + "UPWARD")
    positions: str | None = option(
        None, "point of a box that x, y and z give (default: corner)", choices=_WORDS + "POSITIONS"
    )
    columns: tuple[str, ...] = option(
        (), "names of columns, such as length=L,id=Artikel; may be repeated",
        metavar="WORD=COLUMN,...",
    )  # fmt: skip
    other_columns: str | None = option(
        None, "what to do with columns that are not known (default: refuse)",
        choices=_WORDS + "OTHER_COLUMNS",
    )  # fmt: skip
    order: str | None = option(
        None, "what the order of loading is read from: the column sequence, which counts from 0 "
        "(default: column) or from 1, or the order of the rows",
        choices=_WORDS + "ORDERS",
    )  # fmt: skip
    pallet: str | None = option(
        None, "sides of all pallets along the file's x, y and z, in its unit, where it has no "
        "columns of them", metavar="1200x800x1800",
    )  # fmt: skip

    snap: bool = option(False, "close small vertical gaps when reading (default: off)")
    snap_gap: float | None = option(
        None, "close gaps up to this; implies --snap (default: 0.5)", metavar="CM",
        read=positive_number,
    )  # fmt: skip
    overhang: float | None = option(
        None, "how far boxes may overhang the deck (default: as in the file, else 10)",
        metavar="CM", read=number_from_zero,
    )  # fmt: skip
    floor: str | None = option(
        None, "what boxes stand on: the deck, beyond whose edges nothing carries, an infinite "
        "plane, or the deck where a box overhangs it (default: as in the file, else auto)",
        choices="steadyload.layouts.model.floor:FloorKind",
    )  # fmt: skip

    def reading(self, base: Dialect | None = None) -> dict[str, Any]:
        """The choices that the flags state, and the dialect: arguments of whoever reads layouts.

        Args:
            base: the dialect that the flags change, where they name no profile; None for the
                default.

        Raises:
            DialectError: the profile or a name of a column is not allowed.
            OSError: the profile cannot be read.
        """
        from steadyload.layouts.model.floor import FloorKind
        from steadyload.layouts.model.snapping import SNAP_GAP

        return stated(
            dialect=self._dialect(base),
            snap_gap=self.snap_gap or (SNAP_GAP if self.snap else None),
            overhang=self.overhang,
            floor=None if self.floor is None else FloorKind(self.floor),
        )

    def _dialect(self, base: Dialect | None) -> Dialect:
        from steadyload.layouts.files.dialect import Dialect, columns_of, load_profile

        found = (base or Dialect()) if self.profile is None else load_profile(self.profile)
        keys = ("units", "weight", "up", "positions", "other_columns", "order", "pallet")
        changes = stated(**{key: getattr(self, key) for key in keys})
        if self.columns:
            changes["columns"] = columns_of(",".join(self.columns))
        return found.with_changes(changes)


@dataclass(frozen=True, kw_only=True)
class Files(ReadingFlags):
    """Files of layouts, and how they are read."""

    files: tuple[Path, ...] = operand(REQUIRED, "layouts; - reads standard input", metavar="FILE")


def say_refused(refused: Refusals, valid: int) -> None:
    """Print why layouts were refused, and how many of how many.

    Args:
        refused: those.
        valid: number of the others.
    """
    for sentence in refused.sentences(valid):
        say(f"steadyload: {sentence}")


def check_output(output: Path, inputs: Sequence[Path]) -> None:
    """Refuse to write over what is read.

    Raises:
        UsageError: the output is one of the inputs.
    """
    if output.exists() and any(file.exists() and output.samefile(file) for file in inputs):
        raise UsageError(f"--output: {str(output)!r} is read, too; allowed: another file")


SOME_REFUSED = 3
"""Exit status of a command that left out layouts because they are not valid."""


@dataclass(frozen=True, kw_only=True)
class Strict:
    """True if the first layout that is not valid ends the command."""

    strict: bool = option(
        False, "end with status 2 at the first layout that is not valid (default: report it, "
        "judge the others, and end with status 3)",
    )  # fmt: skip
