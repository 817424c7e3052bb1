"""Pallets: the deck that carries a layout, and the contour that its items must stay in."""

from __future__ import annotations

from dataclasses import dataclass, field

from steadyload.layouts.model.checks import is_number
from steadyload.layouts.model.floor import (
    DECK_HEIGHT,
    INFINITE,
    OVERHANG,
    Floor,
    FloorError,
    FloorKind,
)
from steadyload.layouts.model.frame import Length, Part, SideName
from steadyload.layouts.model.item import SIDES, LayoutError, Vector, length_refused, not_a_number


@dataclass(frozen=True, slots=True)
class Pallet:
    """A deck that carries, and the contour that items must stay in.

    Args:
        width: of the deck, along x [cm], positive.
        height: up to which items may be, along y [cm], positive.
        depth: of the deck, along z [cm], positive.
        overhang: how far items may stand out over the edges of the deck [cm], 0 or more.
        deck_height: of the deck above the ground [cm], positive.
        floor: what the items stand on; see :class:`steadyload.layouts.model.floor.FloorKind`.

    Raises:
        LayoutError: a side is outside :data:`SIDES`, or another value is not allowed.
    """

    width: float
    height: float
    depth: float
    overhang: float = field(default=OVERHANG, kw_only=True)
    deck_height: float = field(default=DECK_HEIGHT, kw_only=True)
    floor: FloorKind = field(default=FloorKind.AUTO, kw_only=True)

    def __post_init__(self) -> None:
        names: tuple[Part, ...] = (*map(SideName, range(3)), "deck_height")
        for name, value in zip(names, (*self.size, self.deck_height), strict=True):
            if not is_number(value):
                raise LayoutError("pallet ", name, *not_a_number(value))
            if not SIDES[0] <= value <= SIDES[1]:
                raise LayoutError("pallet ", name, *length_refused(value))
        if not is_number(self.overhang):
            raise LayoutError("pallet overhang", *not_a_number(self.overhang))
        if not 0.0 <= self.overhang <= SIDES[1]:
            raise LayoutError(
                "pallet overhang is ", Length(self.overhang), "; allowed: a number, 0 to ",
                Length(SIDES[1]),
            )  # fmt: skip
        try:
            object.__setattr__(self, "floor", FloorKind.named(self.floor))
        except FloorError as error:
            raise LayoutError(f"pallet {error}") from None

    @property
    def size(self) -> Vector:
        """Width, height, depth [cm]."""
        return (self.width, self.height, self.depth)

    @property
    def contour(self) -> tuple[Vector, Vector]:
        """Opposite corners of the space that items must stay in [cm]."""
        width, height, depth = self.size
        out = self.overhang
        return (0.0 - out, 0.0, 0.0 - out), (width + out, height, depth + out)

    def floor_under(self, *, overhung: bool) -> Floor:
        """The floor of items on this pallet.

        Args:
            overhung: an item stands out over an edge of the deck.
        """
        kind = self.floor
        if kind is FloorKind.INFINITE or (kind is FloorKind.AUTO and not overhung):
            return INFINITE
        return Floor((0.0, 0.0), (self.width, self.depth), self.deck_height)
