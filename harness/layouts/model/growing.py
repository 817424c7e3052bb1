"""A layout that grows item by item, and shrinks again, at a cost independent of its size."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from struct import Struct
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

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
    outside_error,
    overlap_error,
    view_on,
)
from steadyload.statics import kernels
from steadyload.statics.kernels.constants import FULL, OUTSIDE, OVERLAPS, STANDS

if TYPE_CHECKING:
    from steadyload.statics.kernels.growing import Arrays

_AT_ONCE = 100
"""Positions that one compiled call looks at: between two, a user can interrupt."""

_write_box = Struct("10d").pack_into


class GrowingLayout:
    """The items loaded so far, with the items each one stands on and those near it.

    What is true of a :class:`Layout` of the same items is true of it at any time, numbers included
    to the last bit. It is kept in the arrays of :mod:`steadyload.statics.kernels.growing`, where
    compiled rules judge items as they place them.

    Args:
        pallet: its contour holds all items, to within :data:`TOLERANCE`.
        name: as of a :class:`Layout`.

    Attributes:
        items: in loading order; their sequence numbers count from 0.
    """

    def __init__(self, pallet: Pallet, name: str) -> None:
        self.pallet, self.name = pallet, name
        self.items: list[Item] = []
        self._supports: Supports | None = None
        self._keep(first_arrays(pallet))

    def __len__(self) -> int:
        return len(self.items)

    @property
    def floor(self) -> Floor:
        """The floor that the items stand on; an ``auto`` one follows what is loaded by now."""
        return self.pallet.floor_under(overhung=bool(self._arrays.counts[kernels.growing.OVERHUNG]))

    @property
    def lower(self) -> FloatArray:
        """Lower corners [cm], shape (J, 3), columns x, y, z: a view, read-only as the others."""
        return self._view(self._arrays.vectors[0])

    @property
    def upper(self) -> FloatArray:
        """Upper corners [cm], shape (J, 3)."""
        return self._view(self._arrays.vectors[1])

    @property
    def mass_offsets(self) -> FloatArray:
        """Centres of mass minus geometric centres [cm], shape (J, 3)."""
        return self._view(self._arrays.vectors[2])

    @property
    def weights(self) -> FloatArray:
        """[kg], shape (J,)."""
        return self._view(self._arrays.weights)

    @property
    def supports(self) -> Supports:
        """Vertical contacts between the items; from the first look on they are kept up to date."""
        if self._supports is None:
            self._supports = Supports([], [], [])
            for item in range(len(self.items)):
                self._note_supports(item)
        return self._supports

    def warm(self) -> None:
        """Compile what :meth:`try_put` calls, or load the compiled code: an item that cannot be is
        tried.
        """
        self._next[:] = np.nan
        kernels.placing.place(self._kept, kernels.placing.SUPPORTED, 0.0)

    def put(self, item: Item) -> None:
        """Put on the next item.

        Raises:
            LayoutError: it stands out of the contour or overlaps another; nothing has changed.
        """
        self._put_by(item, kernels.growing.put)

    def try_put(self, item: Item, rule: int, alpha: float = 0.0) -> tuple[int, int, float]:
        """Put on the next item if it stands by a compiled rule.

        Args:
            item: its sequence number is the number of items.
            rule: one of :mod:`steadyload.statics.kernels.placing`.
            alpha: see :func:`~steadyload.statics.kernels.placing.place`.

        Returns:
            See there. The item has been put on if it :data:`STANDS`.

        Raises:
            LayoutError: it stands out of the contour or overlaps another; nothing has changed.
        """
        return self._put_by(item, kernels.placing.place, rule, alpha)

    def _put_by(self, item: Item, put: Callable[..., Any], *how: float) -> tuple[int, int, float]:
        _write_box(self._next, 0, *item.position, *item.size, *item.mass_offset, item.weight)
        found: tuple[int, int, float] = put(self._kept, *how)
        while found[0] == FULL:
            self._keep(kernels.growing.with_more_room(self._arrays))
            found = put(self._kept, *how)
        if found[0] == STANDS:
            self.items.append(item)
            if self._supports is not None:
                self._note_supports(len(self.items) - 1)
        elif found[0] in (OUTSIDE, OVERLAPS):
            raise MisplacedError(self.pallet, tuple(self.items), item)
        return found

    def endings(
        self, item: Item, positions: FloatArray, rule: int, alpha: float = 0.0
    ) -> NDArray[np.int8]:
        """How putting the next item on each of some places would end, by a compiled rule.

        Args:
            item: its own position does not matter.
            positions: lower corners [cm], shape (K, 3).
            rule: see :meth:`try_put`.
            alpha: likewise.
        """
        found = np.empty(len(positions), dtype=np.int8)
        _write_box(self._next, 0, *item.position, *item.size, *item.mass_offset, item.weight)
        done, stand = 0, kernels.placing.stand
        while done < len(positions):
            stop = min(done + _AT_ONCE, len(positions))
            done = stand(self._kept, rule, alpha, positions[:stop], found, done)
            if done < stop:
                self._keep(kernels.growing.with_more_room(self._arrays))
        return found

    def take_off(self) -> Item:
        """Take off the item put on last, and return it."""
        item = self.items[-1]
        self.cut(len(self.items) - 1)
        return item

    def cut(self, count: int) -> None:
        """Take off all items but the first ``count``."""
        kernels.growing.take_off(self._kept, count)
        while self._supports is not None and len(self._supports.below) > count:
            self._forget_supports()
        del self.items[count:]

    def beside(self, items: Sequence[int], reach: float) -> list[int]:
        """All other items with a gap of at most ``reach`` [cm] along every axis to one of some."""
        (lower, upper, _), cells, count = self._arrays.vectors, self._arrays.cells, len(self.items)
        found: set[int] = set()
        for item in items:
            low, high = lower[item], upper[item]
            near = kernels.cells.items_near(
                lower, upper, cells, count, self._arrays.limits, low, high, reach + TOLERANCE
            )
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
        arrays = {"sizes": sizes, "weights": self.weights.copy(), "lower": self.lower.copy()}
        arrays |= {"upper": self.upper.copy(), "mass_offsets": self.mass_offsets.copy()}
        for array in arrays.values():
            array.setflags(write=False)
        return view_on(arrays, name=name, pallet=self.pallet, items=tuple(self.items))

    def copy(self) -> GrowingLayout:
        """Another one with the same items, that grows by itself."""
        other = GrowingLayout.__new__(GrowingLayout)
        other.pallet, other.name = self.pallet, self.name
        other.items, other._supports = list(self.items), None
        other._keep(kernels.growing.copied(self._arrays))
        return other

    def _keep(self, arrays: Arrays) -> None:
        self._arrays, self._kept = arrays, tuple(arrays)
        self._next: Any = arrays.limits[kernels.growing.BOX :]

    def _view(self, array: FloatArray) -> FloatArray:
        view = array[: len(self.items)]
        view.setflags(write=False)
        return view

    def _note_supports(self, item: int) -> None:
        """Take an item into the lists of supports, and what it carries."""
        arrays, supports = self._arrays, self._supports
        blocks, links, patches = arrays.blocks, arrays.links, arrays.patches
        assert supports is not None
        start, end, _, above_start, above_end, _, _, on_floor, _ = blocks[:, item].tolist()
        below = zip(links[0, start:end].tolist(), patches[start:end].tolist(), strict=True)
        # Of what was put on later, that item's turn is to come.
        supports.below.append([Patch(under, item, *at) for under, at in below if under < item])
        above = [on for on in links[1, above_start:above_end].tolist() if on < item]
        supports.above.append(above)
        supports.on_floor.append(bool(on_floor))
        for under in supports.carriers(item):
            supports.above[under].append(item)
        for on in above:
            at = blocks[0, on] + links[0, blocks[0, on] : blocks[1, on]].tolist().index(item)
            supports.below[on].append(Patch(item, on, *patches[at].tolist()))

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
        low = np.array(refused.position, dtype=float)
        high = low + np.array(refused.size, dtype=float)
        least, most = np.array(pallet.contour)
        outside = np.maximum(least - low, high - most)
        if outside.max() > TOLERANCE:
            axis = int(outside.argmax())
            return outside_error(refused, pallet, axis, (float(low[axis]), float(high[axis])))
        lower = np.array([item.position for item in others], dtype=float)
        upper = lower + np.array([item.size for item in others], dtype=float)
        depth = (np.minimum(upper, high) - np.maximum(lower, low)).min(axis=1)
        return overlap_error(refused, others[int(depth.argmax())], float(depth.max()))

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


def first_arrays(pallet: Pallet) -> Arrays:
    """The arrays of a load without items."""
    height = 0.0 if pallet.floor is FloorKind.INFINITE else pallet.deck_height
    deck = (0.0, 0.0, pallet.width, pallet.depth, height)
    return kernels.growing.first_arrays(*pallet.contour, deck)


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
