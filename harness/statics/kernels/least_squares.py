"""Non-negative least squares, for the few rows and columns that contact forces have."""

from __future__ import annotations

from typing import Any

import numpy as np

from steadyload.statics.kernels.compiled import compiled

_PATIENCE = 3
"""Iterations a column, after which the search gives up."""


@compiled
def nonnegative_least_squares(columns: Any, target: Any) -> Any:
    """The x >= 0 with the least sum of squares of target - (sum of x times columns).

    The method of Lawson and Hanson (Solving Least Squares Problems, 1974, chapter 23), with the
    factors of the columns that are positive kept from step to step (Gram and Schmidt, twice).

    Args:
        columns: C-contiguous, shape (n, m).
        target: shape (m,).

    Returns:
        x, shape (n,), the residual, shape (m,), and whether it ended.
    """
    blocks = np.full((len(columns), 2), -1, dtype=np.int64)
    blocks[:, 0] = 0
    likely = np.empty(0, dtype=np.int64)
    return least_squares_of_blocks(columns, target, blocks, columns.shape[1], likely)


@compiled
def least_squares_of_blocks(columns: Any, target: Any, blocks: Any, width: int, likely: Any) -> Any:
    """See :func:`nonnegative_least_squares`; of columns that are zero but for one or two blocks.

    Args:
        columns: C-contiguous, shape (n, m).
        target: shape (m,).
        blocks: the first rows of the blocks of every column, -1 for none, shape (n, 2).
        width: rows of a block.
        likely: columns whose x are probably positive, with which the search begins.
    """
    count, rows = columns.shape
    most = min(rows, count)
    x = np.zeros(count)
    residual = target.copy()
    chosen = np.empty(most, dtype=np.int64)
    is_chosen = np.zeros(count, dtype=np.bool_)
    basis, factor = np.empty((most, rows)), np.zeros((most, most))
    aims = np.empty(most)
    size = 0
    largest = 0.0
    for k in range(count):
        norm = 0.0
        for r in range(rows):
            norm += abs(columns[k, r])
        largest = max(largest, norm)
    least = 10.0 * max(rows, count) * np.spacing(1.0) * largest
    for k in likely:
        if size < most and _append(columns[k], blocks[k], width, basis, factor, size):
            chosen[size] = k
            aims[size] = _dot(basis[size], target)
            size += 1
    while size > 0:
        goal = _solved(factor, aims, size)
        before = size
        for k in range(before - 1, -1, -1):
            if not goal[k] > 0.0:
                _remove(k, chosen, basis, factor, aims, size)
                size -= 1
        if size == before:
            break
    for k in range(size):
        x[chosen[k]] = goal[k]
        is_chosen[chosen[k]] = True
    _put_residual(residual, target, x, columns, chosen, size, blocks, width)
    refused = np.zeros(count, dtype=np.bool_)
    for _ in range(_PATIENCE * count + 10):
        best, steepest = -1, least
        for k in range(count):
            if not is_chosen[k] and not refused[k]:
                slope = _dot_of_blocks(columns[k], residual, blocks[k], width)
                if slope > steepest:
                    best, steepest = k, slope
        if best < 0 or size == most:
            return x, residual, True
        if not _append(columns[best], blocks[best], width, basis, factor, size):
            refused[best] = True  # it lies in the span of the others
            continue
        chosen[size] = best
        aims[size] = _dot(basis[size], target)
        size += 1
        goal = _solved(factor, aims, size)
        if goal[size - 1] <= 0.0:  # by rounding
            size -= 1
            refused[best] = True
            continue
        is_chosen[best] = True
        refused[:] = False
        while True:
            # Back to where the first of them becomes zero.
            share, last = 1.0, -1
            for k in range(size):
                if goal[k] <= 0.0:
                    now = x[chosen[k]]
                    step = now / (now - goal[k]) if now != goal[k] else 0.0
                    if step < share or last < 0:
                        share, last = step, k
            if last < 0:
                break
            for k in range(size):
                x[chosen[k]] += share * (goal[k] - x[chosen[k]])
            x[chosen[last]] = 0.0
            for k in range(size - 1, -1, -1):
                if not x[chosen[k]] > 0.0:
                    x[chosen[k]] = 0.0
                    is_chosen[chosen[k]] = False
                    _remove(k, chosen, basis, factor, aims, size)
                    size -= 1
            if size == 0:
                break
            goal = _solved(factor, aims, size)
        for k in range(size):
            x[chosen[k]] = goal[k]
        _put_residual(residual, target, x, columns, chosen, size, blocks, width)
    return x, residual, False


