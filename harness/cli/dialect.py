"""Flags of commands that read layouts: the dialect of CSV files, and what ends the command."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from steadyload.studies.options import option

if TYPE_CHECKING:
    from steadyload.layouts.dialect import Dialect

_WORDS = "steadyload.layouts.dialect:"


@dataclass(frozen=True, kw_only=True)
class DialectFlags:
    """A profile of CSV files, and single keys of it, which override those of the profile."""

    profile: Path | None = option(
        None, "of CSV files: TOML file whose keys are the six flags below, which override it"
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

    def dialect(self, base: Dialect | None = None) -> Dialect:
        """The dialect of the flags.

        Args:
            base: that which the flags change, where they name no profile; None for the default.

        Raises:
            DialectError: the profile or a name of a column is not allowed.
            OSError: the profile cannot be read.
        """
        from steadyload.layouts.dialect import Dialect, columns_of, load_profile

        found = (base or Dialect()) if self.profile is None else load_profile(self.profile)
        keys = ("units", "weight", "up", "positions", "other_columns")
        changes = {key: getattr(self, key) for key in keys}
        changes["columns"] = columns_of(",".join(self.columns)) if self.columns else None
        return found.with_changes({k: v for k, v in changes.items() if v is not None})


SOME_REFUSED = 3
"""Exit status of a command that left out layouts because they are not valid."""


@dataclass(frozen=True, kw_only=True)
class Strict:
    """True if the first layout that is not valid ends the command."""

    strict: bool = option(
        False, "end with status 2 at the first layout that is not valid (default: report it, "
        "judge the others, and end with status 3)",
    )  # fmt: skip
