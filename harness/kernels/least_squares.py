"""Non-negative least squares, for the few rows and columns that contact forces have."""

from __future__ import annotations

from typing import Any

import numpy as np

from steadyload.kernels.compiled import compiled

_PATIENCE = 3
"""Iterations a column, after which the search gives up."""


@compiled
def nonnegative_least_squares(matrix: Any, target: Any) -> Any:
    """The x >= 0 with the least |matrix x - target|.

    The method of Lawson and Hanson (Solving Least Squares Problems, 1974, chapter 23), with the
    factors of the columns that are positive kept from step to step (Gram and Schmidt, twice).

    Args:
        matrix: shape (m, n).
        target: shape (m,).

    Returns:
        x, shape (n,), the residual target - matrix x, shape (m,), and whether it ended.
    """
    rows, count = matrix.shape
    columns = np.ascontiguousarray(matrix.T)
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
    refused = np.zeros(count, dtype=np.bool_)
    for _ in range(_PATIENCE * count + 10):
        best, steepest = -1, least
        for k in range(count):
            if not is_chosen[k] and not refused[k]:
                slope = _dot(columns[k], residual)
                if slope > steepest:
                    best, steepest = k, slope
        if best < 0 or size == most:
            return x, residual, True
        if not _append(columns[best], basis, factor, size):
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
            kept = 0
            first = size
            for k in range(size):
                if x[chosen[k]] > 0.0:
                    chosen[kept] = chosen[k]
                    kept += 1
                else:
                    first = min(first, kept)
                    x[chosen[k]] = 0.0
                    is_chosen[chosen[k]] = False
            size = first
            while size < kept:
                if not _append(columns[chosen[size]], basis, factor, size):
                    return x, residual, False
                aims[size] = _dot(basis[size], target)
                size += 1
            if size == 0:
                break
            goal = _solved(factor, aims, size)
        for k in range(size):
            x[chosen[k]] = goal[k]
        residual[:] = target
        for k in range(size):
            weight = x[chosen[k]]
            for r in range(rows):
                residual[r] -= weight * columns[chosen[k], r]
    return x, residual, False


@compiled
def _append(column: Any, basis: Any, factor: Any, size: int) -> bool:
    """Orthogonalise a column against the first ones of a basis and put it behind them.

    Returns:
        False where it lies in their span.
    """
    rest = column.copy()
    whole = np.sqrt(_dot(column, column))
    for k in range(size):
        factor[k, size] = 0.0
    for _ in range(2):
        for k in range(size):
            along = _dot(basis[k], rest)
            factor[k, size] += along
            for r in range(len(rest)):
                rest[r] -= along * basis[k, r]
    length = np.sqrt(_dot(rest, rest))
    if not length > 1e-13 * whole:
        return False
    factor[size, size] = length
    for r in range(len(rest)):
        basis[size, r] = rest[r] / length
    return True


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
    """The inner product, without the threads of a library."""
    total = 0.0
    for k in range(len(one)):
        total += one[k] * other[k]
    return total
