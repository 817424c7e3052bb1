"""Changed plans in CSV files and in certificates of PackingSolver.

Rows are parsed into the texts of their cells, quotes and spaces included, so that what is not
changed is written as it was read.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial

from steadyload.layouts.files.csv_cells import unguarded
from steadyload.layouts.files.csv_columns import Columns, find_columns
from steadyload.layouts.files.csv_reader import TURNED, opened
from steadyload.layouts.files.dialect import Dialect
from steadyload.layouts.files.record import FormatError, Record, shown
from steadyload.layouts.model.frame import Frame, Length
from steadyload.layouts.model.naming import box_label
from steadyload.layouts.rewriting.changes import (
    OFFSETS,
    POSITION,
    SAME,
    SIDES,
    Form,
    Replanned,
    changed_boxes,
    number_text,
)

_FINER = 5
"""Decimals of a number beyond those of a length in a sentence: a hundredth of a micrometre."""

_CORE = re.compile(r'[^\s"]+')
"""A number without the quotes and the spaces around it."""

_AXES = {"x": "Y", "y": "Z", "z": "X", "width": "LY", "height": "LZ", "depth": "LX"}
"""Number of a box -> its column of a certificate, whose x is our z and whose y is our x."""


@dataclass
class _Row:
    """A row and the end of its line."""

    text: str
    end: str


class _Rows:
    """The rows of a file, some of which are parsed, changed and put back.

    Args:
        text: of the file.
        separator: of cells.
    """

    def __init__(self, text: str, separator: str) -> None:
        self._separator = separator
        self._cell = re.compile(rf'("(?:[^"]|"")*"|[^{separator}\r\n]*)({separator}|\r\n|\r|\n|\Z)')
        if '"' in text:
            self.all = list(self._quoted(text))
        else:
            lines = re.split(r"(\r\n|\r|\n)", text)
            self.all = [_Row(*pair) for pair in zip(lines[::2], [*lines[1::2], ""], strict=True)]

    def _quoted(self, text: str) -> Iterator[_Row]:
        start = at = 0
        while at < len(text):
            found = self._match(text, at)
            at = found.end()
            if found[2] != self._separator:
                yield _Row(text[start : found.end(1)], found[2])
                start = at

    def _match(self, text: str, at: int) -> re.Match[str]:
        found = self._cell.match(text, at)
        if found is None:
            raise FormatError("is not CSV; allowed: a separator behind each quoted cell")
        return found

    def cells(self, row: _Row) -> list[str]:
        """The texts of the cells of a row."""
        if '"' not in row.text:
            return row.text.split(self._separator)
        cells, at, goes_on = [], 0, True
        while goes_on:
            found = self._match(row.text, at)
            cells.append(found[1])
            at, goes_on = found.end(), found[2] == self._separator
        return cells

    def put(self, own: list[_Row], kept: list[list[str]]) -> None:
        """Put cells in the place of some rows; what is behind them goes."""
        for row, cells in zip(own, kept, strict=False):
            row.text = self._separator.join(cells)
        for row in own[len(kept) :]:
            row.text = row.end = ""

    def __str__(self) -> str:
        return "".join([part for row in self.all for part in (row.text, row.end)])


def changed_csv(
    text: str, records: Mapping[str, Record], plans: Mapping[str, Replanned], dialect: Dialect
) -> str:
    """The text of a CSV file with changed plans.

    Raises:
        LayoutError: the file cannot state a plan.
    """
    separator, header, _ = opened(text.encode(), dialect)
    columns = find_columns(header, dialect)
    rows = _Rows(text, separator)
    of_layout: dict[str, list[_Row]] = {name: [] for name in plans}
    numeric, mark, began = _numeric(columns), "", False
    for row in rows.all:
        if not began:
            began = list(map(_value, rows.cells(row))) == header
        elif row.text.strip(separator):
            cells = rows.cells(row)
            name = unguarded(_value(cells[columns.layout]))
            if name in of_layout:
                of_layout[name].append(row)
            mark = mark or next((m for k in numeric for m in ".," if m in cells[k]), "")
    # Semicolons beside whole numbers only come from where decimals have a comma.
    mark = mark or ("," if separator == ";" else ".")
    frame = Frame.of(dialect)

    def write(key: str, value: float, old: str) -> str:
        found = _CORE.search(old)
        before = found[0] if found else ""
        if key == "sequence":
            new = str(int(value) + (dialect.order == "from-1"))
        else:
            new = number_text(value / frame.cm, frame.decimals + _FINER, before, mark)
        return old[: found.start()] + new + old[found.end() :] if found else new

    places = {key: (place,) for key, place in _places(columns, dialect).items()}
    form = Form(places, write, columns.sequence is None, dialect.positions == "centre")
    for name, plan in plans.items():
        _refuse_turning(records[name], plan, columns)
        boxes = [rows.cells(row) for row in of_layout[name]]
        rows.put(of_layout[name], changed_boxes(boxes, records[name].items, plan, form))
    return str(rows)


def _numeric(columns: Columns) -> list[int]:
    found = (*columns.position, *columns.size, *columns.pallet, *columns.offset, *columns.load)
    return [place for place in (*found, columns.weight) if place is not None]


def _places(columns: Columns, dialect: Dialect) -> dict[str, int]:
    """Places of the numbers of a box, by the keys of an item of a record."""
    found = {"sequence": columns.sequence}
    for keys, own in (
        (POSITION, columns.position), (SIDES, columns.size), (OFFSETS, columns.offset)
    ):  # fmt: skip
        found |= {key: own[axis] for key, axis in zip(keys, TURNED[dialect.up], strict=True)}
    return {key: place for key, place in found.items() if place is not None}


def _refuse_turning(record: Record, plan: Replanned, columns: Columns) -> None:
    """Refuse to turn boxes of a file with a column that probably states how they are turned."""
    old = {int(item["sequence"]): item for item in record.items}
    for step, item in zip(plan.origins, plan.layout.items, strict=True):
        if columns.turning and step in old and abs(item.size[0] - old[step]["width"]) > SAME:
            raise FormatError(
                f"is turned, and the CSV column {shown(next(iter(columns.turning.values())))}, "
                "which is not read, probably states how; allowed: a plan without turned boxes, a "
                "file without this column, or native",
                layout=record.name, item=box_label(step, item.name),
            )  # fmt: skip


def changed_certificate(
    text: str, records: Mapping[str, Record], plans: Mapping[str, Replanned], dialect: Dialect
) -> str:
    """The text of a certificate with changed plans; all copies of a bin have to change alike.

    Raises:
        LayoutError: the certificate cannot state a plan.
    """
    rows = _Rows(text, ",")
    filled = (row for row in rows.all if row.text)
    at = {_value(name): place for place, name in enumerate(rows.cells(next(filled)))}
    code = (at["ROTATION"],) if "ROTATION" in at else None
    places = {key: (at[column],) for key, column in _AXES.items()}
    form = Form(places, partial(_whole, Frame.of(dialect)), code=code, axes="XYZ")
    of_bin: dict[str, tuple[list[str], list[_Row]]] = {}
    names: list[str] = []
    own: list[_Row] = []
    stacked = set()
    for row in filled:
        cells = rows.cells(row)
        kind, many, number = (_value(cells[at[name]]) for name in ("TYPE", "COPIES", "BIN"))
        if kind == "BIN":
            first = f"bin {int(float(number))}"
            copies = range(1, int(float(many)))
            names, own = [first, *(f"{first} copy {copy}" for copy in copies)], []
            of_bin[first] = names, own
        elif kind == "STACK":
            stacked.update(names)
        else:
            own.append(row)
    for names, own in of_bin.values():
        wanted = [plans[name] for name in names if name in plans]
        if not wanted:
            continue
        plan = wanted[0]
        if len(wanted) < len(names) or any(not _alike(plan, other) for other in wanted):
            raise FormatError(
                f"is a bin of {len(names)} copies, which a certificate states once, and not all "
                "change alike; allowed: all changed alike, or native", layout=names[0],
            )  # fmt: skip
        before = [rows.cells(row) for row in own]
        items = sorted(records[names[0]].items, key=lambda item: item["place"])
        after = changed_boxes([[*cells] for cells in before], items, plan, form)
        if after != before and names[0] in stacked:
            raise FormatError(
                "stands in stacks, which a certificate states beside their boxes; allowed: a plan "
                "of the box solver, or native", layout=names[0],
            )  # fmt: skip
        rows.put(own, after)
    return str(rows)


def _alike(plan: Replanned, other: Replanned) -> bool:
    return plan.origins == other.origins and plan.layout.items == other.layout.items


def _whole(frame: Frame, key: str, value: float, _old: str) -> str:
    """A length of a certificate, in its unit."""
    whole = round(value / frame.cm)
    if abs(whole * frame.cm - value) > SAME:
        raise FormatError(
            f"has {_AXES[key]} = ", Length(value), "; allowed in a certificate of PackingSolver: "
            "whole numbers of its unit, or another format for the changed plan, such as native",
            frame=frame,
        )  # fmt: skip
    return str(whole)


def _value(cell: str) -> str:
    """The text that a cell states."""
    quoted = len(cell) > 1 and cell[0] == cell[-1] == '"'
    value = cell[1:-1].replace('""', '"') if quoted else cell
    return value.replace("\r\n", "\n").replace("\r", "\n")
