"""Forces of least energy of a load that grows: what was found before is changed, not found anew.

As in :mod:`steadyload.statics.bearing.pressing`, all forces follow from one multiplier an equation.
The factors L D L' of the equations of these are kept: a corner that begins or ceases to press
changes few columns of L (Gill, Golub, Murray and Saunders, Methods for modifying matrix
factorizations, 1974, method C1; along the elimination tree as in Davis and Hager, Modifying a
sparse Cholesky factorization, 1999).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from steadyload.statics.kernels.compiled import compiled

_MOST = 30
"""Iterations, after which it is given up."""

_ENOUGH = 1e-10
"""What an equation may be left with, of what its box bears and stands on."""


class Factors(NamedTuple):
    """L D L' of the equations; the ones on the diagonal of L are left out.

    Attributes:
        starts: of the columns of L, (m + 1,).
        rows: of its entries, in order; some may be zero for now.
        values: of these.
        diagonal: D, (m,).
    """

    starts: Any
    rows: Any
    values: Any
    diagonal: Any


class Columns(NamedTuple):
    """Effects of unit forces at corners, over the roots of how far the corners yield.

    Attributes:
        starts: of the columns, (n + 1,).
        rows: equations, three a box, the first of them that of its weight.
        values: of the entries.
    """

    starts: Any
    rows: Any
    values: Any


@compiled
def solved(
    factors: Factors, columns: Columns, corners: Any, equations: Any, right: Any, presses: Any,
    held: Any, multipliers: Any, pulls: Any,
) -> bool:  # fmt: skip
    """Whether the forces of the least energy are found, by Newton's method.

    Where they are not, what is changed in place is of no more use.

    Args:
        factors: of the equations where the corners that are held press; changed.
        columns: of all corners.
        corners: those of boxes that are there, (k,).
        equations: of the same boxes, in order.
        right: of all equations, (m,).
        presses: which corners probably press, and in the end do, (n,); changed.
        held: which corners press by the factors, (n,); changed.
        multipliers: found before, and in the end, (m,); changed.
        pulls: put here are the forces at the corners that count, times the roots, (k,); what is
            below 0 is none.
    """
    work, rest, scale = np.zeros(len(right)), np.zeros(len(right)), np.zeros(len(right))
    for turn in range(_MOST):
        for e in equations:
            rest[e] = scale[e] = right[e]
        for k, c in enumerate(corners):
            pull = 0.0
            for q in range(columns.starts[c], columns.starts[c + 1]):
                pull += columns.values[q] * multipliers[columns.rows[q]]
            pulls[k] = pull
            if turn > 0:
                presses[c] = pull > 0.0
            if presses[c] != held[c]:
                held[c] = presses[c]
                if not _updated(factors, columns, c, 1.0 if held[c] else -1.0, work):
                    return False
            if presses[c]:
                for q in range(columns.starts[c], columns.starts[c + 1]):
                    part = columns.values[q] * pull
                    rest[columns.rows[q]] -= part
                    scale[columns.rows[q]] += abs(part)
        left = 0.0
        for e in equations:
            left = max(left, abs(rest[e]) / scale[e - e % 3])
        if turn > 0 and left <= _ENOUGH:
            return True
        if not left < np.inf:
            return False
        _solve(factors, equations, rest)
        for e in equations:
            multipliers[e] += rest[e]
    return False


@compiled
def _updated(factors: Factors, columns: Columns, corner: int, sign: float, work: Any) -> bool:
    """Add a column times itself, or take it off; False where rounding leaves nothing positive."""
    first = len(work)
    for q in range(columns.starts[corner], columns.starts[corner + 1]):
        work[columns.rows[q]] = columns.values[q]
        first = min(first, columns.rows[q])
    at, share = first, sign
    while True:
        value, before = work[at], factors.diagonal[at]
        work[at] = 0.0
        now = before + share * value * value
        if not now > 0.0:
            return False
        turn = share * value / now
        share *= before / now
        factors.diagonal[at] = now
        start, end = factors.starts[at], factors.starts[at + 1]
        for q in range(start, end):
            row = factors.rows[q]
            work[row] -= value * factors.values[q]
            factors.values[q] += turn * work[row]
        if start == end:
            return True
        at = factors.rows[start]


@compiled
def _solve(factors: Factors, equations: Any, right: Any) -> None:
    """Put the solution in the place of the right side."""
    for j in equations:
        value = right[j]
        for q in range(factors.starts[j], factors.starts[j + 1]):
            right[factors.rows[q]] -= factors.values[q] * value
    for k in range(len(equations) - 1, -1, -1):
        j = equations[k]
        value = right[j] / factors.diagonal[j]
        for q in range(factors.starts[j], factors.starts[j + 1]):
            value -= factors.values[q] * right[factors.rows[q]]
        right[j] = value
