"""Items found by their place: the cost hardly depends on how many there are elsewhere.

The contour is cut into slabs along every axis. ``cells`` has a row of bits, one an item, for every
slab and axis twice: row ``2 * axis * SLABS + s`` has the items that end in slab s or behind it, row
``(2 * axis + 1) * SLABS + s`` those that begin in slab s or before it. What six rows have in common
may meet a region: six words are read for 64 items, wherever these are.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from steadyload.statics.kernels.compiled import compiled

SLABS = 32
"""Slabs along an axis."""


@compiled
def enter(cells: Any, limits: Any, lower: Any, upper: Any, number: int) -> None:
    """Let an item be found.

    Args:
        cells: see the module.
        limits: see :mod:`steadyload.statics.kernels.growing`.
        lower: corner of the item, (x, y, z) [cm].
        upper: likewise.
        number: of the item.
    """
    word, bit = number // 64, np.int64(1) << (number % 64)
    for axis in range(3):
        ends = 2 * axis * SLABS
        for row in range(ends, ends + _slab(limits, axis, upper[axis]) + 1):
            cells[row, word] |= bit
        begins = ends + SLABS
        for row in range(begins + _slab(limits, axis, lower[axis]), begins + SLABS):
            cells[row, word] |= bit


@compiled
def leave(cells: Any, number: int) -> None:
    """Undo :func:`enter`."""
    word, bit = number // 64, np.int64(1) << (number % 64)
    for slab in range(len(cells)):
        cells[slab, word] &= ~bit


@compiled
def rows_near(limits: Any, lower: Any, upper: Any, wider: float) -> Any:
    """The rows of ``cells`` whose common bits are the items that may meet a region.

    Args:
        limits: see :mod:`steadyload.statics.kernels.growing`.
        lower: corner of the region [cm].
        upper: likewise.
        wider: how much further it reaches on every side [cm].
    """
    return (
        _slab(limits, 0, lower[0] - wider),
        SLABS + _slab(limits, 0, upper[0] + wider),
        2 * SLABS + _slab(limits, 1, lower[1] - wider),
        3 * SLABS + _slab(limits, 1, upper[1] + wider),
        4 * SLABS + _slab(limits, 2, lower[2] - wider),
        5 * SLABS + _slab(limits, 2, upper[2] + wider),
    )


@compiled
def _slab(limits: Any, axis: int, place: float) -> int:
    """The slab of a place; beyond the contour, the outermost."""
    slab = (place - limits[axis]) * limits[11 + axis]
    return int(min(max(slab, 0.0), SLABS - 1.0))


@compiled
def common_items(cells: Any, rows: Any, word: int) -> int:
    """Bits of the 64 items of a word that all rows have."""
    bits = cells[rows[0], word] & cells[rows[1], word] & cells[rows[2], word]
    return bits & cells[rows[3], word] & cells[rows[4], word] & cells[rows[5], word]


@compiled
def lowest(bits: int) -> int:
    """The number of the lowest bit that is set."""
    bits &= -bits
    found = 0
    for size in (32, 16, 8, 4, 2, 1):
        if bits & ((np.int64(1) << size) - 1) == 0:
            found += size
            bits >>= size
    return found


@compiled
def items_near(
    lowers: Any,
    uppers: Any,
    cells: Any,
    count: int,
    limits: Any,
    lower: Any,
    upper: Any,
    wider: float,
) -> Any:
    """Items that share a point with a region, in order.

    Args:
        lowers: corners of all items, shape (J, 3) [cm].
        uppers: likewise.
        cells: see the module.
        count: of items.
        limits: see :mod:`steadyload.statics.kernels.growing`.
        lower: corner of the region, (x, y, z) [cm].
        upper: likewise.
        wider: how much further it reaches on every side [cm].
    """
    rows = rows_near(limits, lower, upper, wider)
    found = np.empty(count, dtype=np.int64)
    size = 0
    for word in range((count + 63) // 64):
        bits = common_items(cells, rows, word)
        while bits != 0:
            item = 64 * word + lowest(bits)
            bits &= bits - 1
            meets = True
            for axis in range(3):
                if lowers[item, axis] > upper[axis] + wider:
                    meets = False
                if uppers[item, axis] < lower[axis] - wider:
                    meets = False
            if meets:
                found[size] = item
                size += 1
    return found[:size]
