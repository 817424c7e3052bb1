"""Plans of PackingSolver: certificates (CSV) of its box and boxstacks solvers, and the results of
packingsolver3d.

Its x is the length, y the width and z the height. Lengths are whole numbers without a unit, and a
certificate names no weights.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from steadyload.layouts.files.dialect import Dialect
from steadyload.layouts.files.limits import (
    MAX_COPIED_ITEMS,
    MAX_COPIES,
    MAX_FILE_BYTES,
    MAX_ITEMS,
    MAX_LAYOUTS,
    MAX_TEXT_LENGTH,
)
from steadyload.layouts.files.record import FormatError, Record, Refused, shown
from steadyload.layouts.files.sources import decoded, opened_source, read_rest
from steadyload.layouts.model.layout import LayoutError, Vector
from steadyload.layouts.model.units import UNITS, WEIGHT_UNITS
from steadyload.layouts.packers.plan import (
    Bin,
    Order,
    Placed,
    Plan,
    PlanError,
    factor,
    plan,
    stated,
)

HEADER = "TYPE,ID,COPIES,BIN,"
"""Beginning of every certificate."""

_COLUMNS = ("TYPE", "ID", "COPIES", "BIN", "X", "Y", "Z", "LX", "LY", "LZ")
_NUMBER = re.compile(r"-?[0-9]{1,15}(\.[0-9]{1,15})?", re.ASCII)


def from_packingsolver(
    solution: Any,
    *,
    instance: Any = None,
    units: str = "cm",
    weights: str | Mapping[int, float] = "kg",
    order: Order = "height",
) -> Plan:
    """Layouts of a result of packingsolver3d, or of a certificate.

    Args:
        solution: a ``packingsolver3d.Result``, or the path of a certificate.
        instance: the ``packingsolver3d.Instance`` that was solved: gives the weights of item types
            and what is unplaced.
        units: the unit of lengths: mm, cm, m or in.
        weights: the unit of the instance's weights: g, kg or lb; or the weights themselves [kg], by
            the id of the item type. An item without a weight, or with 0, weighs 200 kg/m3.
        order: the loading order: ``height`` (base, then from the back to the front) or ``given``,
            as the bins list their items.

    Raises:
        PlanError: what is given is neither, or its weights are in no known unit.
        LayoutError: the certificate cannot be read, or a bin is no valid layout.
        OSError: the certificate cannot be read.
    """
    length = factor(units, UNITS)
    known: dict[int, float]
    if isinstance(weights, Mapping):
        known = dict(weights)
    else:
        scale = factor(weights, WEIGHT_UNITS)
        types = () if instance is None else instance.item_types
        known = {k: float(each.weight) * scale for k, each in enumerate(types)}
    if isinstance(solution, str | Path):
        try:
            with opened_source(solution) as file:
                text = decoded(read_rest(file, b"", MAX_FILE_BYTES)).removeprefix("\ufeff")
            bins = list(_of_certificate(text, length, known))
            for each in bins:
                _check_count(each)
        except LayoutError as error:
            raise error.located(file=str(solution)) from None
    elif hasattr(solution, "bins") and hasattr(solution, "number_of_bins"):
        bins = list(_of_result(solution, length, known))
    else:
        raise PlanError(
            f"a {type(solution).__name__} is no plan; allowed: a Result of packingsolver3d, or the "
            "path of a certificate"
        )
    return plan(bins, _unplaced(bins, instance), order)


def read_certificate(text: str, dialect: Dialect) -> Iterator[Record | Refused]:
    """Records of a certificate: one a bin, in order of height.

    Args:
        text: the certificate.
        dialect: gives the unit of lengths, which a certificate does not state.

    Raises:
        FormatError: the text is no certificate, or the dialect states what none has.
    """
    others = [key for key in dialect.stated() if key != "units"]
    if others:
        raise FormatError(
            f"is a certificate of PackingSolver, which has no weights and axes and columns of its "
            f"own; of it units can be stated, and not {' and '.join(others)} (weights are told to "
            "steadyload.from_packingsolver)"
        )
    for loaded in _of_certificate(text, factor(dialect.units, UNITS), {}):
        try:
            _check_count(loaded)
        except LayoutError as error:
            yield Refused(loaded.name, error)
        else:
            yield stated(loaded)


def _check_count(loaded: Bin) -> None:
    if len(loaded.boxes) > MAX_ITEMS:
        raise LayoutError(
            f"has more than {MAX_ITEMS:,} items; that is the most allowed", layout=loaded.name
        )


def _of_certificate(text: str, length: float, weights: Mapping[int, float]) -> Iterator[Bin]:
    """Bins that hold boxes, of too many no more than one past those that a layout may have."""
    rows = _rows(text)
    header = next(rows, (1, []))[1]
    missing = [name for name in _COLUMNS if name not in header]
    if missing:
        raise FormatError(f"has no column {missing[0]}; allowed: a certificate of PackingSolver")
    at = {name: header.index(name) for name in _COLUMNS}
    last = max(at.values())
    size: Vector = (0.0, 0.0, 0.0)
    current, copies = -1, 0
    boxes: list[Placed] = []
    each_copy = partial(_copies, _Count())
    for line, cells in rows:
        if len(cells) <= last:
            raise FormatError(f"line {line} has {len(cells)} values; is it cut off?")
        row = {name: cells[place] for name, place in at.items()}
        kind = row["TYPE"]
        if kind == "STACK":
            continue
        if kind not in ("BIN", "ITEM"):
            raise FormatError(
                f"line {line} has TYPE {shown(kind)}; allowed: BIN, STACK, ITEM of the solvers box "
                "and boxstacks"
            )
        number, many, bin_number = (_whole(row[k], k, line) for k in ("ID", "COPIES", "BIN"))
        sides = _three(row, ("LX", "LY", "LZ"), length, line)
        if kind == "BIN":
            yield from each_copy(current, copies, size, boxes)
            current, copies, size, boxes = bin_number, many, sides, []
            if not 1 <= copies <= MAX_COPIES:
                raise FormatError(f"line {line} has COPIES {copies}; allowed: 1 to {MAX_COPIES:,}")
        elif bin_number != current or many != 1:
            raise FormatError(
                f"line {line} holds {many} of an item in bin {bin_number}; allowed: 1 at a place, "
                "after the line of its bin"
            )
        elif len(boxes) <= MAX_ITEMS:
            corner = _three(row, ("X", "Y", "Z"), length, line)
            boxes.append(Placed(f"type {number}", corner, sides, weights.get(number) or None))
    if current < 0:
        raise FormatError("holds no bins; allowed: one or more")
    yield from each_copy(current, copies, size, boxes)


def _rows(text: str) -> Iterator[tuple[int, list[str]]]:
    """Lines that are not empty, with their numbers; the header first."""
    reader = csv.reader(io.StringIO(text, newline=""))
    try:
        for cells in reader:
            if any(len(cell) > MAX_TEXT_LENGTH for cell in cells):
                raise FormatError(
                    f"line {reader.line_num} has a cell of {max(map(len, cells)):,} characters; "
                    f"allowed: {MAX_TEXT_LENGTH:,}"
                )
            if cells:
                yield reader.line_num, cells
    except csv.Error as error:
        raise FormatError(f"line {reader.line_num} is not CSV ({error})") from None


@dataclass
class _Count:
    """Layouts and items of a plan so far, copies included."""

    layouts: int = 0
    items: int = 0

    def add(self, copies: int, items: int) -> None:
        self.layouts += copies
        self.items += copies * items
        if self.layouts > MAX_LAYOUTS or self.items > max(MAX_COPIED_ITEMS, items):
            raise FormatError(
                f"holds more than {MAX_LAYOUTS:,} layouts or {MAX_COPIED_ITEMS:,} items, copies of "
                "bins included; allowed: up to so many"
            )


def _copies(
    count: _Count, number: int, copies: int, size: Vector, boxes: list[Placed]
) -> Iterator[Bin]:
    if not boxes:
        return
    count.add(copies, len(boxes))
    for copy in range(copies):
        yield Bin(f"bin {number}" + (f" copy {copy}" if copy else ""), size, boxes)


def _of_result(result: Any, length: float, weights: Mapping[int, float]) -> Iterator[Bin]:
    each_copy = partial(_copies, _Count())
    for each in result.bins:
        boxes = [
            Placed(
                f"type {p.item_type_id}",
                (p.x * length, p.y * length, p.z * length),
                (p.lx * length, p.ly * length, p.lz * length),
                weights.get(p.item_type_id) or None,
            )
            for p in each.placements
        ]
        size = (each.x * length, each.y * length, each.z * length)
        yield from each_copy(each.bin_id, each.copies, size, boxes)


def _unplaced(bins: list[Bin], instance: Any) -> list[str]:
    """One name for each copy of an item type that is in no bin; none without the instance."""
    if instance is None:
        return []
    left = {f"type {k}": each.copies for k, each in enumerate(instance.item_types)}
    for loaded in bins:
        for box in loaded.boxes:
            left[box.name] = left.get(box.name, 0) - 1
    return [name for name, count in left.items() for _ in range(count)]


def _whole(cell: str, column: str, line: int) -> int:
    value = _number(cell, column, line)
    if not value.is_integer():
        raise FormatError(f"line {line} has {column} {shown(cell)}; allowed: a whole number")
    return int(value)


def _number(cell: str, column: str, line: int) -> float:
    if not _NUMBER.fullmatch(cell):
        raise FormatError(f"line {line} has {column} {shown(cell)}; allowed: a number")
    return float(cell)


def _three(row: Mapping[str, str], columns: tuple[str, ...], by: float, line: int) -> Vector:
    x, y, z = (_number(row[column], column, line) * by for column in columns)
    return x, y, z
