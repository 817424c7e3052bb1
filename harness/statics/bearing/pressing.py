"""Which corners press, and how much: forces that only push, of least energy, by Newton's method.

Sought are the f >= 0 of least ``f . soft f / 2`` with ``matrix f = right``. There is one number an
equation, its multiplier, from which all forces follow: ``f = max(0, matrix' multipliers) / soft``.
So the multipliers solve as many equations as there are, linear but for the maximum; all matrices
are sparse. The equations yield a little, ``right - matrix f = 1e-12 multipliers``: so there is
always one solution, and the search ends. Where they yield as much as a force does, the solution is
that of least squares of what is left of them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse import csc_array, diags_array
from scipy.sparse.linalg import splu

from steadyload.layouts.model.layout import FloatArray

_Solve = Callable[[FloatArray], FloatArray]

_MOST = 200
"""Iterations, after which the last forces are taken."""

_ENOUGH = 1e-13
"""What an equation may be left with, of its scale."""

_ROUNDS = 6
"""Rounds of refinement against rounding."""

_DENSE = 90
"""Equations up to which sparse matrices cost more than they save."""

FIRM = 1e-12
"""How little equations yield, which may depend on each other or have no solution."""


class Corners:
    """Forces at corners, the equations that they enter, and how far each corner yields.

    Args:
        matrix: what unit forces add to the equations, (m, n).
        soft: how far every corner yields to a force, above 0, shape (n,).
        scale: size of what stands in every equation, above 0, shape (m,).
        check_time: called before every factorisation; what it raises ends the search.
        firm: what every equation yields to its multiplier, above 0; None where it should not.
    """

    def __init__(
        self,
        matrix: csc_array,
        soft: FloatArray,
        scale: FloatArray,
        check_time: Callable[[], None],
        firm: float | None = None,
    ) -> None:
        self._firm = FIRM if firm is None else firm
        self._rounding = 1.0 if firm is None else 0.0
        self._root = np.sqrt(soft)
        scaled = csc_array(matrix @ diags_array(1.0 / self._root))
        self._matrix = scaled.toarray() if len(scale) <= _DENSE else scaled
        self._scale = scale
        self._check_time = check_time
        self._known: tuple[NDArray[np.bool_], _Solve] | None = None

    def pressing(self, right: FloatArray, start: NDArray[np.bool_] | None = None) -> FloatArray:
        """The forces of least energy, the equations solved as nearly as these can be, shape (n,).

        Args:
            right: shape (m,).
            start: which corners probably press, shape (n,).
        """
        active = np.ones(len(self._root), dtype=np.bool_) if start is None else start
        multipliers = self._solver(active)(right)
        whole = True
        for _ in range(_MOST):
            pull = self._matrix.T @ multipliers
            before, active = active, pull > 0.0
            if whole and np.array_equal(active, before):
                break
            left = right - self._matrix @ np.where(active, pull, 0.0) - self._firm * multipliers
            if (np.abs(left) <= _ENOUGH * self._scale).all():
                break
            step = self._solver(active)(left)
            share = _share(
                pull, self._matrix.T @ step, float(step @ (right - self._firm * multipliers)),
                self._firm * float(step @ step),
            )  # fmt: skip
            multipliers, whole = multipliers + share * step, share == 1.0
        return np.asarray(np.maximum(self._matrix.T @ multipliers, 0.0) / self._root)

    def refined(self, active: NDArray[np.bool_], right: FloatArray) -> FloatArray:
        """The forces of least energy that solve the equations, where it is known which press.

        Then all is linear; where nothing solves the equations, it comes near to that.

        Args:
            active: which press, shape (n,).
            right: shape (m,).
        """
        inner, solve = self._matrix[:, active], self._solver(active)
        pull = best = np.zeros(inner.shape[1])
        least = np.inf
        for _ in range(_ROUNDS):
            left = right - inner @ pull
            size = float((np.abs(left) / self._scale).max())
            if not size < least:
                break
            best, least = pull, size
            if size <= 0.01 * _ENOUGH:
                break
            pull = pull + inner.T @ solve(left)
        forces = np.zeros(len(active))
        forces[active] = np.maximum(best, 0.0) / self._root[active]
        return forces

    def _solver(self, active: NDArray[np.bool_]) -> _Solve:
        """Solves for multipliers where it is known which corners press; the last is kept."""
        if self._known is None or not np.array_equal(self._known[0], active):
            self._check_time()
            self._known = active, self._factorised(active)
        return self._known[1]

    def _factorised(self, active: NDArray[np.bool_]) -> _Solve:
        inner = self._matrix[:, active]
        square = inner @ inner.T
        diagonal = self._firm * (1.0 + self._rounding * square.diagonal())
        if isinstance(inner, np.ndarray):
            return partial(lu_solve, lu_factor(square + np.diag(diagonal)))
        factors = splu(
            csc_array(square + diags_array(diagonal)), permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0, options={"SymmetricMode": True},
        )  # fmt: skip
        return partial(factors.solve)


def _share(pull: FloatArray, turn: FloatArray, rise: float, bend: float) -> float:
    """How much of a step to take: all, or up to where what is left no longer points along it.

    Args:
        pull: of all corners.
        turn: how it changes over the step.
        rise: the step times the right side, less what is damped.
        bend: how that falls over the step.
    """

    def along(share: float) -> float:
        return rise - bend * share - float(turn @ np.maximum(pull + share * turn, 0.0))

    if along(1.0) >= -1e-9 * abs(rise):
        return 1.0
    with np.errstate(divide="ignore", invalid="ignore"):
        turns = -pull / turn
    places = np.sort(turns[(turns > 0.0) & (turns < 1.0)])
    low, high = 0, len(places)
    while low < high:  # the first place behind which it points back
        middle = (low + high) // 2
        if along(float(places[middle])) > 0.0:
            low = middle + 1
        else:
            high = middle
    a = float(places[low - 1]) if low else 0.0
    b = float(places[low]) if low < len(places) else 1.0
    at_a, at_b = along(a), along(b)
    share = a if at_a <= at_b else a + (b - a) * at_a / (at_a - at_b)
    return min(1.0, share) if share > 0.0 else 1.0
