"""Item, Pallet and Layout: frozen, validated once, with arrays for the hot paths.

Lengths in cm, weights in kg, axes as in Section 3 of the paper: x along the width, y up along the
height, z along the depth; (0, 0, 0) is the pallet's left-bottom-back corner, and an item's position
is that of its own left-bottom-back corner.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from steadyload.core import whole
from steadyload.core.constants import TOLERANCE as TOLERANCE
from steadyload.core.whole import Given
from steadyload.errors import required, required_list
from steadyload.escaping import shown
from steadyload.layouts.model.checks import FloatArray as FloatArray
from steadyload.layouts.model.checks import digest_of, unprintable
from steadyload.layouts.model.contacts import Contacts, Supports
from steadyload.layouts.model.floor import Floor, FloorKind
from steadyload.layouts.model.item import SIDES as SIDES
from steadyload.layouts.model.item import WEIGHTS as WEIGHTS
from steadyload.layouts.model.item import Item as Item
from steadyload.layouts.model.item import LayoutError as LayoutError
from steadyload.layouts.model.item import Vector as Vector
from steadyload.layouts.model.pallet import Pallet as Pallet
from steadyload.layouts.model.validity import arrays_of, misplaced
from steadyload.notebook import ShownInNotebook

_NO_ITEMS = "has no items; allowed: one or more"

ARRAYS = ("lower", "upper", "sizes", "weights", "mass_offsets")
"""Names of the arrays of a layout."""


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

    @property
    def given(self) -> Given:
        """See :class:`Layout`."""

    @property
    def supports(self) -> Supports:
        """See :class:`Layout`."""

    def __len__(self) -> int: ...


@dataclass(frozen=True, eq=False, repr=False)
class Layout(ShownInNotebook):
    """A sequence of items on a pallet (A_i in the paper); items are kept in loading order.

    Args:
        name: identifies the layout in a study; printable, not empty.
        pallet: its contour holds all items, to within :data:`TOLERANCE`.
        items: in any order; their sequence numbers must be 0, 1, ..., J - 1.

    Attributes:
        lower, upper: corners [cm], shape (J, 3), columns x, y, z.
        sizes: width, height, depth of items as placed [cm], shape (J, 3).
        weights: [kg], shape (J,). mass_offsets: [cm], shape (J, 3).

    The arrays are read-only. A layout of a :class:`~steadyload.layouts.model.batch.LayoutBatch` is
    a view on those of the batch; its items are made when they are asked for.

    Raises:
        LayoutError: no items, sequence numbers with gaps or duplicates, items that overlap by more
            than :data:`TOLERANCE` along every axis, or an item outside the contour.
    """

    name: str
    pallet: Pallet
    items: tuple[Item, ...]
    lower: FloatArray = field(init=False, repr=False)
    upper: FloatArray = field(init=False, repr=False)
    sizes: FloatArray = field(init=False, repr=False)
    weights: FloatArray = field(init=False, repr=False)
    mass_offsets: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        check_name(self.name)
        required("pallet", self.pallet, Pallet, "a Pallet", LayoutError)
        try:
            items = self._in_order()
            arrays = arrays_of(items)
            vars(self).update(arrays, items=items)
            if (error := misplaced(items, arrays, self.pallet)) is not None:
                raise error
        except LayoutError as error:
            raise error.located(layout=self.name) from None

    def __repr__(self) -> str:
        """One line: name, number of boxes, their weight, and the pallet."""
        width, height, depth = self.pallet.size
        boxes = "1 box" if len(self) == 1 else f"{len(self)} boxes"
        return (
            f"<Layout {self.name!r}: {boxes}, {self.weights.sum():.6g} kg, on a pallet of "
            f"{width:g} x {depth:g} cm, up to {height:g} cm>"
        )

    def __getstate__(self) -> dict[str, Any]:
        """The attributes without contacts, which another process finds where it needs them."""
        found = {"_touching", "contacts", "supports"}
        return {name: value for name, value in vars(self).items() if name not in found}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Arrays that come from another process are read-only as they were there."""
        vars(self).update(state)
        for key in ARRAYS:
            state[key].setflags(write=False)

    def _in_order(self) -> tuple[Item, ...]:
        given = self.items if isinstance(self.items, Iterable) else (self.items,)
        for item in given:
            required("an item", item, Item, "an Item", LayoutError)
        items = tuple(sorted(given, key=lambda i: i.sequence))
        if not items:
            raise LayoutError(_NO_ITEMS)
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

    if not TYPE_CHECKING:  # else every name would count as one that a layout has

        def __getattr__(self, name: str) -> Any:
            """The items of a view, which has none until they are asked for."""
            if name != "items" or "weights" not in vars(self):
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            return vars(self).setdefault("items", self._made_items())

    def _made_items(self) -> tuple[Item, ...]:
        positions, sizes = self.lower.tolist(), self.sizes.tolist()
        offsets, weights = self.mass_offsets.tolist(), self.weights.tolist()
        return tuple(
            Item(k, tuple(position), tuple(size), weight, tuple(offset), name)
            for k, (position, size, weight, offset, name) in enumerate(
                zip(positions, sizes, weights, offsets, self.ids or [""] * len(self), strict=True)
            )
        )

    @cached_property
    def ids(self) -> tuple[str, ...]:
        """Ids of all boxes, in loading order; none where no box has one."""
        names = tuple(item.name for item in self.items)
        return names if any(names) else ()

    @property
    def max_loads(self) -> tuple[float | None, ...]:
        """Loads that the items may bear [kg], in loading order; none where no item states one."""
        # A view on a batch, which has no place for them, makes no items for this.
        loads = tuple(item.max_load for item in vars(self).get("items", ()))
        return loads if any(load is not None for load in loads) else ()

    def __len__(self) -> int:
        return len(self.weights)

    @cached_property
    def floor(self) -> Floor:
        """The floor that the items stand on, as the pallet's ``floor`` and the items decide it."""
        plan_low, plan_high = self.lower[:, ::2], self.upper[:, ::2]
        size = np.array((self.pallet.width, self.pallet.depth))
        out = max(-plan_low.min(), (plan_high - size).max())
        return self.pallet.floor_under(overhung=bool(out > TOLERANCE))

    @cached_property
    def given(self) -> Given:
        """The layout as the C library takes it."""
        return Given(self.lower, self.upper, self.weights, self.mass_offsets, self.floor.corners)

    @cached_property
    def _touching(self) -> whole.Contacts:
        return self.given.contacts()

    @cached_property
    def contacts(self) -> Contacts:
        """Which items touch which, and where, as arrays."""
        return Contacts.of(self._touching)

    @cached_property
    def supports(self) -> Supports:
        """The same as lists by item, which are not to be changed."""
        return Supports.of(self._touching)

    def on(self, floor: FloorKind | str) -> Layout:
        """The same layout on another kind of floor.

        Raises:
            FloorError: there is no such kind.
        """
        pallet = replace(self.pallet, floor=FloorKind.named(floor))
        return self if pallet == self.pallet else self._valid(pallet=pallet)

    def with_floor_kept(self) -> Layout:
        """The same layout, from which others can be derived that stand on the same floor.

        A deck is a deck from then on, also where what is left of the items overhangs no edge.
        """
        return self.on(FloorKind.DECK) if self.floor.has_edges else self

    def first(self, count: int) -> Layout:
        """The layout's first ``count`` items (all of them when it has fewer), on its floor.

        Raises:
            LayoutError: it would have no items.
        """
        if count >= len(self):
            return self
        kept = self.with_floor_kept()
        arrays = {key: getattr(kept, key)[:count] for key in ARRAYS}
        if not len(arrays["weights"]):
            raise LayoutError(_NO_ITEMS, layout=self.name)
        return kept._valid(items=self.items[:count], **arrays)

    def with_mass_offsets(self, offsets: FloatArray) -> Layout:
        """The same geometry with other centres of mass [cm], shape (J, 3).

        Raises:
            LayoutError: one lies outside its item.
        """
        items = tuple(
            replace(item, mass_offset=(float(x), float(y), float(z)))
            for item, (x, y, z) in zip(self.items, offsets, strict=True)
        )
        moved = np.array([item.mass_offset for item in items], dtype=float)
        moved.setflags(write=False)
        return self._valid(items=items, mass_offsets=moved)

    def bearing(self, loads: Sequence[float | None]) -> Layout:
        """The same layout whose items may bear other loads [kg], one an item; None for no limit."""
        pairs = zip(self.items, loads, strict=True)
        return self._valid(items=tuple(replace(item, max_load=load) for item, load in pairs))

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
        """The same layout under another name.

        Raises:
            LayoutError: it is not printable, or empty.
        """
        check_name(name)
        return self._valid(name=name)

    def _valid(
        self,
        *,
        name: str | None = None,
        pallet: Pallet | None = None,
        items: tuple[Item, ...] | None = None,
        **arrays: FloatArray,
    ) -> Layout:
        """A layout that is valid because this one is: nothing is checked again."""
        return view_on(
            {key: getattr(self, key) for key in ARRAYS} | arrays,
            name=self.name if name is None else name,
            pallet=self.pallet if pallet is None else pallet,
            items=self.items if items is None else items,
        )


