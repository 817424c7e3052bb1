"""Convex programmes over cones, solved by Clarabel: quiet, and on one thread."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import clarabel
from scipy.sparse import csc_array

from steadyload.layouts.model.layout import FloatArray

_SOLVED = frozenset({"Solved", "AlmostSolved"})


def solve_cones(
    quadratic: csc_array,
    linear: FloatArray,
    rows: csc_array,
    right: FloatArray,
    cones: Sequence[Any],
    check_time: Callable[[], None] = lambda: None,
) -> clarabel.DefaultSolution:
    """The x of least ``x . quadratic x / 2 + linear . x`` for which ``right - rows x`` is in cones.

    Args:
        quadratic: symmetric, positive semidefinite, (n, n).
        linear: (n,).
        rows: (m, n).
        right: (m,).
        cones: of the m rows, in turn, as Clarabel names them.
        check_time: called after every iteration; what it raises ends the search.
    """
    settings = clarabel.DefaultSettings()
    settings.verbose, settings.max_threads = False, 1
    solver = clarabel.DefaultSolver(quadratic, linear, rows, right, list(cones), settings)
    ended: list[Exception] = []

    def is_over(_: Any) -> bool:
        try:
            check_time()
        except Exception as error:
            ended.append(error)
        return bool(ended)

    solver.set_termination_callback(is_over)
    solution = solver.solve()
    if ended:
        raise ended[0]
    return solution


def is_solved(solution: clarabel.DefaultSolution) -> bool:
    """Whether a solution is one, and no certificate that there is none, nor a failure."""
    return str(solution.status) in _SOLVED
