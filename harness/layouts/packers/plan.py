"""A packer's plan as layouts: its units, its axes, the order in which its boxes are loaded."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Literal

from steadyload.layouts.files.record import Record, Refused, to_layout
from steadyload.layouts.model.frame import AxisName
from steadyload.layouts.model.layout import TOLERANCE, Layout, LayoutError, Vector
from steadyload.layouts.model.naming import box_label
from steadyload.layouts.model.validity import WITHIN, from_to

DENSITY = 2e-4
"""Density of boxes without a weight [kg/cm3]: 200 kg a cubic metre."""

Order = Literal["height", "given"]
"""Loading order: ``height`` by the height of the base, then from the back to the front, then from
left to right; ``given`` as the packer lists its boxes."""


class PlanError(LayoutError):
    """A plan that cannot be judged: says where, what was wrong, and what is allowed."""


@dataclass(frozen=True, slots=True)
class Plan:
    """A packer's plan.

    Attributes:
        layouts: one a loaded bin.
        unplaced: names of the items that are in no bin.
    """

    layouts: tuple[Layout, ...]
    unplaced: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Placed:
    """A box where a packer put it, in its axes as told to :class:`Bin`.

    Attributes:
        name: of the box.
        corner: the least of its coordinates [cm].
        size: as placed [cm].
        weight: [kg]; None where the plan names none.
    """

    name: str
    corner: Vector
    size: Vector
    weight: float | None = None


@dataclass(frozen=True, slots=True)
class Bin:
    """A loaded bin in a packer's axes.

    Attributes:
        name: becomes the layout's.
        size: inner size [cm].
        boxes: in the packer's order.
        up: the axis that points up; with ``z`` the packer's x, the length, becomes the depth and y
            the width.
    """

    name: str
    size: Vector
    boxes: Sequence[Placed]
    up: Literal["y", "z"] = "z"


def record(loaded: Bin, order: Order = "height") -> Record:
    """A bin as the record of a layout.

    Raises:
        LayoutError: a box stands out of the bin.
    """
    axes = (0, 1, 2) if loaded.up == "y" else (1, 2, 0)

    def turned(vector: Vector) -> Vector:
        x, y, z = (vector[axis] for axis in axes)
        return x, y, z

    boxes = [
        (turned(box.corner), turned(box.size), box, place) for place, box in enumerate(loaded.boxes)
    ]
    if order == "height":
        boxes.sort(key=lambda box: (box[0][1], box[0][2], box[0][0]))
    width, height, depth = turned(loaded.size)
    items = []
    for sequence, ((x, y, z), (w, h, d), box, place) in enumerate(boxes):
        spans = zip((x, y, z), (w, h, d), turned(loaded.size), strict=True)
        for axis, (start, side, most) in enumerate(spans):
            if not (start >= -TOLERANCE and start + side <= most + TOLERANCE):
                raise LayoutError(
                    "spans ", AxisName(axis), " = ", *from_to(start, start + side),
                    "; allowed: inside the bin, ", *from_to(0.0, most), *WITHIN,
                    layout=loaded.name, item=box_label(sequence, box.name),
                )  # fmt: skip
        weight = DENSITY * w * h * d if box.weight is None else box.weight
        items.append(
            {"sequence": sequence, "name": box.name, "x": x, "y": y, "z": z,
             "width": w, "height": h, "depth": d, "weight": weight, "place": place}
        )  # fmt: skip
    return Record(loaded.name, {"width": width, "height": height, "depth": depth}, items)


def stated(loaded: Bin) -> Record | Refused:
    """A bin as the record of a layout, in order of height; or why it is none."""
    try:
        return record(loaded)
    except LayoutError as error:
        return Refused(loaded.name, error)


def plan(bins: Iterable[Bin], unplaced: Iterable[str], order: Order) -> Plan:
    """Validated layouts of bins; those without boxes are left out, equal names are numbered.

    Raises:
        LayoutError: a bin is no valid layout: says which and why.
    """
    if order not in ("height", "given"):
        raise PlanError(f"the loading order is {order!r}; allowed: 'height', 'given'")
    layouts: list[Layout] = []
    names: dict[str, int] = {}
    for loaded in bins:
        if not loaded.boxes:
            continue
        found = record(loaded, order)
        name, number = found.name, names.get(found.name, 0)
        while name in names:
            number += 1
            name = f"{found.name} ({number})"
        names[found.name] = max(number, 1)
        names.setdefault(name, 1)
        try:
            layouts.append(to_layout(Record(name, found.pallet, found.items)))
        except LayoutError as error:
            raise error.located(layout=name) from None
    return Plan(tuple(layouts), tuple(unplaced))


def factor(unit: str, units: Mapping[str, Decimal]) -> float:
    """Centimetres or kilograms in a unit of :mod:`steadyload.layouts.files.dialect`.

    Raises:
        PlanError: there is no such unit.
    """
    if unit not in units:
        raise PlanError(f"the unit is {unit!r}; allowed: {', '.join(units)}")
    return float(units[unit])
