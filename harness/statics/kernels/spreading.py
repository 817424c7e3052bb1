"""One way for patches below an item to carry a vertical force."""

from __future__ import annotations

from typing import Any

import numpy as np

from steadyload.statics.kernels.compiled import compiled
from steadyload.statics.kernels.constants import EDGE
from steadyload.statics.kernels.contacts import is_left
from steadyload.statics.kernels.least_squares import nonnegative_least_squares


@compiled
def spread(force: float, x: float, z: float, patches: Any, presses: Any) -> bool:
    """One way for patches to carry a force; False where none is found.

    Args:
        force: downwards [kg].
        x: where it acts [cm].
        z: likewise.
        patches: (x0, z0, x1, z1) [cm], shape (k, 4).
        presses: the force at every patch and its moments are put there, shape (k, 3).
    """
    presses[:] = 0.0
    owners, count = np.empty(len(patches), dtype=np.int64), 0
    for k in range(len(patches)):
        if not is_left(patches, k):
            continue
        owners[count] = k
        count += 1
        x0, z0, x1, z1 = patches[k]
        if x0 - EDGE <= x <= x1 + EDGE and z0 - EDGE <= z <= z1 + EDGE:
            presses[k, 0], presses[k, 1], presses[k, 2] = force, force * x, force * z
            return True
    if count < 2:
        return False
    # First where each patch is nearest to the force, as a stiff beam presses; then at the corners.
    for corners in (1, 4):
        points = np.empty((count * corners, 2))
        for k in range(count):
            x0, z0, x1, z1 = patches[owners[k]]
            for corner in range(corners):
                at = k * corners + corner
                if corners == 1:
                    points[at, 0], points[at, 1] = min(max(x, x0), x1), min(max(z, z0), z1)
                else:
                    points[at, 0] = x0 if corner < 2 else x1
                    points[at, 1] = z0 if corner % 2 == 0 else z1
        if _shared(force, x, z, points, corners, owners, presses):
            return True
    return False


@compiled
def _shared(
    force: float, x: float, z: float, points: Any, corners: int, owners: Any, presses: Any
) -> bool:
    """Forces at given points whose resultant is the given one, added to the presses of their
    ``owners``, the patches, which have so many points each; False without any.
    """
    # Lengths in units of the farthest point, so that the residue means the same at every size.
    reach = 0.0
    for a, b in points:
        reach = max(reach, max(abs(a - x), abs(b - z)))
    columns, target = np.empty((len(points), 3)), np.zeros(3)
    for k in range(len(points)):
        columns[k, 0] = 1.0
        columns[k, 1] = (points[k, 0] - x) / reach
        columns[k, 2] = (points[k, 1] - z) / reach
    target[0] = 1.0
    parts, rest, ended = nonnegative_least_squares(columns, target)
    if not ended or np.sqrt((rest**2).sum()) * reach > 0.1 * EDGE:
        return False
    for k in range(len(points)):
        if parts[k] > 0.0:
            part, owner = parts[k] * force, owners[k // corners]
            presses[owner, 0] += part
            presses[owner, 1] += part * points[k, 0]
            presses[owner, 2] += part * points[k, 1]
    return True
