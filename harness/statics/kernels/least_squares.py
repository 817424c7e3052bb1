"""Non-negative least squares, for the few rows and columns that contact forces have."""

from __future__ import annotations

from typing import Any

import numpy as np

from steadyload.statics.kernels.compiled import compiled

_PATIENCE = 3
"""Iterations a column, after which the search gives up."""


_ROUNDING = 2.0**-53
"""Share of a column that is none: it is what rounding leaves of an inner product of zero."""

_ENOUGH = 0.1
"""A column of which so much is left is orthogonal to the others after one pass."""


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
    count, rows = columns.shape
    blocks, likely = np.zeros((count, 1), dtype=np.int64), np.empty(0, dtype=np.int64)
    return least_squares_of_blocks(columns.reshape(count, 1, rows), target, blocks, likely)


@compiled
def least_squares_of_blocks(columns: Any, target: Any, blocks: Any, likely: Any) -> Any:
    """See :func:`nonnegative_least_squares`; of columns that are zero but for a few blocks.

    Args:
        columns: their blocks, C-contiguous, shape (n, b, width).
        target: shape (m,).
        blocks: the first rows of the blocks of every column, -1 for none, shape (n, b).
        likely: columns whose x are probably positive, with which the search begins.
    """
    count, rows = len(columns), len(target)
    most = min(rows, count)
    x = np.zeros(count)
    residual = target.copy()
    chosen = np.empty(most, dtype=np.int64)
    is_chosen = np.zeros(count, dtype=np.bool_)
    basis, factor = np.empty((most, rows)), np.zeros((most, most))
    spans = np.empty((most, 2), dtype=np.int64)
    aims = np.empty(most)
    size = 0
    largest = 0.0
    for k in range(count):
        largest = max(largest, np.abs(columns[k]).sum())
    least = 10.0 * max(rows, count) * np.spacing(1.0) * largest
    for k in _by_rows(likely, blocks, rows):
        if size < most and _append(columns[k], blocks[k], basis, spans, factor, size):
            chosen[size] = k
            aims[size] = _dot(basis[size], target)
            size += 1
    while size > 0:
        goal = _solved(factor, aims, size)
        before = size
        for k in range(before - 1, -1, -1):
            if not goal[k] > 0.0:
                _remove(k, chosen, basis, spans, factor, aims, size)
                size -= 1
        if size == before:
            break
    for k in range(size):
        x[chosen[k]] = goal[k]
        is_chosen[chosen[k]] = True
    _put_residual(residual, target, x, columns, chosen, size, blocks)
    refused = np.zeros(count, dtype=np.bool_)
    for _ in range(_PATIENCE * count + 10):
        best, steepest = -1, least
        for k in range(count):
            if not is_chosen[k] and not refused[k]:
                slope = _dot_of_blocks(columns[k], residual, blocks[k])
                if slope > steepest:
                    best, steepest = k, slope
        if best < 0 or size == most:
            return x, residual, True
        if not _append(columns[best], blocks[best], basis, spans, factor, size):
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
                    _remove(k, chosen, basis, spans, factor, aims, size)
                    size -= 1
            if size == 0:
                break
            goal = _solved(factor, aims, size)
        for k in range(size):
            x[chosen[k]] = goal[k]
        _put_residual(residual, target, x, columns, chosen, size, blocks)
    return x, residual, False


@compiled
def _by_rows(some: Any, blocks: Any, rows: int) -> Any:
    """Columns by their first row, so that most have no row in common: less is to be subtracted."""
    place = np.empty(len(some), dtype=np.int64)
    for n in range(len(some)):
        first, last = rows, -1
        for start in blocks[some[n]]:
            if start >= 0:
                first, last = min(first, start), max(last, start)
        place[n] = first * rows + last
    return some[np.argsort(place, kind="mergesort")]


@compiled
def _put_residual(
    residual: Any, target: Any, x: Any, columns: Any, chosen: Any, size: int, blocks: Any
) -> None:
    """The target less the chosen columns times their x."""
    residual[:] = target
    for k in chosen[:size]:
        for b in range(blocks.shape[1]):
            first = blocks[k, b]
            for r in range(columns.shape[2] if first >= 0 else 0):
                residual[first + r] -= x[k] * columns[k, b, r]


