"""Columns of a CSV file: which value stands where, by its header line and the dialect."""

from __future__ import annotations

import difflib
import logging
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from steadyload.layouts.files.csv_cells import number
from steadyload.layouts.files.dialect import LOADS, OFFSETS, PALLET_SIDES, WORDS, Dialect
from steadyload.layouts.files.record import FormatError, shown

_log = logging.getLogger("steadyload")

SEPARATORS = ";\t,"
"""Characters that may stand between columns."""

_SAME = {"item": "id", "sku": "id", "name": "id"}
"""Headers that are the words of other columns."""

_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-zß-ÿ]+")
"""A word of a header, such as each of ``isTurned`` and of ``is_turned``."""

_TURNING = re.compile(
    r"rot|rotate[ds]?|rotations?|orient(ed)?|orientations?|orientierung|dreh|drehung|drehwinkel|"
    r"gedreht|ausrichtung|winkel|angle|yaw|theta|turn(ed)?|flip(ped)?|upside"
)
"""Words of columns that probably state how a box is turned."""

_NOT_TURNED = ("", "no", "false", "nein")
"""Cells of such a column for a box that is not turned, beside zero."""

_NAMED = 8
"""Unknown columns that a message names at most."""

_HINT = "; name columns of your own with --columns or in a profile"


@dataclass(frozen=True, slots=True)
class Columns:
    """Places of the values in a row.

    Attributes:
        count: number of columns.
        layout, weight: their places.
        sequence: likewise, None where the order of the rows is that of loading.
        identity: place of a box's id, None where boxes have none.
        position, size, pallet: places of the values along the file's x, y and z; no pallet where
            the dialect states one.
        offset: likewise, of the centre of mass; None where it is not given along that axis.
        load: place of the load that a box may bear, and that of the same a square metre; None
            where it is not given.
        turning: places and headers of those left out that probably state how a box is turned.
        trailing: place of a last column without a header and without values, such as a separator
            at the end of each line makes; None where there is none.
    """

    count: int
    layout: int
    sequence: int | None
    weight: int
    identity: int | None
    position: tuple[int, ...]
    size: tuple[int, ...]
    pallet: tuple[int, ...]
    offset: tuple[int | None, ...]
    load: tuple[int | None, ...]
    turning: Mapping[int, str]
    trailing: int | None = None


def separator_of(header: str, dialect: Dialect) -> str | None:
    """The character by which a line parts into the most known columns; None if it has none."""
    found = {mark: _known(header.split(mark), dialect) for mark in SEPARATORS if mark in header}
    best = max(found, key=lambda mark: found[mark], default=None)
    return best if best is not None and found[best] else None


def _known(cells: Sequence[str], dialect: Dialect) -> int:
    names = {name.casefold() for name in (*WORDS, *_SAME, *dialect.columns.values())}
    return sum(cell.strip().strip('"').strip().casefold() in names for cell in cells)


def find_columns(header: Sequence[str], dialect: Dialect) -> Columns:
    """Places of the values.

    Raises:
        FormatError: a column is unknown, missing, or stands there twice.
    """
    header = [name.strip() for name in header]
    places = _places(header, dialect)
    for key, words in (("pallet", PALLET_SIDES), ("order", ("sequence",))):
        there = [word for word in words if word in places]
        if there and getattr(dialect, key) not in ("", "column", "from-1"):
            raise FormatError(
                f"has the CSV column {there[0]!r}, and {key} is {getattr(dialect, key)}; allowed: "
                "one of the two"
            )

    def place(word: str) -> int:
        if word not in places:
            raise _missing(word, header, places)
        return places[word]

    def along_axes(prefix: str) -> tuple[int, ...]:
        return tuple(place(prefix + side) for side in _sides(places, prefix, dialect))

    return Columns(
        count=len(header),
        layout=place("layout"),
        pallet=along_axes("pallet_") if not dialect.pallet else (),
        sequence=place("sequence") if dialect.order != "rows" else None,
        position=tuple(map(place, "xyz")),
        size=along_axes(""),
        weight=place("weight"),
        identity=places.get("id"),
        offset=tuple(map(places.get, OFFSETS)),
        load=tuple(map(places.get, LOADS)),
        turning={
            place: name
            for place, name in enumerate(header)
            if place not in places.values() and _is_of_turning(name)
        },
        trailing=(
            len(header) - 1 if not header[-1] and dialect.other_columns == "refuse" else None
        ),
    )


def _is_of_turning(header: str) -> bool:
    return any(_TURNING.fullmatch(word.casefold()) for word in _WORD.findall(header))


def turns(cell: str) -> bool:
    """True if a cell of a column of rotations states one."""
    return cell.strip().casefold() not in _NOT_TURNED and number(cell) != 0


