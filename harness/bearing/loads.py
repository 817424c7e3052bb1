"""The loads that boxes of a load at rest bear on their tops, and what they could bear besides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog

from steadyload.bearing.forces import Statics
from steadyload.layouts.model import FloatArray, Layout

_SHARE = 1e-3
"""Width of the interval that a payload is known in, as a share of it."""


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
    """The weight at which the load tips, or a box is crushed."""
    added = statics.pressed(item)
    # The weight is one more unknown: matrix f = right + weight added, f >= 0.
    columns = np.hstack((statics.matrix, -added[:, None]))
    cost = np.zeros(columns.shape[1])
    cost[-1] = -1.0
    result = linprog(cost, A_eq=columns, b_eq=statics.right, method="highs")
    tips = np.inf if result.status == 3 else max(0.0, -float(result.fun or 0.0))
    if not np.isfinite(limits).any():
        return tips
    tops = statics.tops()

    def crushes(weight: float) -> bool:
        forces = statics.least_energy(statics.right + weight * added)
        if forces is None:
            return True
        borne = tops @ forces
        borne[item] += weight
        return bool((borne > limits * (1.0 + 1e-9)).any())

    if crushes(0.0):
        return 0.0
    # No box bears more than all of the weight above it.
    total = float(statics.layout.weights.sum())
    low, high = 0.0, min(tips, float(limits[np.isfinite(limits)].sum()) + total)
    if np.isfinite(tips) and not crushes(tips):
        return tips
    if not crushes(high):
        return tips
    while high - low > _SHARE * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if crushes(middle) else (middle, high)
    return low
