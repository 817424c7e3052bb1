"""Item, Pallet and Layout: frozen, validated once, with arrays for the hot paths.

Lengths in cm, weights in kg, axes as in Section 3 of the paper: x along the width, y up along the
height, z along the depth; (0, 0, 0) is the pallet's left-bottom-back corner, and an item's position
is that of its own left-bottom-back corner.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from steadyload.errors import UserError
from steadyload.escaping import printable
from steadyload.kernels.constants import TOLERANCE as TOLERANCE
from steadyload.layouts.checks import (
    SHOWN,
    allowed_range,
    digest_of,
    is_number,
    is_vector,
    unprintable,
)
from steadyload.layouts.floor import DECK_HEIGHT, INFINITE, OVERHANG, Floor, FloorError, FloorKind
from steadyload.layouts.naming import box_label

FloatArray = NDArray[np.float64]
Vector = tuple[float, float, float]

SIDES = (0.05, 100_000.0)
"""Allowed lengths [cm] of items and pallets: clearly above :data:`TOLERANCE`, up to a kilometre."""

WEIGHTS = (1e-9, 1e6)
"""Allowed weights [kg]."""

_AXES = ("x", "y", "z")
_SIZES = ("width", "height", "depth")
_BLOCK = 256


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

    def __str__(self) -> str:
        places = [self.file]
        places.append(f'layout "{printable(self.layout, SHOWN)}"' if self.layout else None)
        # What is no label of a box is the number of an item.
        item = printable(self.item or "", SHOWN)
        places.append(item if " " in item else f"item {item}" if item else None)
        return ": ".join([p for p in places if p] + [self.message])


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

    Raises:
        LayoutError: a value is not allowed.
    """

    sequence: int
    position: Vector
    size: Vector
    weight: float
    mass_offset: Vector = (0.0, 0.0, 0.0)
    name: str = ""

    def __post_init__(self) -> None:
        for label in ("position", "size", "mass_offset"):
            if not is_vector(getattr(self, label)):
                found = getattr(self, label)
                self._refuse(f"{label} is {found!r}; allowed: three numbers")
        if not is_number(self.weight):
            self._refuse(f"weight is {self.weight!r}; allowed: a number [kg]")
        if not self.name.isprintable():
            raise LayoutError(unprintable(self.name), item=str(self.sequence))
        if type(self.sequence) is not int or self.sequence < 0:
            self._refuse(f"sequence is {self.sequence!r}; allowed: 0, 1, 2, ...")
        for axis, value in zip(_AXES, self.position, strict=True):
            if not math.isfinite(value):
                self._refuse(f"position {axis} is {value:g} cm; allowed: a finite number")
        for side, value in zip(_SIZES, self.size, strict=True):
            if not SIDES[0] <= value <= SIDES[1]:
                self._refuse(f"{side} is {value:g} cm; {allowed_range(SIDES)}")
        if not WEIGHTS[0] <= self.weight <= WEIGHTS[1]:
            self._refuse(f"weight is {self.weight:g} kg; {allowed_range(WEIGHTS)}")
        for axis, value, length in zip(_AXES, self.mass_offset, self.size, strict=True):
            if not abs(value) <= length / 2.0:
                self._refuse(
                    f"centre-of-mass offset {axis} is {value:g} cm; allowed: inside the item, "
                    f"-{length / 2.0:g} to {length / 2.0:g} cm"
                )

    def __str__(self) -> str:
        return box_label(self.sequence, self.name)

    def _refuse(self, message: str) -> None:
        raise LayoutError(message, item=str(self))


