"""Items that overlap: in one layout which and by how much, in many layouts whether any do."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from steadyload.core.constants import TOLERANCE
from steadyload.layouts.model.checks import FloatArray

_BLOCK = 256
"""Items of a large layout that are compared with all at a time."""

_SMALL = 64
"""Items up to which layouts of equal numbers of items are compared together."""

_PAIRS = 1 << 17
"""Pairs that are compared together."""


def deepest_overlap(lower: FloatArray, upper: FloatArray) -> tuple[int, int, float] | None:
    """Two items of a layout, in order, and the depth [cm] by which they overlap along every axis.

    None where no two overlap by more than :data:`TOLERANCE`. Of more items than a block, those of
    the first block in which some do.
    """
    for start in range(0, len(lower), _BLOCK):
        block = slice(start, start + _BLOCK)
        shared = np.minimum(upper[block, None], upper[None]) - np.maximum(
            lower[block, None], lower[None]
        )
        depth = shared.min(axis=2)
        depth[np.arange(len(depth)), np.arange(start, start + len(depth))] = -np.inf
        if depth.max() > TOLERANCE:
            row, other = np.unravel_index(int(depth.argmax()), depth.shape)
            first, second = sorted((int(row) + start, int(other)))
            return first, second, float(depth.max())
    return None


def with_overlaps(
    starts: NDArray[np.int64], lower: FloatArray, upper: FloatArray
) -> NDArray[np.bool_]:
    """True for each layout of many in which two items overlap by more than :data:`TOLERANCE`.

    Args:
        starts: the first item of every layout, and the number of all items, shape (L + 1,).
        lower: corners of the items of all layouts [cm], shape (N, 3).
        upper: likewise.
    """
    counts = np.diff(starts)
    found = np.zeros(len(counts), dtype=bool)
    for k in np.flatnonzero(counts > _SMALL):
        own = slice(starts[k], starts[k + 1])
        found[k] = deepest_overlap(lower[own], upper[own]) is not None
    for count, alike in _alike(counts):
        items = starts[alike] + np.arange(count)[:, None]
        low, high = (
            np.ascontiguousarray(np.moveaxis(corners[items], 2, 0)) for corners in (lower, upper)
        )
        for apart in range(1, count):  # the pairs of items that are so many steps apart
            shared = np.minimum(high[:, :-apart], high[:, apart:])
            shared -= np.maximum(low[:, :-apart], low[:, apart:])
            found[alike] |= (shared > TOLERANCE).all(axis=0).any(axis=0)
    return found


def _alike(counts: NDArray[np.int64]) -> Iterator[tuple[int, NDArray[np.int64]]]:
    """Layouts of equal numbers of items, at least two and few, not too many at a time."""
    for count in np.unique(counts).tolist():
        if 2 <= count <= _SMALL:
            layouts = np.flatnonzero(counts == count)
            size = max(_PAIRS // (count * count // 2), 1)
            for start in range(0, len(layouts), size):
                yield count, layouts[start : start + size]
