"""The loads that boxes of a load at rest bear on their tops, and what they could bear besides."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import csc_array, csr_array, diags_array, hstack

from steadyload.errors import UnsolvedError
from steadyload.layouts.model.layout import FloatArray, Layout
from steadyload.statics.bearing.forces import Statics
from steadyload.time_limit import TimeLimit

_SHARE = 1e-3
"""Width of the interval that a payload is known in, as a share of it."""

_OCTAVES = 12
"""Doublings of a load's own weight up to which a payload is followed; beyond them all is linear."""

_UNBOUNDED = 3
"""Status of a linear programme that has no least value."""

_OUT_OF_TIME = 1
"""Status of a linear programme that was given up."""

_FAR = 1e6
"""Weights of a load that count as infinite, where a solver finds no answer without a bound."""

_LONGER = 4.0
"""Times as long that a linear programme is given where the machine was busy with something else."""

_LEAST = 1e-9
"""Limit that a smaller one counts as where shares are formed [kg]."""


@dataclass(frozen=True)
class Loads:
    """Loads on the tops of all boxes [kg], each of shape (J,).

    Attributes:
        borne: by the contact forces of least energy, see :mod:`steadyload.statics.bearing.forces`.
        least, most: the least and the most that any balancing forces put on a box.
    """

    borne: FloatArray
    least: FloatArray
    most: FloatArray


def loads(layout: Layout, *, timeout: float | None = None) -> Loads | None:
    """The loads on the tops of a complete load's boxes; None where it does not balance.

    Args:
        layout: the load. Its cost is two linear programmes a box that carries something.
        timeout: CPU seconds that it may take, see :mod:`steadyload.time_limit`; None: no limit.

    Raises:
        UnsolvedError: the solver of these finds no answer.
        TimeoutExpiredError: the time is up.
        NumberError: the timeout is no finite number above 0.
    """
    limit = TimeLimit(timeout, "loads")
    statics = Statics(layout, check_time=limit.check)
    found = statics.least_energy()
    if found is None:
        return None
    tops = csr_array(statics.tops())
    least, most = np.zeros(len(layout)), np.zeros(len(layout))
    programme = _Programme(statics, found, limit)
    for item in np.flatnonzero(np.diff(tops.indptr)):
        cost = tops[[item]].toarray().ravel()
        for sign, bound in ((1.0, least), (-1.0, most)):
            bound[item] = max(0.0, sign * programme.least(sign * cost))
    return Loads(tops @ found, least, most)


def payload(layout: Layout, *, timeout: float | None = None) -> FloatArray | None:
    """How much more weight [kg] fits on every box before something tips or is crushed.

    The weight stands in the middle of a box's top, whatever else stands there.

    Args:
        layout: the complete load.
        timeout: see :func:`loads`.

    Returns:
        Shape (J,), infinite where nothing tips and no box has a limit; 0 where a limit is exceeded
        as it is. None for a load that does not balance.

    Raises:
        UnsolvedError, TimeoutExpiredError, NumberError: see :func:`loads`.
    """
    limit = TimeLimit(timeout, "payload")
    statics = Statics(layout, check_time=limit.check)
    found = statics.least_energy()
    if found is None:
        return None
    limits = max_loads(layout)
    return np.array([_payload(statics, found, item, limits, limit) for item in range(len(layout))])


def max_loads(layout: Layout) -> FloatArray:
    """The load that every box may bear [kg], infinite where none is stated, shape (J,)."""
    stated = [item.max_load for item in layout.items]
    return np.array([np.inf if load is None else load for load in stated])


