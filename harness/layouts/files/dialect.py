"""Dialect of a CSV file: units, axes, positions and names of columns, as a profile keeps them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from decimal import Decimal
from pathlib import Path
from typing import Any

from steadyload.config import bind, check, option, values_of
from steadyload.errors import UserError, nearest
from steadyload.layouts.files.limits import MAX_TEXT_LENGTH
from steadyload.layouts.files.record import shown
from steadyload.layouts.model.units import UNITS, WEIGHT_UNITS
from steadyload.reading import toml_of

UPWARD = ("y", "z")
"""Axes that may point up."""

POSITIONS = ("corner", "centre")
"""Points of a box whose place may be given."""

OTHER_COLUMNS = ("refuse", "ignore")
"""Ways to treat columns that are not known."""

ORDERS = ("column", "from-1", "rows")
"""Ways to tell the order of loading: a column that counts from 0, one from 1, the rows."""

PALLET_SIDES = ("pallet_length", "pallet_width", "pallet_height", "pallet_depth")
SIDES = ("length", "width", "height", "depth")
OFFSETS = ("offset_x", "offset_y", "offset_z")
LOADS = ("max_load", "max_load_per_m2")

WORDS = (
    "layout", *PALLET_SIDES, "sequence", "id", "x", "y", "z", *SIDES, "weight", *OFFSETS, *LOADS,
)  # fmt: skip
"""Columns for which a dialect may name others."""

_SIDES = " *[x*] *".join([r"(\d{1,9}(?:\.\d{1,9})?)"] * 3)


class DialectError(UserError):
    """A dialect or a profile that states what is not allowed."""


@dataclass(frozen=True, kw_only=True)
class Dialect:
    """Form of a CSV file. The separator of columns and the decimal mark are told by the file.

    Args:
        up: With ``z`` the file's x, y, z become our z, x, y, which turns the layout and does not
            mirror it.
        columns: the file's own names of columns, by the word of :data:`WORDS` that each stands for.
        order: ``from-1`` says that the column ``sequence`` counts from 1 and not from 0; ``rows``
            takes the order of a layout's rows for that of loading, where there is no such column.
        pallet: sides of all pallets along the file's x, y and z, in its unit, such as
            ``1200x800x1800``, where the file has no columns of them; empty for the columns.

    Raises:
        DialectError: a value is not allowed.
    """

    units: str = option("cm", "of lengths", choices=UNITS)
    weight: str = option("kg", "unit of weights", choices=WEIGHT_UNITS)
    up: str = option("y", "the axis that points up", choices=UPWARD)
    positions: str = option(
        "corner", "the point of a box whose x, y, z are given: its corner with the smallest "
        "coordinates, or its geometric centre", choices=POSITIONS,
    )  # fmt: skip
    columns: Mapping[str, str] = field(default_factory=dict)
    other_columns: str = option(
        "refuse", "what becomes of columns that are not known", choices=OTHER_COLUMNS
    )
    order: str = option("column", "what states the order of loading", choices=ORDERS)
    pallet: str = ""

    def __post_init__(self) -> None:
        check(self, "dialect", DialectError)
        object.__setattr__(self, "columns", _checked(self.columns))
        if self.pallet != "":
            sides_of(self.pallet)

    def __hash__(self) -> int:
        stated = {**self.stated(), "columns": tuple(sorted(self.columns.items()))}
        return hash(tuple(stated.items()))

    def stated(self) -> dict[str, Any]:
        """The keys that differ from those of the default, as a profile would hold them."""
        default, own = vars(Dialect()), vars(self)
        return {key: value for key, value in own.items() if value != default[key]}

    def with_changes(self, changes: Mapping[str, Any]) -> Dialect:
        """The same dialect with other values; ``columns`` are added to those there are.

        Raises:
            DialectError: a key or value is not allowed.
        """
        made = values_of(Dialect, changes, "dialect", DialectError)
        columns = {**self.columns, **_words(made.pop("columns", {}))}
        return replace(self, columns=columns, **made)


def load_profile(path: str | Path) -> Dialect:
    """The dialect that a TOML file states.

    Raises:
        DialectError: not a TOML file, or a key or value of it is not allowed.
        TooLargeError: it has too many bytes.
        OSError: the file cannot be read.
    """
    return bind(Dialect, toml_of(Path(path), DialectError), str(path), DialectError)


def sides_of(text: object) -> tuple[Decimal, Decimal, Decimal]:
    """Sides along x, y and z from ``1200x800x1800``.

    Raises:
        DialectError: not of this form.
    """
    found = re.fullmatch(_SIDES, text.strip()) if isinstance(text, str) else None
    if found is None or not all(map(Decimal, found.groups())):
        raise DialectError(
            f"pallet is {shown(text)}; allowed: its sides along the file's x, y and z, such as "
            "1200x800x1800"
        )
    return Decimal(found[1]), Decimal(found[2]), Decimal(found[3])


def columns_of(text: str) -> dict[str, str]:
    """Names of columns from ``length=L,width=B``.

    Raises:
        DialectError: not of this form, or a word that is not allowed.
    """
    found: dict[str, str] = {}
    for part in text.split(","):
        word, equals, name = part.partition("=")
        if not (equals and word.strip() and name.strip()):
            raise DialectError(f"columns: {shown(part)}; allowed: WORD=COLUMN, such as length=L")
        if word.strip() in found:
            raise DialectError(f"columns: {shown(word.strip())} stands there twice; allowed: once")
        found[word.strip()] = name.strip()
    return _checked(found)


def _checked(columns: Mapping[str, str]) -> dict[str, str]:
    """Names of columns, each text once, by known words."""
    made: dict[str, str] = {}
    for word, name in _words(columns).items():
        if word not in WORDS:
            raise DialectError(f"columns: unknown word {shown(word)}; {nearest(word, WORDS)}")
        if not 0 < len(name.strip()) <= MAX_TEXT_LENGTH:
            raise DialectError(f"columns: {word} is {shown(name)}; allowed: the name of a column")
        if name.strip().casefold() in {other.casefold() for other in made.values()}:
            raise DialectError(
                f"columns: {shown(name)} stands for two words; allowed: each column for one"
            )
        made[word] = name.strip()
    return made


def _words(columns: Mapping[str, str]) -> dict[str, str]:
    """The same with ``item``, the name that this column has where it is written, as ``id``."""
    return {"id" if word == "item" else word: name for word, name in columns.items()}