@compiled
def _put_residual(
    residual: Any, target: Any, x: Any, columns: Any, chosen: Any, size: int, blocks: Any,
    width: int,
) -> None:  # fmt: skip
    """The target less the chosen columns times their x."""
    residual[:] = target
    for k in chosen[:size]:
        for first in blocks[k]:
            for r in range(first, first + width if first >= 0 else first):
                residual[r] -= x[k] * columns[k, r]


@compiled
def _append(column: Any, blocks: Any, width: int, basis: Any, factor: Any, size: int) -> bool:
    """Orthogonalise a column against the first ones of a basis and put it behind them.

    Returns:
        False where it lies in their span.
    """
    rest = column.copy()
    whole = np.sqrt(_dot(column, column))
    for k in range(size):
        factor[k, size] = _dot_of_blocks(column, basis[k], blocks, width)
    for k in range(size):
        _subtract(factor[k, size], basis[k], rest)
    for k in range(size):
        along = _dot(basis[k], rest)
        factor[k, size] += along
        _subtract(along, basis[k], rest)
    length = np.sqrt(_dot(rest, rest))
    if not length > 1e-13 * whole:
        return False
    factor[size, size] = length
    for r in range(len(rest)):
        basis[size, r] = rest[r] / length
    return True


@compiled
def _subtract(share: float, one: Any, rest: Any) -> None:
    for r in range(len(rest)):
        rest[r] -= share * one[r]


@compiled
def _remove(column: int, chosen: Any, basis: Any, factor: Any, aims: Any, size: int) -> None:
    """Take a column out of the factors: rotations make them triangular again."""
    for k in range(column, size - 1):
        chosen[k] = chosen[k + 1]
        for j in range(k + 2):
            factor[j, k] = factor[j, k + 1]
        above, below = factor[k, k], factor[k + 1, k]
        length = np.hypot(above, below)
        if length == 0.0:
            continue
        c, s = above / length, below / length
        factor[k, k], factor[k + 1, k] = length, 0.0
        for j in range(k + 2, size):
            above, below = factor[k, j], factor[k + 1, j]
            factor[k, j], factor[k + 1, j] = c * above + s * below, c * below - s * above
        above, below = aims[k], aims[k + 1]
        aims[k], aims[k + 1] = c * above + s * below, c * below - s * above
        for r in range(basis.shape[1]):
            above, below = basis[k, r], basis[k + 1, r]
            basis[k, r], basis[k + 1, r] = c * above + s * below, c * below - s * above


@compiled
def _solved(factor: Any, aims: Any, size: int) -> Any:
    """Solution of the triangular equations."""
    found = np.empty(size)
    for k in range(size - 1, -1, -1):
        value = aims[k]
        for j in range(k + 1, size):
            value -= factor[k, j] * found[j]
        found[k] = value / factor[k, k]
    return found


@compiled
def _dot(one: Any, other: Any) -> float:
    """The inner product, in four sums that a processor can form at once."""
    count = len(one)
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    whole = count - count % 4
    for k in range(0, whole, 4):
        a += one[k] * other[k]
        b += one[k + 1] * other[k + 1]
        c += one[k + 2] * other[k + 2]
        d += one[k + 3] * other[k + 3]
    for k in range(whole, count):
        a += one[k] * other[k]
    return (a + b) + (c + d)


@compiled
def _dot_of_blocks(column: Any, other: Any, blocks: Any, width: int) -> float:
    """The inner product with a column that is zero but for its blocks."""
    total = 0.0
    for first in blocks:
        for r in range(first, first + width if first >= 0 else first):
            total += column[r] * other[r]
    return total