@dataclass(frozen=True, slots=True)
class Pallet:
    """A deck that carries, and the contour that items must stay in.

    Args:
        width: of the deck, along x [cm], positive.
        height: up to which items may be, along y [cm], positive.
        depth: of the deck, along z [cm], positive.
        overhang: how far items may stand out over the edges of the deck [cm], 0 or more.
        deck_height: of the deck above the ground [cm], positive.
        floor: what the items stand on; see :class:`steadyload.layouts.floor.FloorKind`.

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
        sides = (*zip(_SIZES, self.size, strict=True), ("deck_height", self.deck_height))
        for side, value in sides:
            if not is_number(value):
                raise LayoutError(f"pallet {side} is {value!r}; allowed: a number [cm]")
            if not SIDES[0] <= value <= SIDES[1]:
                raise LayoutError(f"pallet {side} is {value:g} cm; {allowed_range(SIDES)}")
        if not is_number(self.overhang):
            raise LayoutError(f"pallet overhang is {self.overhang!r}; allowed: a number [cm]")
        if not 0.0 <= self.overhang <= SIDES[1]:
            raise LayoutError(
                f"pallet overhang is {self.overhang:g} cm; allowed: a number, 0 to {SIDES[1]:g}"
            )
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

    def is_overhung(self, low: Vector, high: Vector) -> bool:
        """True if an item with these corners stands out over an edge by over :data:`TOLERANCE`."""
        out = max(-low[0], -low[2], high[0] - self.width, high[2] - self.depth)
        return out > TOLERANCE


class Arrangement(Protocol):
    """Items at their places: a :class:`Layout`, or one that still grows."""

    @property
    def name(self) -> str:
        """See :class:`Layout`."""

    @property
    def pallet(self) -> Pallet:
        """See :class:`Layout`."""

    @property
    def floor(self) -> Floor:
        """See :class:`Layout`."""

    @property
    def lower(self) -> FloatArray:
        """See :class:`Layout`."""

    @property
    def upper(self) -> FloatArray:
        """See :class:`Layout`."""

    @property
    def weights(self) -> FloatArray:
        """See :class:`Layout`."""

    @property
    def mass_offsets(self) -> FloatArray:
        """See :class:`Layout`."""

    def __len__(self) -> int: ...


@dataclass(frozen=True, eq=False)
class Layout:
    """A sequence of items on a pallet (A_i in the paper); items are kept in loading order.

    Args:
        name: identifies the layout in a study; printable, not empty.
        pallet: its contour holds all items, to within :data:`TOLERANCE`.
        items: in any order; their sequence numbers must be 0, 1, ..., J - 1.

    Attributes:
        lower, upper: corners [cm], shape (J, 3), columns x, y, z.
        weights: [kg], shape (J,). mass_offsets: [cm], shape (J, 3).

    The arrays are read-only.

    Raises:
        LayoutError: no items, sequence numbers with gaps or duplicates, items that overlap by more
            than :data:`TOLERANCE` along every axis, or an item outside the contour.
    """

    name: str
    pallet: Pallet
    items: tuple[Item, ...]
    lower: FloatArray = field(init=False, repr=False)
    upper: FloatArray = field(init=False, repr=False)
    weights: FloatArray = field(init=False, repr=False)
    mass_offsets: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if not self.name or not self.name.isprintable():
            raise LayoutError(unprintable(self.name))
        try:
            items = self._in_order()
            lower = np.array([i.position for i in items], dtype=float)
            arrays = {
                "lower": lower,
                "upper": lower + np.array([i.size for i in items], dtype=float),
                "weights": np.array([i.weight for i in items], dtype=float),
                "mass_offsets": np.array([i.mass_offset for i in items], dtype=float),
            }
            object.__setattr__(self, "items", items)
            for key, array in arrays.items():
                array.setflags(write=False)
                object.__setattr__(self, key, array)
            self._check_contour()
            self._check_overlaps()
        except LayoutError as error:
            raise error.located(layout=self.name) from None

    def _in_order(self) -> tuple[Item, ...]:
        if not self.items:
            raise LayoutError("has no items; allowed: one or more")
        items = tuple(sorted(self.items, key=lambda i: i.sequence))
        for expected, item in enumerate(items):
            if item.sequence < expected:
                raise LayoutError(
                    f"sequence {item.sequence} stands there twice; "
                    f"allowed: each of 0 to {len(items) - 1} once",
                    item=str(item),
                )
            if item.sequence > expected:
                raise LayoutError(
                    f"sequence {expected} is missing before {item.sequence}; "
                    f"allowed: each of 0 to {len(items) - 1} once",
                    item=str(item),
                )
        return items

    def _check_contour(self) -> None:
        low, high = np.array(self.pallet.contour)
        outside = np.maximum(low - self.lower, self.upper - high)
        if outside.max() <= TOLERANCE:
            return
        index, axis = (int(k) for k in np.unravel_index(int(outside.argmax()), outside.shape))
        span = (float(self.lower[index, axis]), float(self.upper[index, axis]))
        raise outside_error(self.items[index], self.pallet, axis, span)

    def _check_overlaps(self) -> None:
        lower, upper = self.lower, self.upper
        for start in range(0, len(self.items), _BLOCK):
            block = slice(start, start + _BLOCK)
            shared = np.minimum(upper[block, None], upper[None]) - np.maximum(
                lower[block, None], lower[None]
            )
            depth = shared.min(axis=2)
            depth[np.arange(len(depth)), np.arange(start, start + len(depth))] = -np.inf
            if depth.max() > TOLERANCE:
                row, other = np.unravel_index(int(depth.argmax()), depth.shape)
                first, second = sorted((int(row) + start, int(other)))
                raise overlap_error(self.items[second], self.items[first], float(depth.max()))

    def __len__(self) -> int:
        return len(self.items)

    @cached_property
    def floor(self) -> Floor:
        """The floor that the items stand on, as the pallet's ``floor`` and the items decide it."""
        plan_low, plan_high = self.lower[:, ::2], self.upper[:, ::2]
        size = np.array((self.pallet.width, self.pallet.depth))
        out = max(-plan_low.min(), (plan_high - size).max())
        return self.pallet.floor_under(overhung=bool(out > TOLERANCE))

    def on(self, floor: FloorKind | str) -> Layout:
        """The same layout on another kind of floor.

        Raises:
            FloorError: there is no such kind.
        """
        pallet = replace(self.pallet, floor=FloorKind.named(floor))
        return self if pallet == self.pallet else Layout(self.name, pallet, self.items)

    def with_floor_kept(self) -> Layout:
        """The same layout, from which others can be derived that stand on the same floor.

        A deck is a deck from then on, also where what is left of the items overhangs no edge.
        """
        return self.on(FloorKind.DECK) if self.floor.has_edges else self

    def first(self, count: int) -> Layout:
        """The layout's first ``count`` items (all of them when it has fewer), on its floor."""
        if count >= len(self.items):
            return self
        return replace_items(self.with_floor_kept(), self.items[:count])

    def with_mass_offsets(self, offsets: FloatArray) -> Layout:
        """The same geometry with other centres of mass [cm], shape (J, 3)."""
        return replace_items(
            self,
            tuple(
                replace(item, mass_offset=(float(x), float(y), float(z)))
                for item, (x, y, z) in zip(self.items, offsets, strict=True)
            ),
        )

    def geometry_hash(self) -> str:
        """SHA-256 of the items' positions and sizes alone, as hex digits."""
        return digest_of(self.lower, self.upper)

    def content_hash(self) -> str:
        """SHA-256 of everything that a verdict may depend on (names are not), as hex digits."""
        pallet = np.array(self.pallet.size)
        # A plane has no entry, so that layouts on one keep the hashes from before there were decks.
        deck = np.array([self.floor.height] if self.floor.has_edges else [])
        return digest_of(self.lower, self.upper, self.weights, self.mass_offsets, pallet, deck)

    def renamed(self, name: str) -> Layout:
        """The same layout under another name."""
        return replace_items(self, self.items, name=name)


def replace_items(layout: Layout, items: tuple[Item, ...], *, name: str | None = None) -> Layout:
    """A layout on the same pallet with other items."""
    return Layout(layout.name if name is None else name, layout.pallet, items)


def outside_error(item: Item, pallet: Pallet, axis: int, span: tuple[float, float]) -> LayoutError:
    """Error message for an item that stands out of the pallet's contour along an axis."""
    low, high = pallet.contour
    deck = f": up to {pallet.overhang:g} cm over the edge of the deck" if low[axis] else ""
    return LayoutError(
        f"spans {_AXES[axis]} = {span[0]:g} to {span[1]:g} cm; allowed: inside the pallet's "
        f"contour, {low[axis]:g} to {high[axis]:g} cm (+-{TOLERANCE:g}){deck}",
        item=str(item),
    )


def overlap_error(item: Item, other: Item, depth: float) -> LayoutError:
    """Error message for an item that overlaps one placed before it, by a depth [cm]."""
    return LayoutError(
        f"overlaps {other} by {depth:g} cm along every axis; allowed: at most {TOLERANCE:g} cm",
        item=str(item),
    )
