"""The loads that boxes of a load at rest bear on their tops, and what they could bear besides."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog

from steadyload.bearing.forces import Statics
from steadyload.layouts.model import FloatArray, Layout

_SHARE = 1e-3
"""Width of the interval that a payload is known in, as a share of it."""

_OCTAVES = 12
"""Doublings of a load's own weight up to which a payload is followed; beyond them all is linear."""

_LEAST = 1e-9
"""Limit that a smaller one counts as where shares are formed [kg]."""


@dataclass(frozen=True)
class Loads:
    """Loads on the tops of all boxes [kg], each of shape (J,).

    Attributes:
        borne: by the contact forces of least energy, see :mod:`steadyload.bearing.forces`.
        least, most: the least and the most that any balancing forces put on a box.
    """

    borne: FloatArray
    least: FloatArray
    most: FloatArray


def loads(layout: Layout) -> Loads | None:
    """The loads on the tops of a complete load's boxes; None where it does not balance.

    Args:
        layout: the load. Its cost is two linear programmes a box that carries something.
    """
    statics = Statics(layout)
    found = statics.least_energy()
    if found is None:
        return None
    tops = statics.tops()
    least, most = np.zeros(len(layout)), np.zeros(len(layout))
    for item in np.flatnonzero(tops.any(axis=1)):
        for sign, bound in ((1.0, least), (-1.0, most)):
            result = linprog(
                sign * tops[item], A_eq=statics.matrix, b_eq=statics.right, method="highs"
            )
            if not result.success:
                return None
            bound[item] = max(0.0, sign * result.fun)
    return Loads(tops @ found, least, most)


def payload(layout: Layout) -> FloatArray | None:
    """How much more weight [kg] fits on every box before something tips or is crushed.

    The weight stands in the middle of a box's top, whatever else stands there.

    Args:
        layout: the complete load.

    Returns:
        Shape (J,), infinite where nothing tips and no box has a limit; 0 where a limit is exceeded
        as it is. None for a load that does not balance.
    """
    statics = Statics(layout)
    found = statics.least_energy()
    if found is None:
        return None
    limits = max_loads(layout)
    return np.array([_payload(statics, item, limits) for item in range(len(layout))])


def max_loads(layout: Layout) -> FloatArray:
    """The load that every box may bear [kg], infinite where none is stated, shape (J,)."""
    stated = [item.max_load for item in layout.items]
    return np.array([np.inf if load is None else load for load in stated])


def _payload(statics: Statics, item: int, limits: FloatArray) -> float:
    """The least weight at which the load tips, or a box is crushed."""
    added = statics.pressed(item)
    # The weight is one more unknown: matrix f = right + weight added, f >= 0.
    columns = np.hstack((statics.matrix, -added[:, None]))
    cost = np.zeros(columns.shape[1])
    cost[-1] = -1.0
    result = linprog(cost, A_eq=columns, b_eq=statics.right, method="highs")
    tips = np.inf if result.status == 3 else max(0.0, -float(result.fun or 0.0))
    limited = np.flatnonzero(np.isfinite(limits))
    if not len(limited):
        return tips
    tops = statics.tops()[limited]

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
