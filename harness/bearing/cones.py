"""Convex programmes over cones, solved by Clarabel: quiet, and on one thread."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import clarabel
from scipy.sparse import csc_array

from steadyload.layouts.model import FloatArray

_SOLVED = frozenset({"Solved", "AlmostSolved"})


def solve_cones(
    quadratic: csc_array,
    linear: FloatArray,
    rows: csc_array,
    right: FloatArray,
    cones: Sequence[Any],
) -> clarabel.DefaultSolution:
    """The x of least ``x . quadratic x / 2 + linear . x`` for which ``right - rows x`` is in cones.

    Args:
        quadratic: symmetric, positive semidefinite, (n, n).
        linear: (n,).
        rows: (m, n).
        right: (m,).
        cones: of the m rows, in turn, as Clarabel names them.
    """
    settings = clarabel.DefaultSettings()
    settings.verbose, settings.max_threads = False, 1
    return clarabel.DefaultSolver(quadratic, linear, rows, right, list(cones), settings).solve()


def is_solved(solution: clarabel.DefaultSolution) -> bool:
    """Whether a solution is one, and no certificate that there is none, nor a failure."""
    return str(solution.status) in _SOLVED
