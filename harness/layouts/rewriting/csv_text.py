"""Changed plans in the text of CSV files and of certificates of PackingSolver."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from functools import partial
from typing import NamedTuple

from steadyload.layouts.files.csv_cells import unguarded
from steadyload.layouts.files.csv_columns import Columns, find_columns
from steadyload.layouts.files.csv_reader import TURNED, opened
from steadyload.layouts.files.dialect import Dialect
from steadyload.layouts.files.record import FormatError, Record, shown
from steadyload.layouts.model.frame import Frame, Length
from steadyload.layouts.model.naming import box_label
from steadyload.layouts.rewriting.edits import (
    OFFSETS,
    POSITION,
    SAME,
    SIDES,
    Edit,
    Entry,
    Form,
    Replanned,
    Span,
    number_text,
    plan_edits,
)

_FINER = 5
"""Decimals of a number beyond those of a length in a sentence: a hundredth of a micrometre."""

_CORE = re.compile(r'[^\s"]+')
"""A number without the quotes and the spaces around it."""

_AXES = {"x": "Y", "y": "Z", "z": "X", "width": "LY", "height": "LZ", "depth": "LX"}
"""Number of a box -> its column of a certificate, whose x is our z and whose y is our x."""


class _Row(NamedTuple):
    """A row: its cells, all of it, and all of it with the end of its line."""

    cells: list[Span]
    span: Span
    line: Span


def csv_edits(
    text: str, records: Mapping[str, Record], plans: Mapping[str, Replanned], dialect: Dialect
) -> list[Edit]:
    """Edits of a CSV file.

    Raises:
        LayoutError: the file cannot state a plan.
    """
    separator, header, _ = opened(text.encode(), dialect)
    rows = _rows(text, separator)
    next(row for row in rows if [_value(text, cell) for cell in row.cells] == header)
    columns = find_columns(header, dialect)
    numeric = _numeric(columns)
    of_layout = defaultdict(list)
    marks: set[str] = set()
    for row in rows:
        if any(_value(text, cell) for cell in row.cells):
            of_layout[unguarded(_value(text, row.cells[columns.layout]))].append(row)
            told = (row.cells[place] for place in numeric)
            marks |= {mark for cell in told for mark in ".," if text.find(mark, *cell) >= 0}
    # Semicolons beside whole numbers only come from where decimals have a comma.
    mark = marks.pop() if marks else "," if separator == ";" else "."
    frame = Frame.of(dialect)

    def write(key: str, value: float, old: str) -> str:
        if key == "sequence":
            return str(int(value) + (dialect.order == "from-1"))
        return number_text(value / frame.cm, frame.decimals + _FINER, old, mark)

    form = Form(write, columns.sequence is None, dialect.positions == "centre")
    places = _places(columns, dialect)
    edits = []
    for name, plan in plans.items():
        record, own = records[name], of_layout[name]
        _refuse_turning(record, plan, columns)
        entries = [
            Entry(row.span, row.line, {k: _core(text, row.cells[at]) for k, at in places.items()})
            for row in own
        ]
        edits += plan_edits(text, entries, record.items, plan, form)
    return edits


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


def certificate_edits(
    text: str, records: Mapping[str, Record], plans: Mapping[str, Replanned], dialect: Dialect
) -> list[Edit]:
    """Edits of a certificate, all copies of whose bins have to change alike.

    Raises:
        LayoutError: the certificate cannot state a plan.
    """
    rows = (row for row in _rows(text, ",") if row.span.end > row.span.start)
    header = [_value(text, cell) for cell in next(rows).cells]
    at = {name: place for place, name in enumerate(header)}
    form = Form(partial(_whole, Frame.of(dialect)), axes="XYZ")
    code = at.get("ROTATION")
    names: list[str] = []
    entries: list[Entry] = []
    of_bin: dict[str, tuple[list[str], list[Entry]]] = {}
    stacked = set()
    for row in rows:
        kind, many, bin_number = (
            _value(text, row.cells[at[name]]) for name in ("TYPE", "COPIES", "BIN")
        )
        if kind == "BIN":
            first = f"bin {int(float(bin_number))}"
            copies = range(1, int(float(many)))
            names, entries = [first, *(f"{first} copy {copy}" for copy in copies)], []
            of_bin[first] = names, entries
        elif kind == "STACK":
            stacked.update(names)
        else:
            numbers = {key: row.cells[at[column]] for key, column in _AXES.items()}
            cell = None if code is None else row.cells[code]
            entries.append(Entry(row.span, row.line, numbers, cell))
    edits = []
    for names, entries in of_bin.values():
        wanted = [plans[name] for name in names if name in plans]
        if not wanted:
            continue
        plan = wanted[0]
        if len(wanted) < len(names) or any(not _alike(plan, other) for other in wanted):
            raise FormatError(
                f"is a bin of {len(names)} copies, which a certificate states once, and not all "
                "change alike; allowed: all changed alike, or native", layout=names[0],
            )  # fmt: skip
        items = sorted(records[names[0]].items, key=lambda item: item["place"])
        found = plan_edits(text, entries, items, plan, form)
        if found and names[0] in stacked:
            raise FormatError(
                "stands in stacks, which a certificate states beside their boxes; allowed: a plan "
                "of the box solver, or native", layout=names[0],
            )  # fmt: skip
        edits += found
    return edits


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


def _rows(text: str, separator: str) -> Iterator[_Row]:
    cell = re.compile(rf'("(?:[^"]|"")*"|[^{separator}\r\n]*)({separator}|\r\n|\r|\n|\Z)')
    at, start = 0, 0
    cells: list[Span] = []
    while found := cell.match(text, at):
        cells.append(Span(*found.span(1)))
        at = found.end()
        if found[2] != separator:
            yield _Row(cells, Span(start, found.end(1)), Span(start, at))
            cells, start = [], at
            if at == len(text):
                return


def _value(text: str, cell: Span) -> str:
    value = text[slice(*cell)]
    quoted = len(value) > 1 and value[0] == value[-1] == '"'
    value = value[1:-1].replace('""', '"') if quoted else value
    return value.replace("\r\n", "\n").replace("\r", "\n")


def _core(text: str, cell: Span) -> Span:
    found = _CORE.search(text, *cell)
    return Span(*found.span()) if found else cell
