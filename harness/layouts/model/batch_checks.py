"""Pallets of many layouts, and checks of arrays that are to be layouts.

Why a layout is not valid is said by the objects (:class:`Item`, :class:`Layout`), which are made of
that layout alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steadyload.layouts.model.checks import unprintable
from steadyload.layouts.model.layout import (
    TOLERANCE,
    FloatArray,
    LayoutError,
    Pallet,
)
from steadyload.layouts.model.validity import first_fault

_PLAN = (0, 2)
"""The horizontal axes."""


@dataclass(frozen=True, eq=False)
class Pallets:
    """Pallets of many layouts, most of which are the same. Equal: each layout has an equal one.

    Attributes:
        kinds: the different ones.
        which: of every layout, its place among them, shape (L,).
    """

    kinds: tuple[Pallet, ...]
    which: NDArray[np.int64]

    @classmethod
    def of(cls, pallets: Sequence[Pallet]) -> Pallets:
        """Those of layouts that have one each."""
        places: dict[int, int] = {}
        which = [places.setdefault(id(pallet), len(places)) for pallet in pallets]
        kinds = dict(zip(which, pallets, strict=True))
        return cls(tuple(kinds[k] for k in range(len(kinds))), np.array(which, dtype=np.int64))

    @classmethod
    def sized(cls, sizes: FloatArray, **deck: Any) -> Pallets:
        """Those of given widths, heights and depths.

        Args:
            sizes: [cm], shape (L, 3).
            deck: further arguments of all of them; see :class:`Pallet`.

        Raises:
            LayoutError: one is not allowed; it states the number of the first layout that has it.
        """
        other = np.concatenate(([True], (sizes[1:] != sizes[:-1]).any(axis=1)))[: len(sizes)]
        firsts = np.flatnonzero(other)  # of layouts in a row that have the same
        places: dict[tuple[float, ...], int] = {}
        which = [places.setdefault(tuple(size), len(places)) for size in sizes[firsts].tolist()]
        kinds = []
        for k, size in enumerate(places):
            try:
                kinds.append(Pallet(*size, **deck))
            except LayoutError as error:
                raise error.located(layout=str(firsts[which.index(k)])) from None
        return cls(tuple(kinds), np.array(which, dtype=np.int64)[np.cumsum(other) - 1])

    def __post_init__(self) -> None:
        self.which.setflags(write=False)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Pallets) and self.each == other.each

    def __hash__(self) -> int:
        return hash(self.each)

    @classmethod
    def joined(cls, parts: Sequence[Pallets]) -> Pallets:
        """Those of layouts one after the other."""
        places: dict[Pallet, int] = {}
        each = [
            np.array([places.setdefault(kind, len(places)) for kind in part.kinds], dtype=np.int64)[
                part.which
            ]
            for part in parts
        ]
        return cls(tuple(places), np.concatenate(each))

    def __getitem__(self, layouts: slice) -> Pallets:
        """Those of some of the layouts."""
        return Pallets(self.kinds, self.which[layouts])

    def sizes(self) -> FloatArray:
        """Width, height and depth of the pallet of every layout [cm], shape (L, 3)."""
        return np.array([kind.size for kind in self.kinds]).reshape(-1, 3)[self.which]

    @cached_property
    def each(self) -> tuple[Pallet, ...]:
        """The pallet of every layout."""
        return tuple(map(self.kinds.__getitem__, self.which.tolist()))

    def contours(self) -> FloatArray:
        """Opposite corners of the contour of every layout [cm], shape (L, 6)."""
        return np.array([kind.contour for kind in self.kinds]).reshape(-1, 6)[self.which]

    def floors(self, starts: NDArray[np.int64], arrays: Mapping[str, FloatArray]) -> FloatArray:
        """The floor of every layout, as a batch has it, shape (L, 5)."""
        if not len(self.which):
            return np.empty((0, 5))
        sizes = np.array([(kind.width, kind.depth) for kind in self.kinds])
        low = arrays["lower"][:, _PLAN]
        high = arrays["upper"][:, _PLAN] - self._of_items(sizes, starts)
        out = np.maximum.reduceat(_largest(np.maximum(-low, high)), starts[:-1])
        floors = np.array(
            [[kind.floor_under(overhung=over).corners for over in (False, True)]
             for kind in self.kinds]
        )  # fmt: skip
        found: FloatArray = floors[self.which, (out > TOLERANCE).astype(int)]
        return found

    def _of_items(self, values: FloatArray, starts: NDArray[np.int64]) -> FloatArray:
        """Values of pallets, by item; a single row where all layouts have the same pallet."""
        if len(self.kinds) == 1:
            return values
        return np.repeat(values[self.which], np.diff(starts), axis=0)


def first_invalid(
    starts: NDArray[np.int64],
    arrays: Mapping[str, FloatArray],
    pallets: Pallets,
    ids: Sequence[str],
) -> int | None:
    """The first layout that a :class:`Layout` would refuse for its items; None if there is none.

    Args:
        starts: as a batch has it.
        arrays: the arrays of all items, by name, of shapes that fit together.
        pallets: of the layouts.
        ids: of all boxes, or none.
    """
    fault = first_fault(starts, arrays, pallets.contours())
    found = len(pallets.which) if fault is None else fault.layout
    if ids and not "".join(ids[: starts[found]]).isprintable():
        printable = np.fromiter(map(str.isprintable, ids), dtype=bool, count=len(ids))
        found = int(np.searchsorted(starts, printable.argmin(), "right")) - 1
    return found if found < len(pallets.which) else None


def _largest(values: FloatArray) -> FloatArray:
    """The largest value of every row; with a loop a column, since rows are many and short."""
    found: FloatArray = values[:, 0]
    for column in values.T[1:]:
        found = np.maximum(found, column)
    return found


def checked_starts(starts: ArrayLike) -> NDArray[np.int64]:
    """Where layouts begin among the items of all, as an array of its own.

    Raises:
        LayoutError: they are no whole numbers, do not begin with 0, or fall.
    """
    found = np.array(starts)
    if found.ndim != 1 or not len(found) or found.dtype.kind not in "iu" or found[0] != 0:
        raise LayoutError(
            f"starts is {_described(found)}; allowed: whole numbers that begin with 0, one more "
            "than there are layouts"
        )
    bounds = found.astype(np.int64)
    fewer = np.diff(bounds) < 0
    if fewer.any():
        k = int(fewer.argmax())
        raise LayoutError(
            f"starts falls from {bounds[k]} to {bounds[k + 1]}; allowed: numbers that do not fall",
            layout=str(k),
        )
    return bounds


def checked_array(key: str, values: ArrayLike, shape: tuple[int, ...]) -> FloatArray:
    """Numbers of this shape, as an array of its own.

    Raises:
        LayoutError: they are none, or of another shape.
    """
    try:
        found = np.array(values)
        if found.dtype.kind in "iuf" and found.shape == shape:
            return found.astype(float)
        described = _described(found)
    except ValueError:
        described = "of rows of different lengths"
    raise LayoutError(f"{key} is {described}; allowed: numbers of shape {shape}")


def checked_names(key: str, names: Sequence[str], count: int) -> tuple[str, ...]:
    """So many texts.

    Raises:
        LayoutError: there are more or fewer, or others among them.
    """
    found = tuple(names)
    if len(found) != count or not all(isinstance(name, str) for name in found):
        raise LayoutError(f"{key} has {len(found)} entries; allowed: {count} texts")
    return found


def refuse_unnamed(names: Sequence[str]) -> None:
    """Raise the error of a layout's name that is not allowed.

    Raises:
        LayoutError: there is one; it states the number of the layout.
    """
    if "".join(names).isprintable() and all(names):
        return
    for k, name in enumerate(names):
        if not name or not name.isprintable():
            raise LayoutError(unprintable(name), layout=str(k))


def _described(found: NDArray[np.generic]) -> str:
    return f"an array of {found.dtype} and shape {found.shape}"