@compiled
def _append(column: Any, blocks: Any, basis: Any, spans: Any, factor: Any, size: int) -> bool:
    """Orthogonalise a column against the first ones of a basis and put it behind them.

    Returns:
        False where it lies in their span.
    """
    rows, width = basis.shape[1], column.shape[1]
    rest, first, end = np.zeros(rows), rows, 0
    for b in range(len(blocks)):
        start = blocks[b]
        if start >= 0:
            first, end = min(first, start), max(end, start + width)
            for r in range(width):
                rest[start + r] = column[b, r]
    whole = np.sqrt(_dot(rest[first:end], rest[first:end]))
    for k in range(size):
        share = 0.0
        if spans[k, 0] < end and spans[k, 1] > first:
            share = _dot_of_blocks(column, basis[k], blocks)
        factor[size, k] = share if abs(share) > _ROUNDING * whole else 0.0
    for k in range(size):
        if factor[size, k] != 0.0:
            a, b = spans[k]
            _subtract(factor[size, k], basis[k, a:b], rest[a:b])
            first, end = min(first, a), max(end, b)
    length = np.sqrt(_dot(rest[first:end], rest[first:end]))
    for k in range(size if length < _ENOUGH * whole else 0):
        a, b = max(spans[k, 0], first), min(spans[k, 1], end)
        along = _dot(basis[k, a:b], rest[a:b]) if a < b else 0.0
        if abs(along) > _ROUNDING * length:
            factor[size, k] += along
            a, b = spans[k]
            _subtract(along, basis[k, a:b], rest[a:b])
            first, end = min(first, a), max(end, b)
    length = np.sqrt(_dot(rest[first:end], rest[first:end]))
    if not length > 1e-13 * whole:
        return False
    factor[size, size] = length
    basis[size] = 0.0
    for r in range(first, end):
        basis[size, r] = rest[r] / length
    spans[size, 0], spans[size, 1] = first, end
    return True


@compiled
def _subtract(share: float, one: Any, rest: Any) -> None:
    for r in range(len(rest)):
        rest[r] -= share * one[r]


@compiled
def _remove(
    column: int, chosen: Any, basis: Any, spans: Any, factor: Any, aims: Any, size: int
) -> None:
    """Take a column out of the factors: rotations make them triangular again."""
    for k in range(column, size - 1):
        chosen[k] = chosen[k + 1]
        for j in range(k + 2):
            factor[k, j] = factor[k + 1, j]
        above, below = factor[k, k], factor[k, k + 1]
        length = np.hypot(above, below)
        if length == 0.0:
            continue
        c, s = above / length, below / length
        factor[k, k], factor[k, k + 1] = length, 0.0
        for j in range(k + 2, size):
            above, below = factor[j, k], factor[j, k + 1]
            factor[j, k], factor[j, k + 1] = c * above + s * below, c * below - s * above
        above, below = aims[k], aims[k + 1]
        aims[k], aims[k + 1] = c * above + s * below, c * below - s * above
        a, b = min(spans[k, 0], spans[k + 1, 0]), max(spans[k, 1], spans[k + 1, 1])
        spans[k, 0], spans[k, 1], spans[k + 1, 0], spans[k + 1, 1] = a, b, a, b
        for r in range(a, b):
            above, below = basis[k, r], basis[k + 1, r]
            basis[k, r], basis[k + 1, r] = c * above + s * below, c * below - s * above


@compiled
def _solved(factor: Any, aims: Any, size: int) -> Any:
    """Solution of the triangular equations; a row of ``factor`` is a column of them."""
    found = aims[:size].copy()
    for k in range(size - 1, -1, -1):
        found[k] /= factor[k, k]
        _subtract(found[k], factor[k, :k], found[:k])
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
def _dot_of_blocks(column: Any, other: Any, blocks: Any) -> float:
    """The inner product with a column that is zero but for its blocks."""
    total = 0.0
    for b in range(len(blocks)):
        first = blocks[b]
        for r in range(column.shape[1] if first >= 0 else 0):
            total += column[b, r] * other[first + r]
    return total
