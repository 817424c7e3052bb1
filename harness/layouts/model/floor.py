"""The floor that a layout stands on: an infinite plane, or the pallet's deck with its edges."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from steadyload.errors import UserError, nearest
from steadyload.escaping import shown

DECK_HEIGHT = 14.4
"""Height [cm] of a deck above the ground unless a file states another: that of a Euro pallet."""

OVERHANG = 10.0
"""How far [cm] items may stand out over the edges of a deck unless another limit is given."""

_AT = (-math.inf, -math.inf)
_TO = (math.inf, math.inf)


class FloorError(UserError):
    """A kind of floor that there is not; says what is allowed."""


class FloorKind(StrEnum):
    """Kind of floor that items stand on.

    ``auto``: the deck where an item overhangs it, the infinite plane where none does. ``deck``: the
    pallet's deck, beyond whose edges nothing carries, above the ground. ``infinite``: a plane at
    the height of the deck, without edges.
    """

    AUTO = "auto"
    DECK = "deck"
    INFINITE = "infinite"

    @classmethod
    def named(cls, name: str) -> FloorKind:
        """The kind of this name.

        Raises:
            FloorError: there is none.
        """
        if not isinstance(name, str) or name not in list(cls):
            known = nearest(name if isinstance(name, str) else "", list(cls))
            raise FloorError(f"floor is {shown(name)}; {known}")
        return cls(name)


class Surface(NamedTuple):
    """A level surface that carries: its height and its corners in (x, z) [cm]."""

    level: float
    low: tuple[float, float]
    high: tuple[float, float]


@dataclass(frozen=True)
class Floor:
    """A floor at y = 0, as those see it who judge a layout.

    Attributes:
        low, high: corners in (x, z) of what carries [cm]; infinite for a plane.
        height: above the ground that is beyond the edges [cm]; 0 for a plane.
    """

    low: tuple[float, float] = _AT
    high: tuple[float, float] = _TO
    height: float = 0.0

    @property
    def has_edges(self) -> bool:
        """True for a deck, False for an infinite plane."""
        return self.height > 0.0

    @cached_property
    def corners(self) -> NDArray[np.float64]:
        """x0, z0, x1, z1 of what carries and the height [cm], as C takes them, shape (5,)."""
        found = np.array([*self.low, *self.high, self.height])
        found.setflags(write=False)
        return found

    def __reduce__(self) -> tuple[type[Floor], tuple[Any, ...]]:
        """Without :attr:`corners`: arrays of a pickle can be written to."""
        return type(self), (self.low, self.high, self.height)

    @property
    def kind(self) -> FloorKind:
        """The kind that it is: deck or infinite."""
        return FloorKind.DECK if self.has_edges else FloorKind.INFINITE

    def surfaces(self) -> tuple[Surface, ...]:
        """All that carries: the floor, and the ground below a deck."""
        floor = Surface(0.0, self.low, self.high)
        return (floor, Surface(-self.height, _AT, _TO)) if self.has_edges else (floor,)


INFINITE = Floor()