def check_name(name: str) -> None:
    """Refuse a name that no layout may have.

    Raises:
        LayoutError: it is not printable, or empty.
    """
    if not isinstance(name, str) or not name or not name.isprintable():
        raise LayoutError(unprintable(name))


def require_layout(value: object) -> None:
    """Refuse what is no layout, such as the name of a file of them.

    Raises:
        LayoutError: the value is no layout.
    """
    if not isinstance(value, Layout):
        raise LayoutError(
            f"{shown(value)} is no layout; allowed: a Layout, such as each of those that "
            "steadyload.read(file) gives"
        )


def require_layouts(values: Iterable[Layout]) -> list[Layout]:
    """The layouts of a list.

    Raises:
        WrongTypeError: it is no list.
        LayoutError: one of its elements is no layout.
    """
    each = required_list("layouts", values, "a list of Layouts")
    for layout in each:
        require_layout(layout)
    return each


def view_on(
    arrays: dict[str, FloatArray],
    *,
    name: str,
    pallet: Pallet,
    floor: Floor | None = None,
    ids: tuple[str, ...] = (),
    items: tuple[Item, ...] | None = None,
) -> Layout:
    """A layout on arrays that are known to be valid: nothing is checked, copied or made.

    Args:
        arrays: those of a :class:`Layout`, by name, read-only.
        name: see :class:`Layout`.
        pallet: likewise.
        floor: that of these items on this pallet; None where it is to be found.
        ids: of all boxes, or none; those of ``items`` where these are given.
        items: in loading order; None makes them when they are asked for.
    """
    layout = object.__new__(Layout)
    vars(layout).update(arrays, name=name, pallet=pallet)
    vars(layout).update({"ids": ids} if items is None else {"items": items})
    if floor is not None:
        vars(layout)["floor"] = floor
    return layout


def replace_items(layout: Layout, items: tuple[Item, ...]) -> Layout:
    """A layout of the same name, on the same pallet, with other items."""
    return Layout(layout.name, layout.pallet, items)
