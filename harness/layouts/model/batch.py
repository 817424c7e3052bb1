"""Many layouts as a few arrays: what compiled methods judge without an object an item."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from hashlib import sha256
from itertools import chain, pairwise
from operator import index
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steadyload.core.whole import GivenMany
from steadyload.layouts.model.batch_checks import (
    Pallets,
    checked_array,
    checked_names,
    checked_starts,
    first_invalid,
    refuse_unnamed,
)
from steadyload.layouts.model.floor import INFINITE
from steadyload.layouts.model.layout import (
    ARRAYS,
    FloatArray,
    Layout,
    LayoutError,
    Pallet,
    require_layouts,
    view_on,
)

_HASHED = ("lower", "upper", "weights", "mass_offsets")
"""Names of the arrays of which :meth:`Layout.content_hash` is."""


@dataclass(frozen=True, eq=False)
class LayoutBatch:
    """Layouts one after the other, as read-only arrays.

    It is made by :meth:`of`, :meth:`from_arrays`, :func:`steadyload.read_batch` or
    :meth:`Benchmark.batch <steadyload.layouts.benchmark.Benchmark.batch>`, and holds what a
    :class:`Layout` would: nothing is checked here. ``batch[k]`` is a :class:`Layout` that is a view
    on these arrays, ``batch[j:k]`` a batch that is one.

    Attributes:
        starts: the items of layout k are ``starts[k]`` to ``starts[k + 1]``, shape (L + 1,).
        lower, upper: corners of all items [cm], shape (N, 3).
        sizes: their width, height, depth [cm], shape (N, 3).
        weights: [kg], shape (N,). mass_offsets: [cm], shape (N, 3).
        floors: of every layout: x0, z0, x1, z1 of what carries, infinite for a plane, and its
            height above the ground, 0 for a plane [cm], shape (L, 5).
        names: of the layouts.
        kinds: of pallets, and which of them is whose.
        ids: of all boxes; none where no box has one.
    """

    starts: NDArray[np.int64]
    lower: FloatArray
    upper: FloatArray
    sizes: FloatArray
    weights: FloatArray
    mass_offsets: FloatArray
    floors: FloatArray
    names: tuple[str, ...]
    kinds: Pallets
    ids: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for array in vars(self).values():
            if isinstance(array, np.ndarray):
                array.setflags(write=False)

    def __setstate__(self, state: dict[str, Any]) -> None:
        """See :class:`Layout`."""
        vars(self).update(state)
        self.__post_init__()

    @classmethod
    def of(cls, layouts: Iterable[Layout]) -> LayoutBatch:
        """The batch of some layouts; there may be none.

        Raises:
            WrongTypeError: it is no list.
            LayoutError: one of its elements is no layout.
        """
        each = require_layouts(layouts)
        empty = np.empty((0, 3))
        ids = [layout.ids for layout in each]
        return cls(
            np.cumsum([0, *map(len, each)], dtype=np.int64),
            np.concatenate([empty, *(layout.lower for layout in each)]),
            np.concatenate([empty, *(layout.upper for layout in each)]),
            np.concatenate([empty, *(layout.sizes for layout in each)]),
            np.concatenate([empty[:, 0], *(layout.weights for layout in each)]),
            np.concatenate([empty, *(layout.mass_offsets for layout in each)]),
            np.array([layout.floor.corners for layout in each]).reshape(-1, 5),
            tuple(layout.name for layout in each),
            Pallets.of([layout.pallet for layout in each]),
            tuple(
                name
                for own, layout in zip(ids, each, strict=True)
                for name in own or [""] * len(layout)
            )
            if any(ids)
            else (),
        )

    @classmethod
    def from_arrays(
        cls,
        starts: ArrayLike,
        positions: ArrayLike,
        sizes: ArrayLike,
        weights: ArrayLike,
        mass_offsets: ArrayLike | None = None,
        *,
        pallets: Pallet | Sequence[Pallet] | FloatArray,
        names: Sequence[str] | None = None,
        ids: Sequence[str] = (),
    ) -> LayoutBatch:
        """The batch of layouts that some arrays describe; they are copied.

        Items are in loading order, those of one layout after those of another. What is allowed is
        what a :class:`Layout` allows; all layouts are checked at once.

        Args:
            starts: the items of layout k are ``starts[k]`` to ``starts[k + 1]``: whole numbers from
                0 to the number of all items, shape (L + 1,).
            positions: left-bottom-back corners (x, y, z) [cm], shape (N, 3).
            sizes: width, height, depth as placed [cm], shape (N, 3).
            weights: [kg], shape (N,).
            mass_offsets: centres of mass minus geometric centres [cm], shape (N, 3); None for 0.
            pallets: one for all layouts, or one for each, or width, height, depth [cm] of each,
                shape (L, 3).
            names: of the layouts; None for "0", "1", ...
            ids: of all boxes, shape (N,); none where boxes have none.

        Raises:
            LayoutError: the arrays do not fit together, or a layout is not valid: that of the first
                such layout, as :class:`Layout` itself would raise it.
        """
        bounds = checked_starts(starts)
        layouts, items = len(bounds) - 1, int(bounds[-1])
        lower = checked_array("positions", positions, (items, 3))
        offsets = np.zeros_like(lower) if mass_offsets is None else mass_offsets
        boxes = () if ids is None else ids
        return checked_batch(
            bounds,
            lower,
            checked_array("sizes", sizes, (items, 3)),
            checked_array("weights", weights, (items,)),
            checked_array("mass_offsets", offsets, (items, 3)),
            pallets=_pallets(pallets, layouts),
            names=checked_names("names", _numbered(layouts) if names is None else names, layouts),
            ids=checked_names("ids", boxes, items if len(boxes) else 0),
        )

    @classmethod
    def joined(cls, batches: Sequence[LayoutBatch]) -> LayoutBatch:
        """The layouts of one or more batches, one after the other."""
        if len(batches) == 1:
            return batches[0]
        counts = np.concatenate([batch.item_counts for batch in batches])
        with_ids = any(batch.ids for batch in batches)
        return cls(
            np.concatenate(([0], np.cumsum(counts))),
            **{key: np.concatenate([getattr(b, key) for b in batches]) for key in ARRAYS},
            floors=np.concatenate([batch.floors for batch in batches]),
            names=tuple(chain.from_iterable(batch.names for batch in batches)),
            kinds=Pallets.joined([batch.kinds for batch in batches]),
            ids=tuple(name for batch in batches for name in batch.ids or [""] * len(batch.weights))
            if with_ids
            else (),
        )

    def __len__(self) -> int:
        """Number of layouts."""
        return len(self.floors)

    def fingerprint(self) -> str:
        """SHA-256 of the names and of what the content hashes are of, as hex digits."""
        made = sha256("\0".join(self.names).encode())
        made.update(self.starts.astype("<i8").tobytes())
        hashed = (getattr(self, key) for key in _HASHED)
        for values in (*hashed, self.kinds.sizes(), self.floors[:, 4]):
            made.update(np.ascontiguousarray(values, dtype="<f8").data)
        return made.hexdigest()

    def content_hashes(self) -> list[str]:
        """:meth:`Layout.content_hash` of every layout."""
        counts, each, heights = self.item_counts, np.arange(len(self)), self.floors[:, 4]
        # What is hashed lies there one layout after the other, each as its own hash takes it.
        ends = np.cumsum(10 * counts + 3 + (heights > 0.0))
        packed, at = np.empty(ends[-1] if len(ends) else 0, dtype="<f8"), np.append(0, ends)[:-1]
        for values in (getattr(self, key) for key in _HASHED):
            width = values.size // max(len(values), 1)
            offsets = np.repeat(at - width * self.starts[:-1], width * counts)
            packed[offsets + np.arange(len(offsets))] = values.ravel()
            at = at + width * counts
        packed[at[each, None] + np.arange(3)] = self.kinds.sizes()
        on_deck = heights > 0.0
        packed[ends[on_deck] - 1] = heights[on_deck]
        content, last = memoryview(packed.tobytes()), [0, *(8 * ends).tolist()]
        return [sha256(content[start:end]).hexdigest() for start, end in pairwise(last)]

    @property
    def pallets(self) -> tuple[Pallet, ...]:
        """Of the layouts, one each."""
        return self.kinds.each

    @property
    def given(self) -> GivenMany:
        """The layouts as the C library takes them."""
        return GivenMany(
            self.starts, self.lower, self.upper, self.weights, self.mass_offsets, self.floors
        )

    @property
    def item_counts(self) -> NDArray[np.int64]:
        """Number of items of every layout, shape (L,)."""
        return np.diff(self.starts)

    def __iter__(self) -> Iterator[Layout]:
        return map(self._layout, range(len(self)))

    @overload
    def __getitem__(self, which: int) -> Layout: ...

    @overload
    def __getitem__(self, which: slice) -> LayoutBatch: ...

    def __getitem__(self, which: int | slice) -> Layout | LayoutBatch:
        if isinstance(which, slice):
            return self._part(range(len(self))[which])
        return self._layout(range(len(self))[index(which)])

    def _layout(self, k: int) -> Layout:
        own = slice(self.starts[k], self.starts[k + 1])
        pallet = self.kinds.kinds[self.kinds.which[k]]
        return view_on(
            {key: getattr(self, key)[own] for key in ARRAYS},
            name=self.names[k],
            pallet=pallet,
            floor=pallet.floor_under(overhung=True) if self.floors[k, 4] > 0.0 else INFINITE,
            ids=_stated(self.ids[own]),
        )

    def _part(self, layouts: range) -> LayoutBatch:
        """Some layouts, one after the other."""
        if layouts.step != 1:
            raise ValueError(f"step of a slice is {layouts.step}; allowed: 1")
        start, stop = layouts.start, max(layouts.start, layouts.stop)
        own, each = slice(self.starts[start], self.starts[stop]), slice(start, stop)
        return LayoutBatch(
            self.starts[start : stop + 1] - self.starts[start],
            **{key: getattr(self, key)[own] for key in ARRAYS},
            floors=self.floors[each],
            names=self.names[each],
            kinds=self.kinds[each],
            ids=_stated(self.ids[own]),
        )


def checked_batch(
    starts: NDArray[np.int64],
    lower: FloatArray,
    sizes: FloatArray,
    weights: FloatArray,
    mass_offsets: FloatArray,
    *,
    pallets: Pallets,
    names: tuple[str, ...],
    ids: tuple[str, ...] = (),
    known: bool = False,
) -> LayoutBatch:
    """The batch on some arrays of the right types and shapes, if all of its layouts are valid.

    The arrays are not copied, and read-only from then on; they are those of
    :meth:`LayoutBatch.from_arrays`. Where they are ``known`` to be valid, nothing is checked.

    Raises:
        LayoutError: that of the first layout that is not valid.
    """
    arrays = _arrays(lower, sizes, weights, mass_offsets)
    invalid = None
    if not known:
        refuse_unnamed(names)
        invalid = first_invalid(starts, arrays, pallets, ids)
    if invalid is not None:
        own = slice(starts[invalid], starts[invalid + 1])
        raise _error_of(
            view_on(
                {key: array[own] for key, array in arrays.items()},
                name=names[invalid],
                pallet=pallets.each[invalid],
                ids=ids[own],
            )
        )
    return LayoutBatch(
        starts,
        **arrays,
        floors=pallets.floors(starts, arrays),
        names=names,
        kinds=pallets,
        ids=ids,
    )


def _arrays(
    lower: FloatArray, sizes: FloatArray, weights: FloatArray, mass_offsets: FloatArray
) -> dict[str, FloatArray]:
    """The arrays of items, by name."""
    with np.errstate(invalid="ignore", over="ignore"):
        upper = lower + sizes
    return {
        "lower": lower,
        "upper": upper,
        "sizes": sizes,
        "weights": weights,
        "mass_offsets": mass_offsets,
    }


def _error_of(view: Layout) -> LayoutError:
    """The error of making a layout of values that are not valid."""
    try:
        Layout(view.name, view.pallet, view.items)
    except LayoutError as error:
        return error.located(layout=view.name)
    raise AssertionError(f"layout {view.name!r} is valid by itself, and was refused among others")


def _pallets(given: Pallet | Sequence[Pallet] | FloatArray, count: int) -> Pallets:
    """The pallets of so many layouts, as :meth:`LayoutBatch.from_arrays` takes them."""
    if isinstance(given, Pallet):
        return Pallets((given,), np.zeros(count, dtype=np.int64))
    if isinstance(given, np.ndarray):
        return Pallets.sized(checked_array("pallets", given, (count, 3)))
    entries = list(given) if isinstance(given, Sequence) else []
    if len(entries) != count or not all(isinstance(one, Pallet) for one in entries):
        raise LayoutError(
            f"pallets has {len(entries)} entries; allowed: one pallet, {count} of them, or an "
            f"array of numbers of shape {(count, 3)}"
        )
    return Pallets.of(entries)


def _stated(ids: tuple[str, ...]) -> tuple[str, ...]:
    """Ids of some boxes; none where all are empty."""
    return ids if any(ids) else ()


def _numbered(count: int) -> tuple[str, ...]:
    return tuple(map(str, range(count)))
