"""Axes and units in which a message speaks of a layout: those of the file that it was read from.

A message that is worded before its file is known is made of texts and of :data:`Part` objects,
which keep lengths in cm, weights in kg and our axes; :func:`worded` puts them into words.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from steadyload.errors import required
from steadyload.layouts.model.units import UNITS, WEIGHT_UNITS

_DECIMALS = {"mm": 0, "cm": 1, "m": 3, "in": 2}
"""Of a length; one more tells 0.1 mm apart, the tolerance."""

_SIDES = ("width", "height", "depth")


class Form(Protocol):
    """The axes and units that a file states; a :class:`Dialect` is one."""

    @property
    def units(self) -> str:
        """Of lengths, a key of :data:`UNITS`."""

    @property
    def weight(self) -> str:
        """Unit of weights, a key of :data:`WEIGHT_UNITS`."""

    @property
    def up(self) -> str:
        """The axis that points up, ``y`` or ``z``."""


@dataclass(frozen=True, slots=True)
class Frame:
    """Names of axes and the units of messages; ours unless a file has others.

    Attributes:
        axes: what the file calls our x, y and z.
        unit: of lengths, a key of :data:`UNITS`.
        weight: unit of weights, a key of :data:`WEIGHT_UNITS`.
    """

    axes: tuple[str, str, str] = ("x", "y", "z")
    unit: str = "cm"
    weight: str = "kg"

    @classmethod
    def of(cls, form: Form | None) -> Frame:
        """The frame of files of a form; None for those of ours."""
        if form is None:
            return cls()
        return cls(("y", "z", "x") if form.up == "z" else cls().axes, form.units, form.weight)

    @classmethod
    def given(cls, frame: Frame | None) -> Frame:
        """The frame that a caller gave, or ours for None.

        Raises:
            WrongTypeError: it is neither.
        """
        return cls() if frame is None else required("frame", frame, cls, "a Frame, or None")

    @property
    def decimals(self) -> int:
        """Of a length in a sentence."""
        return _DECIMALS[self.unit]

    @property
    def cm(self) -> float:
        """Centimetres in the unit of lengths."""
        return float(UNITS[self.unit])

    @property
    def kg(self) -> float:
        """Kilograms in the unit of weights."""
        return float(WEIGHT_UNITS[self.weight])

    def length(self, cm: float, *, finely: bool = False) -> str:
        """A length [cm] with its unit: "4.0 cm", "40 mm"; one that is not 0 never reads 0.

        Args:
            cm: the length [cm].
            finely: to 0.1 mm, where that takes one more decimal: "2.01 cm", "20.1 mm".
        """
        value = cm / self.cm
        text = f"{value:.{self.decimals + finely}f}"
        if finely:
            text = text.removesuffix("0").removesuffix(".")
        return f"{value:.1g} {self.unit}" if value and not float(text) else f"{text} {self.unit}"

    def stated(self, cm: float) -> str:
        """A length [cm] as a file would state it: to the sixth decimal, without its unit."""
        value = cm / self.cm
        rounded = round(value, 6)
        return f"{rounded:.12g}" if rounded or not value else f"{value:g}"

    def weighed(self, kg: float) -> str:
        """A weight [kg] as a file would state it, without its unit."""
        return f"{kg / self.kg:.12g}"

    @property
    def spoken_weight(self) -> str:
        """The unit in which people read weights, a key of :data:`WEIGHT_UNITS`: kg, not g."""
        return "kg" if self.weight == "g" else self.weight

    @property
    def spoken_kg(self) -> float:
        """Kilograms in the unit in which people read weights."""
        return float(WEIGHT_UNITS[self.spoken_weight])

    def spoken(self, kg: float, *, finely: bool = False) -> str:
        """A weight [kg] as people read it: "247.3 kg", and "2.54 kg" or "0.125 kg" below 10 kg.

        Args:
            kg: the weight [kg].
            finely: with nine digits.
        """
        value = kg / self.spoken_kg
        text = f"{round(value, 1):.12g}" if value >= 10.0 else f"{value:.3g}"
        text = f"{value:.9g}" if finely else text
        return f"{text} {self.spoken_weight}"

    def in_plan(self, width: float, depth: float) -> tuple[float, float]:
        """Lengths along our x and z in the order of the file's axes."""
        return (width, depth) if self.axes[0] < self.axes[2] else (depth, width)

    def side(self, axis: int) -> str:
        """The side of a box along our axis 0, 1 or 2.

        Where the file's axes differ from ours, so may its words for the horizontal sides, and the
        axis is named.
        """
        ours = axis == 1 or self.axes == Frame().axes
        return _SIDES[axis] if ours else f"side along {self.axes[axis]}"


@dataclass(frozen=True, slots=True)
class Length:
    """A length in a message [cm]; ``bare``: without its unit, as where that follows."""

    cm: float
    bare: bool = False

    def said(self, frame: Frame) -> str:
        """In the unit of the file."""
        return frame.stated(self.cm) + f" {frame.unit}" * (not self.bare)


@dataclass(frozen=True, slots=True)
class Weight:
    """A weight in a message [kg]; ``bare``: without its unit."""

    kg: float
    bare: bool = False

    def said(self, frame: Frame) -> str:
        """In the unit of the file."""
        return frame.weighed(self.kg) + f" {frame.weight}" * (not self.bare)


@dataclass(frozen=True, slots=True)
class AxisName:
    """Our axis 0, 1 or 2 in a message."""

    axis: int

    def said(self, frame: Frame) -> str:
        """As the file calls it."""
        return frame.axes[self.axis]


@dataclass(frozen=True, slots=True)
class SideName:
    """The side of a box along our axis 0, 1 or 2 in a message."""

    axis: int

    def said(self, frame: Frame) -> str:
        """As the file calls it."""
        return frame.side(self.axis)


@dataclass(frozen=True, slots=True)
class UnitName:
    """The unit of lengths, or that of ``weights``, in a message."""

    weights: bool = False

    def said(self, frame: Frame) -> str:
        """That of the file."""
        return frame.weight if self.weights else frame.unit


Part = str | Length | Weight | AxisName | SideName | UnitName
"""Part of a message: a text, or what a frame puts into words."""


def worded(parts: Sequence[Part], frame: Frame) -> str:
    """A message in the axes and units of a frame."""
    return "".join(part if isinstance(part, str) else part.said(frame) for part in parts)