class _Programme:
    """Linear programmes over all forces that balance a load.

    Unknowns and equations are counted in what their boxes carry, so that light boxes count as much
    as heavy ones.

    Args:
        statics: of the load.
        found: forces that balance it; those of the programme balance it as well.
        limit: on the time.
        added: what a weight adds to the right side of the equations, (3 J,); None for no weight.
            The weight is one more unknown, the last.
    """

    def __init__(
        self,
        statics: Statics,
        found: FloatArray,
        limit: TimeLimit,
        added: FloatArray | None = None,
    ) -> None:
        self._limit, self._added = limit, added is not None
        right, unit = statics.right, float(statics.weights.sum())
        self._units, matrix = np.ones(0), statics.matrix
        if added is not None:
            right, matrix = right + unit * added, hstack((matrix, -csc_array(added[:, None])))
            self._units = np.array([unit])
        carried = statics.carried(right)
        self._units = np.concatenate((np.repeat(carried[statics.pairs[:, 1]], 4), self._units))
        rows = 1.0 / np.repeat(carried, 3)
        self._matrix = diags_array(rows) @ matrix @ diags_array(self._units)
        self._right = rows * (statics.matrix @ found)

    def least(self, cost: FloatArray) -> float:
        """The least sum of costs times forces and weight; minus infinity where there is none.

        Raises:
            UnsolvedError: the solver does not tell.
            TimeoutExpiredError: the time is up.
        """
        costs = cost * self._units
        size = float(np.abs(costs).max())
        for method, presolve in (("highs", True), ("highs-ds", False), ("highs-ipm", True)):
            result = self._result(costs / size, method, presolve)
            if result.status == _UNBOUNDED:
                return -np.inf
            if result.success:
                return size * float(result.fun)
        if self._added:
            # HiGHS (1.12) ends at times without a status where a weight may grow without end.
            result = self._result(costs / size, "highs", True, most=_FAR)
            if result.success:
                tips = float(result.x[-1]) < (1.0 - _SHARE) * _FAR
                return size * float(result.fun) if tips else -np.inf
        raise UnsolvedError(f"no least load was found by linear programming: {result.message}")

    def _result(self, costs: FloatArray, method: str, presolve: bool, most: float = np.inf) -> Any:
        """The answer of the solver, which measures wall time: it has more on a busy machine.

        The last unknown is at most ``most``.
        """
        self._limit.check()
        bounds = [(0.0, np.inf)] * (len(costs) - 1) + [(0.0, most)]
        seconds = self._limit.left()
        while True:
            result = linprog(
                costs, A_eq=self._matrix, b_eq=self._right, bounds=bounds, method=method,
                options={"presolve": presolve, "time_limit": seconds},
            )  # fmt: skip
            self._limit.check()
            if result.status != _OUT_OF_TIME or seconds == np.inf:
                return result
            seconds *= _LONGER


def _payload(
    statics: Statics, found: FloatArray, item: int, limits: FloatArray, limit: TimeLimit
) -> float:
    """The least weight at which the load, which some forces balance, tips, or a box is crushed."""
    added = statics.pressed(item)
    cost = np.zeros(len(found) + 1)
    cost[-1] = -1.0
    tips = max(0.0, -_Programme(statics, found, limit, added).least(cost))
    limited = np.flatnonzero(np.isfinite(limits))
    if not len(limited):
        return tips
    tops = csr_array(statics.tops())[limited]

    def over(weight: float) -> FloatArray:
        """By how much every limit is exceeded, as a share of it; at the last, all where it tips."""
        forces = statics.least_energy(statics.right + weight * added)
        if forces is None:
            return np.full(len(limited), np.inf)
        borne = tops @ forces + weight * (limited == item)
        return (borne - limits[limited]) / np.maximum(limits[limited], _LEAST) - 1e-9

    crushed = _first_crossing(over, float(statics.weights.sum()), tips)
    return min(tips, crushed)


def _first_crossing(over: Callable[[float], FloatArray], unit: float, end: float) -> float:
    """The least weight at which something is above 0; infinite where nothing is up to an end.

    What a box bears is linear in the weight between weights at which contacts begin or cease to
    press, and neither rises all the way nor stays where it was: it is followed from 0.
    """
    low, at_low = 0.0, over(0.0)
    if at_low.max() > 0.0:
        return 0.0
    for octave in range(_OCTAVES):
        high = min(unit * 2.0**octave, end * (1.0 - 1e-6))
        at_high = over(high)
        found = _crossing(over, (low, at_low), (high, at_high))
        if found is not None:
            return found
        slope = (at_high - at_low) / (high - low) if high > low else np.zeros(1)
        low, at_low = high, at_high
        if high < unit * 2.0**octave:
            return np.inf
    rising = slope > _SHARE / low
    return float((low - at_low[rising] / slope[rising]).min()) if rising.any() else np.inf


def _crossing(
    over: Callable[[float], FloatArray],
    low: tuple[float, FloatArray],
    high: tuple[float, FloatArray],
) -> float | None:
    """The first crossing between two weights, the first of which crosses nothing."""
    (a, at_a), (b, at_b) = low, high
    if b - a <= _SHARE * b:
        return a if at_b.max() > 0.0 else None
    inner = a + 0.4 * (b - a)
    at_inner = over(inner)
    even = at_a + 0.4 * (at_b - at_a)
    if np.isfinite(at_b).all() and np.abs(at_inner - even).max() <= _SHARE * np.abs(at_b).max():
        crosses = at_b > 0.0
        if not crosses.any():
            return None
        share = -at_a[crosses] / (at_b[crosses] - at_a[crosses])
        return a + float(share.min()) * (b - a)
    found = _crossing(over, low, (inner, at_inner))
    return found if found is not None else _crossing(over, (inner, at_inner), high)
