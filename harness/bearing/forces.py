"""The contact forces of a load at rest: vertical, at the corners of contact patches.

Where a box rests on several others, balance leaves the forces open. Taken are those of the least
elastic energy among contacts that are equally stiff by area, as thin layers of cardboard are: they
are unique, and pressure varies evenly over a patch.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import clarabel
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear
from scipy.sparse import csc_array, diags_array, eye_array, vstack
from scipy.sparse.linalg import splu

from steadyload import kernels
from steadyload.bearing.cones import is_solved, solve_cones
from steadyload.bearing.corners import corner_columns
from steadyload.kernels.constants import EDGE
from steadyload.layouts.contacts import FLOOR, Patch, Supports, find_supports
from steadyload.layouts.model import Arrangement, FloatArray

_BALANCED = 1e-7
"""What may be left of a box's weight, and of its moments, in balance; of the largest of them."""

_EXACT = 1e-12
"""What rounding may leave of equations that have been solved, of the largest right side."""

_MOMENTS, _ENERGY = 1e-2, 1e-5
"""What moments, and the square root of the energy, count beside weights where nothing balances."""


@dataclass(frozen=True)
class ContactForces:
    """Forces at the corners of contact patches, upwards on the upper box.

    Attributes:
        below, above: the two boxes of every force, :data:`FLOOR` for the floor, shape (k,).
        positions: (x, y, z) [cm], shape (k, 3); a patch counts :data:`EDGE` wider on each side, as
            it does in the equilibrium.
        forces: [kg], 0 or more, shape (k,).
    """

    below: NDArray[np.int64]
    above: NDArray[np.int64]
    positions: FloatArray
    forces: FloatArray

    def resultants(self) -> FloatArray:
        """The force of every contact: where it acts (x, y, z) [cm] and its size [kg], (n, 4)."""
        forces = self.forces.reshape(-1, 4)
        total = forces.sum(axis=1)
        presses = total > 0.0
        places = (self.positions.reshape(-1, 4, 3) * forces[:, :, None]).sum(axis=1)[presses]
        return np.column_stack((places / total[presses, None], total[presses]))


class Statics:
    """The equations of balance of a load at rest, one unknown a corner of a contact patch.

    Args:
        layout: the load; its boxes so far where it still grows.
        among: the boxes of whole groups that are joined by standing on each other, J of them, in
            whose order all arrays are; None for all boxes.
        supports: the contacts of the layout, where somebody has them already.

    Attributes:
        weights: of the boxes [kg], shape (J,).
        patches: the contacts, those with the floor among them.
        matrix: weights and moments that unit forces exert on every box, in weights of that box and
            in sides of it, shape (3 J, 4 k).
        right: what they have to come to, shape (3 J,).
    """

    def __init__(
        self,
        layout: Arrangement,
        among: Sequence[int] | None = None,
        supports: Supports | None = None,
    ) -> None:
        items = list(range(len(layout)) if among is None else among)
        lower, upper = layout.lower[items], layout.upper[items]
        self.weights = layout.weights[items]
        self.patches = _patches(layout, items, supports or find_supports(layout))
        self._offsets = layout.mass_offsets[items]
        centres = 0.5 * (lower + upper) + self._offsets
        columns = np.zeros((len(items), 3, 0))
        if self.patches:
            columns = corner_columns(range(len(items)), self.patches, centres, EDGE)
        self._scale = np.ones((len(items), 3))
        self._scale[:, 1:] = (upper - lower)[:, ::2]
        self._scale *= self.weights[:, None]
        self.matrix = (columns / self._scale[:, :, None]).reshape(3 * len(items), -1)
        self.right = np.tile([1.0, 0.0, 0.0], len(items))

    def pressed(self, item: int) -> FloatArray:
        """The right side that a weight of 1 kg in the middle of a box's top adds."""
        found = np.zeros((len(self.weights), 3))
        along_x, _, along_z = -self._offsets[item]
        # Moments of the contact forces about the centre of mass balance that of the weight.
        found[item] = np.array((1.0, along_x, along_z)) / self._scale[item]
        return found.ravel()

    def tops(self) -> FloatArray:
        """The matrix from corner forces to the loads on tops, shape (J, 4 k)."""
        found = np.zeros((len(self.weights), 4 * len(self.patches)))
        for place, patch in enumerate(self.patches):
            if patch.below != FLOOR:
                found[patch.below, 4 * place : 4 * place + 4] = 1.0
        return found

    def least_energy(self, right: FloatArray | None = None) -> FloatArray | None:
        """The corner forces of least energy [kg], shape (4 k,); None where none balance.

        Args:
            right: in place of :attr:`right`.
        """
        right = self.right if right is None else right
        if not self.patches:
            return None
        unit, soft = float(self.weights.mean()), self._soft()
        n = len(soft)
        matrix = csc_array(self.matrix * unit)
        solution = solve_cones(
            csc_array(diags_array(soft)),
            np.zeros(n),
            csc_array(vstack((matrix, -eye_array(n)))),
            np.concatenate((right, np.zeros(n))),
            [clarabel.ZeroConeT(len(right)), clarabel.NonnegativeConeT(n)],
        )
        guesses = [unit * np.maximum(np.asarray(solution.x), 0.0)] if is_solved(solution) else []
        for guess in (*guesses, None):  # the solver may fail where weights differ by 10,000 times
            guess = self.nearest(right) if guess is None else guess
            found = self._polished(guess, soft, right)
            if np.abs(self.matrix @ found - right).max() <= _BALANCED * np.abs(right).max():
                return found
        return None

    def nearest(self, right: FloatArray | None = None) -> FloatArray:
        """The corner forces that come nearest to balance [kg], shape (4 k,).

        They carry weights before they balance moments, and have the least energy of such.

        Args:
            right: in place of :attr:`right`.
        """
        right = self.right if right is None else right
        if not self.patches:
            return np.zeros(0)
        rows = np.tile([1.0, _MOMENTS, _MOMENTS], len(self.weights))
        unit, soft = float(self.weights.mean()), self._soft()
        stacked = np.vstack((rows[:, None] * self.matrix * unit, np.diag(_ENERGY * np.sqrt(soft))))
        target = np.concatenate((rows * right, np.zeros(len(soft))))
        # SciPy's nnls (1.17.1) ends at forces that are far from the least where columns are alike.
        columns = np.ascontiguousarray(stacked.T)
        found, _, ended = kernels.least_squares.nonnegative_least_squares(columns, target)
        if not ended:
            found = lsq_linear(stacked, target, (0.0, np.inf)).x
        return unit * np.asarray(found)

    def _soft(self) -> FloatArray:
        """How far every corner yields to a force, relative to the mean, shape (4 k,)."""
        areas = np.array([(p.x1 - p.x0) * (p.z1 - p.z0) for p in self.patches])
        return np.repeat(areas.mean() / areas, 4)

    def _polished(self, found: FloatArray, soft: FloatArray, right: FloatArray) -> FloatArray:
        """The same, balanced to rounding: once it is known what presses, all is linear."""
        kept = found > 1e-7 * found.max()
        pressing = self.matrix[:, kept] / np.sqrt(soft[kept])
        exact = _least_solution(pressing, right) / np.sqrt(soft[kept])
        polished = np.zeros_like(found)
        polished[kept] = np.maximum(exact, 0.0)
        left, before = (np.abs(self.matrix @ f - right).max() for f in (polished, found))
        return polished if left <= before else found


