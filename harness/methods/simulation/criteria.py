"""Criteria for a moved item (Eq. 6 and 7 of the paper, and the authors' own evaluation)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from steadyload.engines.attitudes import rotate
from steadyload.engines.world import Box, FloatArray, Poses
from steadyload.methods.contract.method import Finding, Status
from steadyload.methods.simulation.scene import CM
from steadyload.statics.movement import Movement

Indices = NDArray[np.intp]
"""Which of a layout's items are meant."""


class Criterion(StrEnum):
    """The quantity that is measured, and the time at which it is.

    ``paper``: Eq. 6 and 7, at any sample: the geometric centre moved by more than ``eps_t``
    (Euclidean), or an angle about an axis exceeds ``eps_r``. ``adams``: the authors' evaluation of
    the reference simulation, at the last sample: the left-bottom-back corner moved by more than
    ``eps_t`` along one axis, or an angle exceeds ``eps_r``.
    """

    PAPER = "paper"
    ADAMS = "adams"


class Examiner:
    """Compares poses with the planned ones.

    Args:
        items: all boxes of a layout, at their planned poses; more can be added.
        criterion: what is measured.
        eps_t: displacement that counts as unstable [cm].
        eps_r: angle that counts as unstable [degrees].
    """

    def __init__(
        self, items: Sequence[Box], criterion: Criterion, eps_t: float, eps_r: float
    ) -> None:
        self._criterion, self._eps_t, self._eps_r = criterion, eps_t, eps_r
        self._planned = np.array([b.centre for b in items]).reshape(-1, 3)
        self._corners = -0.5 * np.array([b.size for b in items]).reshape(-1, 3)
        self._half_diagonals = np.sqrt((self._corners**2).sum(axis=1))

    def add(self, items: Sequence[Box]) -> None:
        """Take in the boxes that come next."""
        new = Examiner(items, self._criterion, self._eps_t, self._eps_r)
        self._planned = np.concatenate((self._planned, new._planned))
        self._corners = np.concatenate((self._corners, new._corners))
        self._half_diagonals = np.concatenate((self._half_diagonals, new._half_diagonals))

    def cut(self, count: int) -> None:
        """Forget all boxes but the first ``count``."""
        self._planned, self._corners = self._planned[:count], self._corners[:count]
        self._half_diagonals = self._half_diagonals[:count]

    def examine(
        self, step: int, poses: Poses, items: Indices, excess: float = 1.0
    ) -> Finding | None:
        """The finding when something moved too far or the state is not finite, else None.

        Args:
            step: the item that was placed last.
            poses: poses of some items.
            items: which items these are, in the order of the poses.
            excess: multiple of the thresholds that must be exceeded.
        """
        if self._clearly_stable(poses, items, excess):
            return None
        if not (np.isfinite(poses.centres).all() and np.isfinite(poses.quaternions).all()):
            return Finding(
                status=Status.DIVERGED,
                reason=f"the engine's state became non-finite when item {step} was placed",
            )
        most = self.most_moved(poses, items)
        if not most.beyond > excess:
            return None
        return Finding(
            failing_step=step,
            moved_item=most.item,
            displacement=most.displacement,
            rotation=most.rotation,
            reason=f"item {most.item} moved {most.displacement:.1f} cm "
            f"and turned by {most.rotation:.1f} deg",
        )

    def most_moved(self, poses: Poses, items: Indices) -> Movement:
        """The item that is furthest beyond a threshold, or closest to one.

        Args:
            poses: finite poses of some items.
            items: which items these are, in the order of the poses.
        """
        moved = self._displacements(poses, items) / CM
        turned = np.degrees(euler_angles(poses.quaternions)).max(axis=1)
        beyond = np.maximum(moved / max(self._eps_t, 1e-12), turned / max(self._eps_r, 1e-12))
        worst = int(beyond.argmax())
        item = int(np.arange(len(self._planned))[items][worst])
        return Movement(item, float(moved[worst]), float(turned[worst]), float(beyond[worst]))

    def movements(self, poses: Poses, items: Indices) -> tuple[FloatArray, FloatArray] | None:
        """How far each corner is along its worst axis [cm], and the largest angle about an axis
        [degrees], shape (n,) each; None where a pose is not finite.

        Args:
            poses: poses of some items.
            items: which items these are, in the order of the poses.
        """
        if not (np.isfinite(poses.centres).all() and np.isfinite(poses.quaternions).all()):
            return None
        angles = np.degrees(euler_angles(poses.quaternions)).max(axis=1)
        return self.corner_shifts(poses, items) / CM, angles

    def moved_along(self, poses: Poses, items: Indices) -> FloatArray:
        """Displacement of each item along the axes of the world, of the point that the criterion
        looks at, and its rotation about them, in units of a threshold, shape (n, 6).

        Args:
            poses: poses of some items.
            items: which items these are, in the order of the poses.
        """
        shift = poses.centres - self._planned[items]
        if self._criterion is Criterion.ADAMS:
            corners = self._corners[items]
            shift += rotate(poses.quaternions, corners) - corners
        turns = 2.0 * np.copysign(1.0, poses.quaternions[:, :1]) * poses.quaternions[:, 1:]
        eps_t, eps_r = max(self._eps_t * CM, 1e-12), max(math.radians(self._eps_r), 1e-12)
        return np.concatenate((shift / eps_t, turns / eps_r), axis=1)

    def between(self, before: Poses, poses: Poses, items: Indices) -> FloatArray:
        """How far items have moved since they had other poses, in units of a threshold, shape (n,).

        Args:
            before: finite poses of some items.
            poses: those of the same items now.
            items: which items these are, in the order of the poses.
        """
        corners = self._corners[items]
        shift = poses.centres - before.centres
        shift += rotate(poses.quaternions, corners) - rotate(before.quaternions, corners)
        cosines = np.abs((poses.quaternions * before.quaternions).sum(axis=1))
        turned = np.degrees(2.0 * np.arccos(np.minimum(cosines, 1.0)))
        moved = np.abs(shift).max(axis=1) / CM / max(self._eps_t, 1e-12)
        return np.maximum(moved, turned / max(self._eps_r, 1e-12))

    def _clearly_stable(self, poses: Poses, items: Indices, excess: float) -> bool:
        """A cheap sufficient condition; false for anything that is not finite.

        No angle about an axis exceeds the total angle of a rotation below 90 degrees, and no corner
        moves by more than its centre does plus the turn of half the diagonal.
        """
        shift = poses.centres - self._planned[items]
        far = math.sqrt((shift * shift).sum(axis=1).max())
        cosine = float(np.abs(poses.quaternions[:, 0]).min())
        if not cosine >= math.cos(0.5 * math.radians(min(excess * self._eps_r, 90.0))) + 1e-12:
            return False
        if self._criterion is Criterion.ADAMS:
            sine = math.sqrt(max(0.0, 1.0 - cosine * cosine))
            far += 2.0 * sine * float(self._half_diagonals[items].max())
        return far <= excess * self._eps_t * CM * (1.0 - 1e-12)

    def _displacements(self, poses: Poses, items: Indices) -> FloatArray:
        """Displacement of each item [m], shape (n,), as the criterion measures it."""
        if self._criterion is Criterion.PAPER:
            return self.centre_shifts(poses, items)
        return self.corner_shifts(poses, items)

    def centre_shifts(self, poses: Poses, items: Indices) -> FloatArray:
        """Displacement of each geometric centre [m], shape (n,)."""
        shift = poses.centres - self._planned[items]
        return np.sqrt((shift * shift).sum(axis=1))

    def corner_shifts(self, poses: Poses, items: Indices) -> FloatArray:
        """Displacement of each left-bottom-back corner along its worst axis [m], shape (n,)."""
        corners = self._corners[items]
        shift = poses.centres - self._planned[items]
        shift += rotate(poses.quaternions, corners) - corners
        return np.abs(shift).max(axis=1)


def euler_angles(quaternions: FloatArray) -> FloatArray:
    """Absolute roll, pitch and yaw [rad], shape (n, 3): turns about the layout's x, y and z axes.

    Args:
        quaternions: w, x, y, z in *world* axes, shape (n, 4), unit length.

    The decomposition is R = Rz Ry Rx in layout axes; below some 20 degrees the order hardly
    matters.
    """
    w, z, x, y = quaternions.T
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))
    yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return np.abs(np.stack((roll, pitch, yaw), axis=1))
