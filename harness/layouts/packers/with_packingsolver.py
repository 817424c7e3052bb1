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
from pathlib import Path
from typing import Any

from steadyload.layouts.model import LayoutError, Vector
from steadyload.layouts.packers.plan import (
    LENGTHS,
    WEIGHTS,
    Bin,
    Order,
    Placed,
    Plan,
    PlanError,
    factor,
    plan,
    record,
)
from steadyload.layouts.record import FormatError, Record, shown

HEADER = "TYPE,ID,COPIES,BIN,"
"""Beginning of every certificate."""

_COLUMNS = ("TYPE", "ID", "COPIES", "BIN", "X", "Y", "Z", "LX", "LY", "LZ")
_MOST_COPIES = 10_000
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
    length = factor(units, LENGTHS)
    known: dict[int, float]
    if isinstance(weights, Mapping):
        known = dict(weights)
    else:
        scale = factor(weights, WEIGHTS)
        types = () if instance is None else instance.item_types
        known = {k: float(each.weight) * scale for k, each in enumerate(types)}
    if isinstance(solution, str | Path):
        try:
            text = Path(solution).read_text(encoding="utf-8-sig")
            bins = list(_of_certificate(text, length, known))
        except UnicodeDecodeError as error:
            raise FormatError(
                f"is not UTF-8 text (byte {error.start})", file=str(solution)
            ) from None
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


def read_certificate(text: str) -> Iterator[Record]:
    """Records of a certificate: one a bin, in centimetres, in order of height.

    Raises:
        FormatError: the text is no certificate.
    """
    for loaded in _of_certificate(text, 1.0, {}):
        if loaded.boxes:
            yield record(loaded)


def _of_certificate(text: str, length: float, weights: Mapping[int, float]) -> Iterator[Bin]:
    rows = csv.reader(io.StringIO(text))
    header = next(rows, [])
    missing = [name for name in _COLUMNS if name not in header]
    if missing:
        raise FormatError(f"has no column {missing[0]}; allowed: a certificate of PackingSolver")
    at = {name: header.index(name) for name in _COLUMNS}
    size: Vector = (0.0, 0.0, 0.0)
    current, copies = -1, 0
    boxes: list[Placed] = []
    for cells in rows:
        if not cells:
            continue
        line = rows.line_num
        if len(cells) < len(_COLUMNS):
            raise FormatError(f"line {line} has {len(cells)} values; is it cut off?")
        row = {name: cells[place] for name, place in at.items() if place < len(cells)}
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
            yield from _copies(current, copies, size, boxes)
            current, copies, size, boxes = bin_number, many, sides, []
            if not 1 <= copies <= _MOST_COPIES:
                raise FormatError(
                    f"line {line} has COPIES {copies}; allowed: 1 to {_MOST_COPIES:,}"
                )
        elif bin_number != current or many != 1:
            raise FormatError(
                f"line {line} holds {many} of an item in bin {bin_number}; allowed: 1 at a place, "
                "after the line of its bin"
            )
        else:
            corner = _three(row, ("X", "Y", "Z"), length, line)
            boxes.append(Placed(f"type {number}", corner, sides, weights.get(number) or None))
    if current < 0:
        raise FormatError("holds no bins; allowed: one or more")
    yield from _copies(current, copies, size, boxes)


def _copies(number: int, copies: int, size: Vector, boxes: list[Placed]) -> Iterator[Bin]:
    for copy in range(copies if number >= 0 else 0):
        yield Bin(f"bin {number}" + (f" copy {copy}" if copy else ""), size, boxes)


def _of_result(result: Any, length: float, weights: Mapping[int, float]) -> Iterator[Bin]:
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
        yield from _copies(each.bin_id, each.copies, size, boxes)


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
