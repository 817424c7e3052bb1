"""A layout that grows item by item, and shrinks again, at a cost independent of its size."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from steadyload.core.constants import OUTSIDE, OVERLAPS, STANDS
from steadyload.core.library import Finding
from steadyload.core.session import Boxes, Session
from steadyload.core.whole import Given
from steadyload.layouts.model.contacts import Patch, Supports
from steadyload.layouts.model.floor import Floor, FloorKind
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import (
    TOLERANCE,
    FloatArray,
    Item,
    Layout,
    LayoutError,
    Pallet,
    check_name,
    view_on,
)
from steadyload.layouts.model.validity import arrays_of, misplaced

_AT_ONCE = 100
"""Positions that one call of the C library looks at: between two, a user can interrupt."""


class GrowingLayout:
    """The items loaded so far, with the items each one stands on and those near it.

    What is true of a :class:`Layout` of the same items is true of it at any time, numbers included
    to the last bit. It is kept in the C library, whose rules judge items as they place them.

    Args:
        pallet: its contour holds all items, to within :data:`TOLERANCE`.
        name: as of a :class:`Layout`.

    Attributes:
        items: in loading order; their sequence numbers count from 0.
    """

    def __init__(self, pallet: Pallet, name: str) -> None:
        self.pallet, self.name = pallet, name
        self.items: list[Item] = []
        self._session = Session(limits_of(pallet))
        self._boxes: Boxes | None = None
        self._supports: Supports | None = None

    def __len__(self) -> int:
        return len(self.items)

    @property
    def floor(self) -> Floor:
        """The floor that the items stand on; an ``auto`` one follows what is loaded by now."""
        return self.pallet.floor_under(overhung=self._session.overhung > 0)

    @property
    def lower(self) -> FloatArray:
        """Lower corners [cm], shape (J, 3), columns x, y, z: read-only as the others."""
        lower: FloatArray = self._arrays().lower
        return lower

    @property
    def upper(self) -> FloatArray:
        """Upper corners [cm], shape (J, 3)."""
        upper: FloatArray = self._arrays().upper
        return upper

    @property
    def mass_offsets(self) -> FloatArray:
        """Centres of mass minus geometric centres [cm], shape (J, 3)."""
        offsets: FloatArray = self._arrays().offsets
        return offsets

    @property
    def weights(self) -> FloatArray:
        """[kg], shape (J,)."""
        weights: FloatArray = self._arrays().weights
        return weights

    @property
    def given(self) -> Given:
        """The items as the C library takes whole layouts."""
        lower, upper, offsets, weights = self._arrays()
        return Given(lower, upper, weights, offsets, self.floor.corners)

    @property
    def supports(self) -> Supports:
        """Vertical contacts between the items; from the first look on they are kept up to date."""
        if self._supports is None:
            self._supports = Supports([], [], [])
            for item in range(len(self.items)):
                self._note_supports(item)
        return self._supports

    def put(self, item: Item) -> None:
        """Put on the next item.

        Raises:
            LayoutError: it stands out of the contour or overlaps another; nothing has changed.
        """
        self._note(item, self._session.put(_numbers(item)))

    def try_put(self, item: Item, rule: int, alpha: float = 0.0) -> Finding:
        """Put on the next item if it stands by a rule.

        Args:
            item: its sequence number is the number of items.
            rule: :data:`.SUPPORTED`, :data:`.CARRIED` or :data:`.BALANCED`.
            alpha: of :data:`.SUPPORTED` the share of the base that is required; of
                :data:`.BALANCED` the margin by which the contact patches of this item are drawn in
                on every side [cm].

        Returns:
            How it ended. The item has been put on if it :data:`.STANDS`.

        Raises:
            LayoutError: it stands out of the contour or overlaps another; nothing has changed.
        """
        found = self._session.place(_numbers(item), rule, alpha)
        self._note(item, found.ended)
        return found

    def endings(
        self, item: Item, positions: FloatArray, rule: int, alpha: float = 0.0
    ) -> NDArray[np.int8]:
        """How putting the next item on each of some places would end, by a rule.

        Args:
            item: its own position does not matter.
            positions: lower corners [cm], shape (K, 3).
            rule: see :meth:`try_put`.
            alpha: likewise.
        """
        found = np.empty(len(positions), dtype=np.int8)
        for first in range(0, len(positions), _AT_ONCE):
            part = slice(first, first + _AT_ONCE)
            found[part] = self._session.endings(_numbers(item), positions[part], rule, alpha)
        return found

    def take_off(self) -> Item:
        """Take off the item put on last, and return it."""
        item = self.items[-1]
        self.cut(len(self.items) - 1)
        return item

    def cut(self, count: int) -> None:
        """Take off all items but the first ``count``."""
        if count >= len(self.items):
            return
        self._session.cut(count)
        self._boxes = None
        while self._supports is not None and len(self._supports.below) > count:
            self._forget_supports()
        del self.items[count:]

    def beside(self, items: Sequence[int], reach: float) -> list[int]:
        """All other items with a gap of at most ``reach`` [cm] along every axis to one of some."""
        lower, upper, found = self.lower, self.upper, set[int]()
        for item in items:
            low, high = lower[item], upper[item]
            near = self._session.near(low, high, reach + TOLERANCE)
            # To the last bit as for all items at once
            # (steadyload.methods.simulation.scene.neighbourhood).
            gaps = np.maximum(lower[near] - high, low - upper[near]).max(axis=1)
            found.update(near[gaps <= reach].tolist())
        return sorted(found.difference(items))

    def layout(self, name: str | None = None) -> Layout:
        """The items as a layout, which is not checked again.

        Args:
            name: None for the one it has.

        Raises:
            LayoutError: there are no items, or no such name.
        """
        name = self.name if name is None else name
        if not self.items:
            return Layout(name, self.pallet, ())
        check_name(name)
        sizes = np.array([item.size for item in self.items], dtype=float)
        sizes.setflags(write=False)
        arrays = {"sizes": sizes, "weights": self.weights, "lower": self.lower}
        arrays |= {"upper": self.upper, "mass_offsets": self.mass_offsets}
        return view_on(arrays, name=name, pallet=self.pallet, items=tuple(self.items))

    def copy(self) -> GrowingLayout:
        """Another one with the same items, that grows by itself."""
        other = GrowingLayout.__new__(GrowingLayout)
        other.pallet, other.name = self.pallet, self.name
        other.items, other._supports = list(self.items), None
        other._session, other._boxes = self._session.copy(), None
        return other

    def __deepcopy__(self, memo: object) -> GrowingLayout:
        return self.copy()

    def _note(self, item: Item, ended: int) -> None:
        """Keep an item that was put on; an error where it cannot be."""
        if ended == STANDS:
            self.items.append(item)
            self._boxes = None
            if self._supports is not None:
                self._note_supports(len(self.items) - 1)
        elif ended in (OUTSIDE, OVERLAPS):
            raise MisplacedError(self.pallet, tuple(self.items), item)

    def _arrays(self) -> Boxes:
        """All items, read once as long as none is put on or taken off."""
        if self._boxes is None:
            self._boxes = self._session.boxes()
            for array in self._boxes:
                array.setflags(write=False)
        return self._boxes

    def _note_supports(self, item: int) -> None:
        """Take an item into the lists of supports, and what it carries."""
        session, supports = self._session, self._supports
        assert supports is not None
        # Of what was put on later, that item's turn is to come.
        supports.below.append([p for p in self._patches(item) if p.below < item])
        above = [on for on in session.above(item).tolist() if on < item]
        supports.above.append(above)
        supports.on_floor.append(session.is_on_floor(item))
        for under in supports.carriers(item):
            supports.above[under].append(item)
        for on in above:
            supports.below[on] += [p for p in self._patches(on) if p.below == item]

    def _patches(self, item: int) -> list[Patch]:
        """The patches that an item stands on."""
        below, patches, _ = self._session.below(item)
        return [
            Patch(under, item, *at)
            for under, at in zip(below.tolist(), patches.tolist(), strict=True)
        ]

    def _forget_supports(self) -> None:
        """Take the last item out of the lists of supports."""
        supports = self._supports
        assert supports is not None
        for under in supports.carriers(len(supports.below) - 1):
            supports.above[under].pop()
        supports.on_floor.pop()
        supports.below.pop()
        for on in supports.above.pop():
            supports.below[on].pop()


class MisplacedError(LayoutError):
    """An item that stands out of the contour or overlaps another.

    What is wrong is looked for when it is read: a search is refused often, and reads little.

    Args:
        pallet: see :class:`GrowingLayout`.
        others: the items put on before.
        refused: the item.
    """

    def __init__(self, pallet: Pallet, others: tuple[Item, ...], refused: Item) -> None:
        Exception.__init__(self, pallet, others, refused)

    def _found(self) -> LayoutError:
        pallet, others, refused = self.args
        items = (*others, refused)
        error = misplaced(items, arrays_of(items), pallet)
        assert error is not None, "a layout that grows and a whole one are not refused alike"
        return error

    if not TYPE_CHECKING:  # else every name would count as one that it has

        def __getattr__(self, name: str) -> Any:
            if name not in ("parts", "frame", "file", "layout", "item"):
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            vars(self).update(vars(self._found()))
            return vars(self)[name]

    def located(
        self, *, file: str | None = None, layout: str | None = None, item: str | None = None
    ) -> LayoutError:
        """See :class:`LayoutError`."""
        return self._found().located(file=file, layout=layout, item=item)

    def framed(self, frame: Frame) -> LayoutError:
        """See :class:`LayoutError`."""
        return self._found().framed(frame)


def limits_of(pallet: Pallet) -> tuple[float, ...]:
    """Contour, deck and its height above the ground, 0 for a plane, as the C library takes them."""
    height = 0.0 if pallet.floor is FloorKind.INFINITE else pallet.deck_height
    least, most = pallet.contour
    return (*least, *most, 0.0, 0.0, pallet.width, pallet.depth, height)


def _numbers(item: Item) -> tuple[float, ...]:
    """An item as the C library takes it."""
    return (*item.position, *item.size, *item.mass_offset, item.weight)


def numbered(item: Item, sequence: int) -> Item:
    """An item with another sequence number; it is not checked once more."""
    if item.sequence == sequence:
        return item
    other = object.__new__(type(item))
    assign = object.__setattr__
    assign(other, "sequence", sequence)
    assign(other, "position", item.position)
    assign(other, "size", item.size)
    assign(other, "weight", item.weight)
    assign(other, "mass_offset", item.mass_offset)
    assign(other, "name", item.name)
    assign(other, "max_load", item.max_load)
    return other