def contact_forces(layout: Arrangement) -> ContactForces | None:
    """The forces that hold a load at rest.

    Args:
        layout: the complete load.

    Returns:
        Those of least energy, see the module; None where no forces that only push, straight up,
        balance every box: then something falls.
    """
    statics = Statics(layout)
    found = statics.least_energy()
    if found is None:
        return None
    corners = [
        (p.below, p.above, x, layout.lower[p.above, 1], z)
        for p in statics.patches
        for x in (p.x0 - EDGE, p.x1 + EDGE)
        for z in (p.z0 - EDGE, p.z1 + EDGE)
    ]
    table = np.array(corners)
    return ContactForces(
        table[:, 0].astype(np.int64), table[:, 1].astype(np.int64), table[:, 2:], found
    )


def _least_solution(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """The solution of the least norm of sparse equations, or what comes nearest to one.

    What the transposed matrix makes of anything has no smaller solution beside it: where equations
    do not depend on each other, that is found without a dense factorisation.
    """
    sparse = csc_array(matrix)
    found, left = np.zeros(matrix.shape[1]), right
    try:
        factors = splu(csc_array(sparse @ sparse.T))
        for _ in range(3):
            found = found + sparse.T @ factors.solve(left)
            left = right - sparse @ found
    except RuntimeError:  # exactly singular
        pass
    if np.abs(left).max() <= _EXACT * np.abs(right).max():
        return found
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=None)[0], dtype=np.float64)


def _patches(layout: Arrangement, items: Sequence[int], supports: Supports) -> Sequence[Patch]:
    """The contacts of some boxes with each other and the floor, by their places in the list; a box
    with its whole base on the floor stands on a patch of that size.
    """
    place = {item: k for k, item in enumerate(items)}
    place[FLOOR] = FLOOR
    found = []
    for above, item in enumerate(items):
        if supports.on_floor[item]:
            (x0, _, z0), (x1, _, z1) = layout.lower[item].tolist(), layout.upper[item].tolist()
            found.append(Patch(FLOOR, above, x0, z0, x1, z1))
        found += [
            patch._replace(below=place[patch.below], above=above)
            for patch in supports.below[item]
            if patch.below in place
        ]
    return found