def warn_of_turning(file: str, header: str) -> None:
    """Say that a column is left out though it probably states how boxes are turned."""
    _log.warning(
        "%s: the CSV column %s is left out: boxes stand as their sides are stated, and are not "
        "turned by it",
        file,
        shown(header),
    )


def _places(header: Sequence[str], dialect: Dialect) -> dict[str, int]:
    """Place of every word that the header has."""
    own = {name.casefold(): word for word, name in dialect.columns.items()}
    words = [own.get(name.casefold(), _word(name, dialect.columns)) for name in header]
    for named, column in dialect.columns.items():
        if named not in words:
            known = {word: index for index, word in enumerate(words) if word is not None}
            raise FormatError(
                f"lacks the CSV column {shown(column)}, named for {named}"
                f"{_nearest(column, header, known)}"
            )
    places: dict[str, int] = {}
    unknown: list[str] = []
    for index, (name, word) in enumerate(zip(header, words, strict=True)):
        if word is None:
            if name or index < len(header) - 1:
                unknown.append(name)
        elif word in places:
            raise _twice(header[places[word]], name, word)
        else:
            places[word] = index
    if unknown and dialect.other_columns == "refuse":
        raise _left_over(unknown, dialect)
    return places


def _left_over(names: Sequence[str], dialect: Dialect) -> FormatError:
    """The error of columns that stand for nothing."""
    name = next((name for name in names if _word(name, {})), "")
    word = _word(name, {})
    if word is None:
        return _unknown(names)
    return FormatError(
        f"has two CSV columns for {word}, {shown(dialect.columns[word])}, as it is named, and "
        f"{shown(name)}; allowed: one, or leave out the other with --other-columns ignore"
    )


def _word(name: str, columns: Mapping[str, str]) -> str | None:
    """The word that a header stands for by itself; not one for which another column is named."""
    word = _SAME.get(name.casefold(), name.casefold())
    return word if word in WORDS and word not in columns else None


def _sides(places: Mapping[str, int], prefix: str, dialect: Dialect) -> tuple[str, str, str]:
    """The words of the sides along the file's x, y and z."""
    length, depth = prefix + "length" in places, prefix + "depth" in places
    if length and depth:
        raise FormatError(
            f"has the CSV columns {prefix}length and {prefix}depth; allowed: one of them, beside "
            f"{prefix}width and {prefix}height"
        )
    if dialect.up == "y":
        return "width", "height", "length" if length else "depth"
    return ("width", "depth", "height") if depth else ("length", "width", "height")


def _unknown(names: Sequence[str]) -> FormatError:
    for name in names:
        mixed = next((mark for mark in SEPARATORS if mark in name), None)
        if mixed is not None:
            return FormatError(
                f"has the CSV header {shown(name)}, with a {mixed!r} in it; allowed: one separator "
                "of columns in the whole file, ',', ';' or a tab"
            )
    told = ", ".join(shown(name) + _meant(name, len(names)) for name in names[:_NAMED])
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    columns = f"columns {told}{more}; " if len(names) > 1 else f"column {told}"
    return FormatError(
        f"has the unknown CSV {columns}allowed: {', '.join(WORDS)}{_HINT}, or leave them out with "
        "--other-columns ignore"
    )


def _meant(name: str, count: int) -> str:
    """The word that a header probably means, beside one column or several."""
    close = difflib.get_close_matches(name[:80].casefold(), (*WORDS, *_SAME), n=1)
    if count > 1:
        return f" (did you mean {close[0]!r}?)" if close else ""
    return f"; did you mean {close[0]!r}? " if close else "; "


def _twice(first: str, second: str, word: str) -> FormatError:
    if first.casefold() == second.casefold():
        return FormatError(f"has the CSV column {shown(first)} twice; allowed: each once")
    return FormatError(
        f"has two CSV columns for {word}, {shown(first)} and {shown(second)}; allowed: one{_HINT}"
    )


def _missing(word: str, header: Sequence[str], places: Mapping[str, int]) -> FormatError:
    return FormatError(
        f"lacks the CSV column {word!r}{_nearest(word, header, places)}; allowed: "
        f"{', '.join(WORDS)}{_HINT}{_stated_instead(word)}"
    )


def _stated_instead(word: str) -> str:
    """How to say by a flag what a column would."""
    if word in PALLET_SIDES:
        return "; or state the sides of all pallets: --pallet 1200x800x1800"
    return "; or take the order of the rows: --order rows" if word == "sequence" else ""


def _nearest(name: str, header: Sequence[str], places: Mapping[str, int]) -> str:
    """The most similar header that stands for nothing yet."""
    free = {h[:80].casefold(): h for i, h in enumerate(header) if i not in places.values()}
    close = difflib.get_close_matches(name[:80].casefold(), free, n=1)
    return f"; the nearest in its header is {shown(free[close[0]])}" if close else ""
