"""Items, what their numbers may be, and the error of a layout in which something is not allowed."""

from __future__ import annotations

import math
from dataclasses import dataclass

from steadyload.errors import UserError
from steadyload.escaping import printable, sentence, shown
from steadyload.layouts.checks import (
    SHOWN,
    allowed_range,
    is_number,
    is_vector,
    unprintable,
)
from steadyload.layouts.naming import box_label

Vector = tuple[float, float, float]

SIDES = (0.05, 100_000.0)
"""Allowed lengths [cm] of items and pallets: clearly above :data:`TOLERANCE`, up to a kilometre."""

WEIGHTS = (1e-9, 1e6)
"""Allowed weights [kg]."""

MOST_LOAD = 1e9
"""Largest load [kg] that an item may be said to bear."""

AXES = ("x", "y", "z")
SIDE_NAMES = ("width", "height", "depth")


class LayoutError(UserError):
    """An invalid layout: says where (file, layout, item), what, and what is allowed."""

    def __init__(
        self,
        message: str,
        *,
        file: str | None = None,
        layout: str | None = None,
        item: str | None = None,
    ) -> None:
        super().__init__(message)
        self.message, self.file, self.layout, self.item = message, file, layout, item

    def located(self, *, file: str | None = None, layout: str | None = None) -> LayoutError:
        """The same error with further places: file, layout or item."""
        return type(self)(
            self.message, file=self.file or file, layout=self.layout or layout, item=self.item
        )

    def explained(self, words: str) -> LayoutError:
        """The same error with some words more."""
        return type(self)(self.message + words, file=self.file, layout=self.layout, item=self.item)

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
            :mod:`steadyload.bearing`.

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
            self._refuse(f"weight is {shown(self.weight)}; allowed: a number [kg]")
        if not self.name.isprintable():
            raise LayoutError(unprintable(self.name), item=str(self.sequence))
        if type(self.sequence) is not int or self.sequence < 0 or not is_number(self.sequence):
            told = f"sequence is {shown(self.sequence)}; allowed: 0, 1, 2, ..."
            raise LayoutError(told, item=box_label(shown(self.sequence), self.name))
        for axis, value in zip(AXES, self.position, strict=True):
            if not math.isfinite(value):
                self._refuse(f"position {axis} is {value:g} cm; allowed: a finite number")
        for side, value in zip(SIDE_NAMES, self.size, strict=True):
            if not SIDES[0] <= value <= SIDES[1]:
                self._refuse(f"{side} is {value:g} cm; {allowed_range(SIDES)}")
        if not WEIGHTS[0] <= self.weight <= WEIGHTS[1]:
            self._refuse(f"weight is {self.weight:g} kg; {allowed_range(WEIGHTS)}")
        if self.max_load is not None:
            if not is_number(self.max_load):
                self._refuse(f"max_load is {shown(self.max_load)}; allowed: a number [kg]")
            if not 0.0 <= self.max_load <= MOST_LOAD:
                self._refuse(f"max_load is {self.max_load:g} kg; allowed: 0 to {MOST_LOAD:g}")
        for axis, value, length in zip(AXES, self.mass_offset, self.size, strict=True):
            if not abs(value) <= length / 2.0:
                self._refuse(
                    f"centre-of-mass offset {axis} is {value:g} cm; allowed: inside the item, "
                    f"-{length / 2.0:g} to {length / 2.0:g} cm"
                )

    def __str__(self) -> str:
        return box_label(self.sequence, self.name)

    def _refuse(self, message: str) -> None:
        raise LayoutError(message, item=str(self))
