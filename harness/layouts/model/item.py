"""Items, what their numbers may be, and the error of a layout in which something is not allowed."""

from __future__ import annotations

import math
from dataclasses import dataclass

from steadyload.errors import UserError
from steadyload.escaping import printable, sentence, shown
from steadyload.layouts.model.checks import SHOWN, is_number, is_vector, unprintable
from steadyload.layouts.model.frame import (
    AxisName,
    Frame,
    Length,
    Part,
    SideName,
    UnitName,
    Weight,
    worded,
)
from steadyload.layouts.model.naming import box_label

Vector = tuple[float, float, float]

SIDES = (0.05, 100_000.0)
"""Allowed lengths [cm] of items and pallets: clearly above :data:`TOLERANCE`, up to a kilometre."""

WEIGHTS = (1e-9, 1e6)
"""Allowed weights [kg]."""

MOST_LOAD = 1e9
"""Largest load [kg] that an item may be said to bear."""

_POSITIVE = "; allowed: a positive finite number, "


class LayoutError(UserError):
    """An invalid layout: says where (file, layout, item), what, and what is allowed.

    Args:
        parts: of the message; lengths, weights and axes among them are said as ``frame`` has them.
        file, layout, item: where it is; None where that is not known.
        frame: axes and units of the message; None for ours.
    """

    def __init__(
        self,
        *parts: Part,
        file: str | None = None,
        layout: str | None = None,
        item: str | None = None,
        frame: Frame | None = None,
    ) -> None:
        super().__init__(*parts)
        self.parts, self.frame = parts, frame or Frame()
        self.file, self.layout, self.item = file, layout, item

    @property
    def message(self) -> str:
        """The fault and what is allowed, without the places."""
        return worded(self.parts, self.frame)

    def located(
        self, *, file: str | None = None, layout: str | None = None, item: str | None = None
    ) -> LayoutError:
        """The same error with further places: file, layout or item."""
        return type(self)(
            *self.parts, file=self.file or file, layout=self.layout or layout,
            item=self.item or item, frame=self.frame,
        )  # fmt: skip

    def framed(self, frame: Frame) -> LayoutError:
        """The same error in the axes and units of a file."""
        return type(self)(
            *self.parts, file=self.file, layout=self.layout, item=self.item, frame=frame
        )

    def adding(self, *parts: Part) -> LayoutError:
        """The same error with more at its end."""
        return type(self)(
            *self.parts, *parts, file=self.file, layout=self.layout, item=self.item,
            frame=self.frame,
        )  # fmt: skip

    def __str__(self) -> str:
        places = [self.file]
        places.append(f'layout "{printable(self.layout, SHOWN)}"' if self.layout else None)
        # What is no label of a box is the number of an item.
        item = printable(self.item or "", SHOWN)
        places.append(item if " " in item else f"item {item}" if item else None)
        return sentence(": ".join([p for p in places if p] + [self.message]))


@dataclass(frozen=True, slots=True)
class Item:
    """One box as it is to be placed.

    Args:
        sequence: place in the loading order, counted from 0.
        position: left-bottom-back corner (x, y, z) [cm], finite.
        size: width, height, depth as placed [cm], within :data:`SIDES`.
        weight: [kg], within :data:`WEIGHTS`.
        mass_offset: centre of mass minus geometric centre (x, y, z) [cm]; at most half a side.
        name: the id of the box, such as an SKU, by which messages name it; printable characters,
            need not be unique. No verdict depends on it.
        max_load: the load that its top may bear [kg], 0 or more, up to :data:`MOST_LOAD`; None
            where no limit is stated. Methods judge stability and do not look at it; see
            :mod:`steadyload.statics.bearing`.

    Raises:
        LayoutError: a value is not allowed.
    """

    sequence: int
    position: Vector
    size: Vector
    weight: float
    mass_offset: Vector = (0.0, 0.0, 0.0)
    name: str = ""
    max_load: float | None = None

    def __post_init__(self) -> None:
        for label in ("position", "size", "mass_offset"):
            if not is_vector(getattr(self, label)):
                found = getattr(self, label)
                self._refuse(f"{label} is {shown(found)}; allowed: three numbers")
        if not is_number(self.weight):
            self._refuse("weight", *not_a_number(self.weight, weight=True))
        if not isinstance(self.name, str) or not self.name.isprintable():
            raise LayoutError(unprintable(self.name), item=shown(self.sequence))
        if type(self.sequence) is not int or self.sequence < 0 or not is_number(self.sequence):
            told = f"sequence is {shown(self.sequence)}; allowed: 0, 1, 2, ..."
            raise LayoutError(told, item=f"item {shown(self.sequence)}")
        for axis, value in enumerate(self.position):
            if not math.isfinite(value):
                self._refuse(
                    "position ", AxisName(axis), " is ", Length(value), "; allowed: a finite number"
                )
        for axis, value in enumerate(self.size):
            if not SIDES[0] <= value <= SIDES[1]:
                self._refuse(SideName(axis), *length_refused(value))
        if not WEIGHTS[0] <= self.weight <= WEIGHTS[1]:
            self._refuse(
                "weight is ", Weight(self.weight), _POSITIVE, Weight(WEIGHTS[0], bare=True), " to ",
                Weight(WEIGHTS[1]),
            )  # fmt: skip
        if self.max_load is not None:
            if not is_number(self.max_load):
                self._refuse("max_load", *not_a_number(self.max_load, weight=True))
            if not 0.0 <= self.max_load <= MOST_LOAD:
                most = Weight(MOST_LOAD)
                self._refuse("max_load is ", Weight(self.max_load), "; allowed: 0 to ", most)
        for axis, (value, length) in enumerate(zip(self.mass_offset, self.size, strict=True)):
            if not abs(value) <= length / 2.0:
                self._refuse(
                    "centre-of-mass offset ", AxisName(axis), " is ", Length(value), "; allowed: "
                    "inside the item, ", Length(-length / 2.0, bare=True), " to ",
                    Length(length / 2.0),
                )  # fmt: skip

    def __str__(self) -> str:
        return box_label(self.sequence, self.name)

    def _refuse(self, *parts: Part) -> None:
        raise LayoutError(*parts, item=str(self))


def not_a_number(value: object, *, weight: bool = False, per: str = "") -> tuple[Part, ...]:
    """End of a message on what is no number: of lengths, or a weight, ``per`` such as "/m2"."""
    return (f" is {shown(value)}; allowed: a number [", UnitName(weights=weight), f"{per}]")


def length_refused(cm: float) -> tuple[Part, ...]:
    """End of a message on a side [cm] of an item or a pallet that is not within :data:`SIDES`."""
    return (" is ", Length(cm), _POSITIVE, Length(SIDES[0], bare=True), " to ", Length(SIDES[1]))
