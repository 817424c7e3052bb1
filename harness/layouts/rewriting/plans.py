"""A file is written again with changed plans: parsed, changed, written, and read back."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping
from itertools import zip_longest
from pathlib import Path
from typing import Unpack

from steadyload.atomic import write_atomically
from steadyload.layouts.files.csv_reader import encoding_of
from steadyload.layouts.files.dialect import Dialect
from steadyload.layouts.files.parquet_footer import is_parquet
from steadyload.layouts.files.record import FormatError, Record, Refused, shown, to_layout
from steadyload.layouts.files.sources import Content, source_name
from steadyload.layouts.formats import (
    HEAD_BYTES,
    Format,
    Reading,
    detect_format,
    records_of,
    resolved,
)
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import Item, Layout, LayoutError, Vector
from steadyload.layouts.model.snapping import snap
from steadyload.layouts.rewriting.changes import Replanned, is_changed
from steadyload.layouts.rewriting.csv_files import changed_certificate, changed_csv
from steadyload.layouts.rewriting.json_files import changed_json
from steadyload.layouts.rewriting.yaml_files import changed_yaml

_READ_BACK = 1e-4
"""Lengths [cm] of what is read back differ by no more from those of the plan."""

_READ_BACK_WEIGHT = 1e-6
"""Part of a weight by which it may differ."""

_DECIMALS = 4
"""Of positions [cm] that are the same."""

_BOM = "\ufeff"


def rewrite(
    source: Content, target: Path, changed: Mapping[str, Replanned], **reading: Unpack[Reading]
) -> None:
    """Write a file again with changed plans: all values in it stay but those that they change.

    Numbers that changed are written in the file's unit, axes and decimal mark; all others, columns
    and keys that are not read, and their order stay. White space between values of JSON and YAML
    may change, and comments stay in YAML only before the first value. Rows and entries keep their
    order where a sequence number states that of loading, and are put into the order of loading
    where theirs is that. What is left out goes; Packvium's results and ACLPP schedules list it as
    not packed. What is written has been read back as the changed plans and the others as they were.
    Where no plan is changed, the bytes are copied.

    Args:
        source: the content of a file of any format that is read.
        target: the file that is written, whole or not at all.
        changed: the changed plans, by the names of layouts; the others stay.
        reading: with which the file was read, see :class:`steadyload.layouts.formats.Reading`.

    Raises:
        LayoutError: the source is no layout file, has no valid layout of a name, or cannot state a
            plan, such as another loading order than that of height in a packer's plan; says what is
            allowed instead. Nothing is written.
        OSError: the file cannot be written.
    """
    try:
        after = _rewritten(source.data, changed, reading) if changed else source.data
    except LayoutError as error:
        frame = Frame.of(reading.get("dialect") or Dialect())
        raise error.framed(frame).located(file=source_name(source)) from None
    write_atomically(target, after, follow=True)


def _rewritten(content: bytes, changed: Mapping[str, Replanned], reading: Reading) -> bytes:
    if is_parquet(content):
        raise FormatError(
            "is a Parquet file, which has no text to change; allowed: another file, in a format "
            "that is named, such as parquet or native"
        )
    dialect = reading.get("dialect") or Dialect()
    records = list(records_of(io.BytesIO(content), dialect, None))
    valid = {record.name: record for record in records if isinstance(record, Record)}
    for name in changed:
        if name not in valid:
            raise FormatError(f"has no layout {shown(name)} to change; allowed: {', '.join(valid)}")
    plans = {name: plan for name, plan in changed.items() if is_changed(valid[name].items, plan)}
    after = _written(content, records, valid, plans, dialect) if plans else content
    for old, new in zip_longest(records, records_of(io.BytesIO(after), dialect, None)):
        if old is None or new is None or old.name != new.name:
            raise FormatError("would be read back as other layouts; allowed: the same ones")
        if (plan := changed.get(old.name)) is not None:
            _check_order(new, plan)
            _check_read_back(_layout(new, reading), plan.layout)
        elif new != old and (judged := _valid(old, reading)) is not None:
            _check_read_back(_layout(new, reading), judged)
    return after


def _written(
    content: bytes,
    records: list[Record | Refused],
    valid: Mapping[str, Record],
    plans: Mapping[str, Replanned],
    dialect: Dialect,
) -> bytes:
    """The content with changed plans, in the encoding that it has."""
    encoding = encoding_of(content)  # other formats than CSV are UTF-8
    whole = content.decode(encoding)
    text = whole.removeprefix(_BOM)
    kind = detect_format(text[:HEAD_BYTES], dialect)
    if kind is Format.CSV:
        after = changed_csv(text, valid, plans, dialect)
    elif kind is Format.PACKINGSOLVER:
        after = changed_certificate(text, valid, plans, dialect)
    else:
        after = (changed_yaml if kind is Format.ACLPP else changed_json)(text, records, plans)
    return (whole[: len(whole) - len(text)] + after).encode(encoding)


def _height(item: Item) -> Vector:
    x, y, z = (round(value, _DECIMALS) for value in item.position)
    return y, z, x


def _layout(record: Record | Refused, reading: Reading) -> Layout:
    """The layout that a record is read as.

    Raises:
        LayoutError: it is not valid.
    """
    if isinstance(record, Refused):
        raise record.error
    _, deck, gap = resolved(reading)
    try:
        layout = to_layout(record, **deck)
    except LayoutError as error:
        raise error.located(layout=record.name) from None
    return snap(layout, gap) if gap else layout


def _valid(record: Record | Refused, reading: Reading) -> Layout | None:
    try:
        return _layout(record, reading)
    except LayoutError:
        return None


def _check_order(record: Record | Refused, plan: Replanned) -> None:
    """Refuse an order of loading that a packer's plan cannot state.

    Raises:
        LayoutError: it is another one than that of height.
    """
    packed = isinstance(record, Record) and "place" in record.items[0]
    if packed and list(plan.layout.items) != sorted(plan.layout.items, key=_height):
        raise FormatError(
            "is loaded in another order than that of height, by which plans of packers are read; "
            "allowed: boxes by their bases, then from the back, then from the left, or another "
            "format for the changed plan, such as native",
            layout=record.name,
        )


def _check_read_back(read: Layout, judged: Layout) -> None:
    """Refuse what reads back as another plan than the one that was judged.

    Raises:
        LayoutError: it does.
    """
    whole = {
        "pallet": read.pallet == judged.pallet,
        "floor": read.floor == judged.floor,
        "number of boxes": len(read) == len(judged),
    }
    _refuse_other(whole, read)
    for one, item in zip(read.items, judged.items, strict=True):
        told = {
            "id": one.name == item.name,
            "place": _near(one.position, item.position),
            "size": _near(one.size, item.size),
            "centre of mass": _near(one.mass_offset, item.mass_offset),
            "weight": math.isclose(one.weight, item.weight, rel_tol=_READ_BACK_WEIGHT),
            "max_load": _same_load(one.max_load, item.max_load),
        }
        _refuse_other(told, read, item)


def _refuse_other(same: Mapping[str, bool], layout: Layout, item: Item | None = None) -> None:
    for what in (what for what, is_same in same.items() if not is_same):
        raise FormatError(
            f"would be read back with another {what}; allowed: of a plan, what the file has a "
            "place for, and the origin of each box in the plan as it was read",
            layout=layout.name, item=None if item is None else str(item),
        )  # fmt: skip


def _near(one: Vector, other: Vector) -> bool:
    return all(abs(a - b) <= _READ_BACK for a, b in zip(one, other, strict=True))


def _same_load(one: float | None, other: float | None) -> bool:
    if one is None or other is None:
        return one is other
    return math.isclose(one, other, rel_tol=_READ_BACK_WEIGHT)
