"""The largest constant acceleration that contact forces can hold a complete load against.

In the frame of the deck an acceleration is a force on every box, its mass times the acceleration,
at its centre of mass. The load is held as long as contact forces inside Coulomb's cones balance
every box. The largest such acceleration in a direction is a second-order cone programme.

Coulomb friction is not associated: where several boxes touch, such forces may exist and the load
move all the same. The limit is then an upper bound; for a single box, and where nothing slides, it
is exact.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import clarabel
import numpy as np
from scipy.sparse import csc_array, diags_array, hstack, vstack

from steadyload.layouts.model.layout import Arrangement, FloatArray
from steadyload.statics.cones import is_solved, solve_cones
from steadyload.statics.friction import Sides
from steadyload.statics.touching import Points, touching_points, wrenches
from steadyload.transport.errors import UnsolvedError

_TURNS = 0.3
"""A box tips where its corners turn about its centre at more than this share of its speed."""


class Mode(StrEnum):
    """How a box leaves its place: it ``slides`` or ``tips``, or the load does not stand and it
    ``falls`` under no acceleration at all.
    """

    SLIDES = "slides"
    TIPS = "tips"
    FALLS = "falls"


@dataclass(frozen=True)
class Held:
    """The acceleration that forces hold a load against, in one direction.

    Attributes:
        limit_g: largest acceleration [g]; 0 for a load that does not stand.
        moved_item: the box that moves furthest in the motion that no force stops.
        mode: how it moves.
        forces: on the second body of every contact point at the limit, in weights of a mean box,
            shape (k, 3); empty for a load that does not stand.
        motion: velocity [any unit] and angular velocity of every box in that motion, shape (J, 6).
    """

    limit_g: float
    moved_item: int
    mode: Mode
    forces: FloatArray
    motion: FloatArray


class BalanceProgramme:
    """The programme of a complete load; it is made once and solved for any number of directions.

    Args:
        layout: in the units of layouts: cm and kg, y up.
        friction: Coulomb coefficient of every contact, 0 or more.
        sides: what side faces do; without friction they only push.

    Attributes:
        points: the contact points of the load.
    """

    def __init__(
        self, layout: Arrangement, friction: float, sides: Sides = Sides.FRICTIONLESS
    ) -> None:
        items = range(len(layout))
        self.points: Points = touching_points(layout, items)
        if sides is Sides.NONE:
            self.points = _of_tops(self.points)
        self._sizes = layout.upper - layout.lower
        self._masses = layout.weights / layout.weights.mean()
        centres = 0.5 * (layout.lower + layout.upper) + layout.mass_offsets
        # Rows are in weights and sides of their own box: else a heavy one hides a light one.
        self._scale = np.repeat(self._masses[:, None], 6, axis=1)
        self._scale[:, 3:] *= self._sizes.mean(axis=1)[:, None]
        rough = (self.points.axes == 1) | (sides is Sides.FRICTION)
        rough &= friction > 0.0
        self._columns = _columns(self.points, rough)
        point, along = self._columns
        force = np.zeros((len(point), 3))
        force[np.arange(len(point)), along] = 1.0
        matrix = wrenches(self.points, self.points.positions, centres, point, force)
        matrix /= self._scale[:, :, None]
        self._balance = csc_array(matrix.reshape(6 * len(layout), -1))
        self._cones, self._blocks = _cones(rough, friction)
        weight = np.zeros((len(layout), 6))
        weight[:, 1] = 1.0
        self._weight = weight.ravel()
        self._falls = self._at_rest()

    def limit(self, direction_deg: float) -> Held:
        """The largest acceleration in a direction, and what moves beyond it.

        Args:
            direction_deg: of the force on the boxes, seen from above: 0 along the width, 90 along
                the depth.

        Raises:
            UnsolvedError: the solver found no answer.
        """
        if self._falls is not None:
            return self._falls
        angle = math.radians(direction_deg)
        push = np.zeros((len(self._masses), 6))
        push[:, 0] = math.cos(angle)
        push[:, 2] = math.sin(angle)
        solution = self._solve(push.ravel()[:, None], np.array([-1.0]))
        if not is_solved(solution):
            raise UnsolvedError(f"the limit at {direction_deg:g} degrees: {solution.status}")
        found = np.asarray(solution.x)
        item, mode, motion = self._moved(solution)
        return Held(max(0.0, float(found[-1])), item, mode, self._forces(found[:-1]), motion)

    def _at_rest(self) -> Held | None:
        """The limit of a load that does not stand, the same in every direction; else None."""
        solution = self._solve(np.zeros((len(self._weight), 0)), np.empty(0))
        if is_solved(solution):
            return None
        if "PrimalInfeasible" not in str(solution.status):
            raise UnsolvedError(f"whether the load stands: {solution.status}")
        item, _, motion = self._moved(solution)
        return Held(0.0, item, Mode.FALLS, np.empty((0, 3)), motion)

    def _solve(self, push: FloatArray, cost: FloatArray) -> clarabel.DefaultSolution:
        forces = self._balance.shape[1]
        rows = hstack((self._balance, csc_array(push)), format="csc")
        inside = hstack((self._blocks, csc_array((self._blocks.shape[0], push.shape[1]))))
        matrix = vstack((rows, -inside), format="csc")
        right = np.concatenate((self._weight, np.zeros(self._blocks.shape[0])))
        cones = [clarabel.ZeroConeT(len(self._weight)), *self._cones]
        objective = np.concatenate((np.zeros(forces), cost))
        nothing = csc_array((len(objective), len(objective)))
        return solve_cones(nothing, objective, matrix, right, cones)

    def _moved(self, solution: clarabel.DefaultSolution) -> tuple[int, Mode, FloatArray]:
        """The dual of the balance: a motion of the boxes that no contact force can stop."""
        motion = np.asarray(solution.z)[: len(self._weight)].reshape(-1, 6) / self._scale
        speeds = np.linalg.norm(motion[:, :3], axis=1)
        turns = 0.5 * np.linalg.norm(self._sizes, axis=1) * np.linalg.norm(motion[:, 3:], axis=1)
        item = int((speeds + turns).argmax())
        tips = turns[item] > _TURNS * speeds[item]
        return item, Mode.TIPS if tips else Mode.SLIDES, motion

    def _forces(self, found: FloatArray) -> FloatArray:
        forces = np.zeros((len(self.points), 3))
        forces[self._columns] = found
        return forces


def _of_tops(points: Points) -> Points:
    level = points.axes == 1
    return Points(*(getattr(points, name)[level] for name in points.__slots__))


def _columns(points: Points, rough: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Point and axis of every unknown: the normal of smooth points, three axes of rough ones."""
    smooth = np.flatnonzero(~rough)
    three = np.repeat(np.flatnonzero(rough), 3)
    along = (points.axes[three] + np.tile((0, 1, 2), int(rough.sum()))) % 3
    return np.concatenate((smooth, three)), np.concatenate((points.axes[smooth], along))


def _cones(rough: np.ndarray, friction: float) -> tuple[list[object], csc_array]:
    """The cones that the unknowns lie in, and what takes the unknowns to them."""
    smooth, count = int((~rough).sum()), int(rough.sum())
    cones: list[object] = [clarabel.NonnegativeConeT(smooth)] if smooth else []
    cones += [clarabel.SecondOrderConeT(3)] * count
    scale = np.concatenate((np.ones(smooth), np.tile((friction, 1.0, 1.0), count)))
    return cones, csc_array(diags_array(scale))
