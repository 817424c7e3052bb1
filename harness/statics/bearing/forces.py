"""The contact forces of a load at rest: vertical, at the corners of contact patches.

Where a box rests on several others, balance leaves the forces open. Taken are those of the least
elastic energy among contacts that are equally stiff by area, as thin layers of cardboard are: they
are unique, and pressure varies evenly over a patch.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import clarabel
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear
from scipy.sparse import block_array, csc_array, diags_array, eye_array

from steadyload.core.constants import EDGE
from steadyload.core.forces import least_squares
from steadyload.layouts.model.contacts import FLOOR, Supports
from steadyload.layouts.model.layout import Arrangement, FloatArray
from steadyload.statics.bearing.pressing import Corners
from steadyload.statics.cones import is_solved, solve_cones
from steadyload.statics.corners import corner_entries

_BALANCED = 1e-7
"""What may be left of a box's weight, and of its moments, in balance; of what it carries."""

_FEW = 180
"""Equations up to which forces nearest to balance are sought by an exact method, which is slow and
does not end before it is through."""

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


class Rectangles:
    """All contacts of a layout as arrays; a box with its whole base on the floor stands on a
    rectangle of that size.

    Attributes:
        pairs: the lower and the upper item of every contact, shape (k, 2), in the order of the
            upper ones.
        rectangles: ``(x0, z0, x1, z1)`` of every contact [cm], shape (k, 4).
    """

    def __init__(self, layout: Arrangement, supports: Supports) -> None:
        on_floor = np.flatnonzero(supports.on_floor)
        base = np.column_stack((layout.lower[on_floor][:, ::2], layout.upper[on_floor][:, ::2]))
        patches = [patch for found in supports.below for patch in found]
        table = np.array(patches, dtype=np.float64).reshape(-1, 6)
        on_boxes = table[:, :2].astype(np.int64)
        on_ground = np.column_stack((np.full(len(on_floor), FLOOR), on_floor))
        pairs, rectangles = np.vstack((on_ground, on_boxes)), np.vstack((base, table[:, 2:]))
        order = np.argsort(pairs[:, 1], kind="stable")
        self.pairs, self.rectangles = pairs[order], rectangles[order]

    @classmethod
    def of(cls, layout: Arrangement) -> Rectangles:
        """Those of a layout whose supports nobody has yet."""
        return cls(layout, layout.supports)

    def among(
        self, items: NDArray[np.int64], count: int
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """The contacts of some items with each other and the floor, and the pairs of these.

        Args:
            items: by whose places in this list the pairs are named.
            count: of all items.
        """
        place = np.full(count + 1, FLOOR - 1)  # the last for the floor
        place[items], place[FLOOR] = np.arange(len(items)), FLOOR
        placed = place[self.pairs]
        within = np.flatnonzero((placed >= FLOOR).all(axis=1))
        return within, placed[within]


class Statics:
    """The equations of balance of a load at rest, one unknown a corner of a contact patch.

    Args:
        layout: the load; its boxes so far where it still grows.
        among: the boxes of whole groups that are joined by standing on each other, J of them, in
            whose order all arrays are; None for all boxes.
        contacts: of the layout, where somebody has them already.
        check_time: called now and then while forces are sought; what it raises ends that.

    Attributes:
        weights: of the boxes [kg], shape (J,).
        contacts: the places of their contacts among those of the layout, shape (k,).
        pairs: the lower and the upper box of every contact, those with the floor (:data:`FLOOR`)
            among them, shape (k, 2).
        rectangles: ``(x0, z0, x1, z1)`` of every contact [cm], shape (k, 4).
        matrix: weights and moments that unit forces exert on every box, moments in sides of it,
            sparse, shape (3 J, 4 k).
        right: what they have to come to [kg], shape (3 J,).
    """

    def __init__(
        self,
        layout: Arrangement,
        among: Sequence[int] | NDArray[np.int64] | None = None,
        contacts: Rectangles | None = None,
        check_time: Callable[[], None] = lambda: None,
    ) -> None:
        items = np.arange(len(layout)) if among is None else np.asarray(among, dtype=np.int64)
        lower, upper = layout.lower[items], layout.upper[items]
        self.weights = layout.weights[items]
        contacts = contacts or Rectangles.of(layout)
        self.contacts, self.pairs = contacts.among(items, len(layout))
        self.rectangles = contacts.rectangles[self.contacts]
        self._offsets = layout.mass_offsets[items]
        self._sides = np.ones((len(items), 3))
        self._sides[:, 1:] = (upper - lower)[:, ::2]
        self._check_time = check_time
        patch, box, values = corner_entries(
            range(len(items)), self.pairs, self.rectangles, 0.5 * (lower + upper) + self._offsets,
            EDGE,
        )  # fmt: skip
        rows, columns = np.broadcast_arrays(
            3 * box[:, None, None] + np.arange(3)[:, None], 4 * patch[:, None, None] + np.arange(4)
        )
        self.matrix = csc_array(
            ((values / self._sides[box][:, :, None]).ravel(), (rows.ravel(), columns.ravel())),
            shape=(3 * len(items), 4 * len(self.pairs)),
        )
        self.right = np.outer(self.weights, (1.0, 0.0, 0.0)).ravel()

    def pressed(self, item: int) -> FloatArray:
        """The right side that a weight of 1 kg in the middle of a box's top adds."""
        found = np.zeros((len(self.weights), 3))
        along_x, _, along_z = -self._offsets[item]
        # Moments of the contact forces about the centre of mass balance that of the weight.
        found[item] = np.array((1.0, along_x, along_z)) / self._sides[item]
        return found.ravel()

    def tops(self) -> csc_array:
        """The matrix from corner forces to the loads on tops, shape (J, 4 k)."""
        on_boxes = np.flatnonzero(self.pairs[:, 0] != FLOOR)
        rows = np.repeat(self.pairs[on_boxes, 0], 4)
        columns = (4 * on_boxes[:, None] + np.arange(4)).ravel()
        shape = (len(self.weights), 4 * len(self.pairs))
        return csc_array((np.ones(len(rows)), (rows, columns)), shape=shape)

    def carried(self, right: FloatArray | None = None) -> FloatArray:
        """The weight that every box carries, its own too, were loads shared by area [kg], (J,).

        Args:
            right: in place of :attr:`right`.
        """
        own = (self.right if right is None else right)[::3]
        below, above = self.pairs.T
        areas = self._areas()
        all_below = np.bincount(above, areas, len(own))
        boxes = below != FLOOR
        shares = csc_array(
            ((areas / all_below[above])[boxes], (below[boxes], above[boxes])), (len(own),) * 2
        )
        carried, passed = own.copy(), own
        while passed.any():
            passed = shares @ passed
            carried += passed
        return carried

    def least_energy(
        self, right: FloatArray | None = None, start: NDArray[np.bool_] | None = None
    ) -> FloatArray | None:
        """The corner forces of least energy [kg], shape (4 k,); None where none balance.

        Args:
            right: in place of :attr:`right`.
            start: which corners probably press, shape (4 k,).
        """
        right = self.right if right is None else right
        if not len(self.pairs):
            return None
        scale = np.repeat(self.carried(right), 3)
        corners = Corners(self.matrix, self.soft(), scale, self._check_time)
        found = corners.pressing(right, start)
        for forces in (corners.refined(found > 0.0, right), found):
            if (np.abs(self.matrix @ forces - right) <= _BALANCED * scale).all():
                return forces
        return None

    def nearest(self) -> FloatArray:
        """The corner forces that come nearest to balance [kg], shape (4 k,).

        They carry weights before they balance moments, and have the least energy of such.
        """
        if not len(self.pairs):
            return np.zeros(0)
        unit, soft = float(self.weights.mean()), self.soft()
        counts = np.outer(unit / self.weights, (1.0, _MOMENTS, _MOMENTS)).ravel()
        matrix = csc_array(diags_array(counts) @ self.matrix)
        target = counts * self.right / unit
        if len(target) > _FEW:
            return unit * self._nearest_of_many(matrix, target, _ENERGY**2 * soft)
        stacked = np.vstack((matrix.toarray(), np.diag(_ENERGY * np.sqrt(soft))))
        target = np.concatenate((target, np.zeros(len(soft))))
        # SciPy's nnls (1.17.1) ends at forces that are far from the least where columns are alike.
        columns = np.ascontiguousarray(stacked.T)
        found, _, ended = least_squares(columns, target)
        if not ended:
            found = lsq_linear(stacked, target, (0.0, np.inf)).x
        return unit * np.asarray(found)

    def _nearest_of_many(
        self, matrix: csc_array, target: FloatArray, energy: FloatArray
    ) -> FloatArray:
        """The x >= 0 with the least squares of target - (matrix x), and x . energy x, nearly."""
        m, n = matrix.shape
        solution = solve_cones(
            csc_array(diags_array(np.concatenate((energy, np.ones(m))))),
            np.zeros(n + m),
            csc_array(block_array([[matrix, eye_array(m)], [-eye_array(n), None]])),
            np.concatenate((target, np.zeros(n))),
            [clarabel.ZeroConeT(m), clarabel.NonnegativeConeT(n)],
            self._check_time,
        )
        if is_solved(solution):
            return np.maximum(np.asarray(solution.x)[:n], 0.0)
        # By Newton's method, which has to tell forces of little energy from rounding.
        return Corners(matrix, energy, np.ones(m), self._check_time, firm=1.0).pressing(target)

    def soft(self) -> FloatArray:
        """How far every corner yields to a force, relative to their mean, shape (4 k,)."""
        areas = self._areas()
        return np.repeat(areas.mean() / areas, 4)

    def _areas(self) -> FloatArray:
        found = self.rectangles[:, 2:] - self.rectangles[:, :2]
        return np.asarray(found[:, 0] * found[:, 1])


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
    below, above = np.repeat(statics.pairs, 4, axis=0).T
    x0, z0, x1, z1 = (statics.rectangles + np.array((-EDGE, -EDGE, EDGE, EDGE))).T
    x, z = np.stack((x0, x0, x1, x1), axis=1), np.stack((z0, z1, z0, z1), axis=1)
    positions = np.column_stack((x.ravel(), layout.lower[above, 1], z.ravel()))
    return ContactForces(below, above, positions, found)
