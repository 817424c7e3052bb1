"""Scenes of Siconos, for the child process of :mod:`steadyload.engines.with_siconos`; it runs under
the Python that has Siconos, and imports nothing of ours but its neighbour, by its name alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import siconos.kernel as kernel

if TYPE_CHECKING:
    from steadyload.engines.box_contacts import FLOOR, Boxes, Contacts, contacts_of
    from steadyload.engines.serving import Body
else:
    from box_contacts import FLOOR, Boxes, Contacts, contacts_of

THETA = 0.5
"""Of Moreau and Jean's scheme: the midpoint rule, exact for a parabola."""

FORESEEN = 1.5
"""A contact is closed once its gap would be in so many steps. A step that begins with a closed
contact still moves by half of the velocity before it, so that at this value nothing penetrates."""

CLOSED = 1e-6
"""A contact at rest is closed at this gap [m]."""

FINE = 1e-5
"""A substep in which a contact closes is divided until a part closes it by less than this [m]."""

MOST_PARTS = 64
"""Of a substep."""

TOLERANCE = 1e-8
"""Of the contact solver: error of all contacts over the size of their free velocities."""

ITERATIONS = 1000
"""Sweeps of the contact solver over all contacts, at most."""

_REACH = 1e-3
"""Gap up to which contacts are prepared, besides what bodies can close in two steps [m]."""

_Key = tuple[int, int, int]
"""Of a contact: the bodies of the pair, and the feature."""


class Scene:
    """Boxes on the floor under Moreau and Jean's time stepping."""

    def __init__(
        self,
        gravity: tuple[float, float, float],
        bodies: Sequence[Body],
        friction: float,
        restitution: float,
        iterations: int | None,
    ) -> None:
        self._gravity = np.array(gravity)
        self._bodies = bodies
        self._law = kernel.NewtonImpactFrictionNSL(restitution, 0.0, friction, 3)
        self._iterations = ITERATIONS if iterations is None else iterations
        self._fixed = np.array([body.fixed for body in bodies], dtype=bool)
        self._free = np.flatnonzero(~self._fixed)
        self._halves = 0.5 * np.array([body.size for body in bodies]).reshape(-1, 3)
        self._offsets = np.array([body.shape_centre for body in bodies]).reshape(-1, 3)
        self._radii = np.linalg.norm(self._offsets, axis=1) + np.linalg.norm(self._halves, axis=1)
        self._poses = np.array([(*b.mass_centre, *b.attitude) for b in bodies]).reshape(-1, 7)
        self._twists = np.zeros((len(bodies), 6))
        self._first, self._second = self._pairs()
        self._length = 0.0
        self._simulation: Any = None

    def __del__(self) -> None:
        """Take apart what refers to itself in Siconos, and would keep its memory for good."""
        self._end()

    def _end(self) -> None:
        if self._simulation is None:
            return
        for moving in self._moving.values():
            self._system.removeDynamicalSystem(moving)
        self._simulation.clear()
        self._system.clear()
        self._simulation = None

    def _pairs(self) -> tuple[np.ndarray, np.ndarray]:
        """All pairs but those of fixed bodies: a free body, and another one or the floor."""
        first, second = np.triu_indices(len(self._bodies), 1)
        moves = ~(self._fixed[first] & self._fixed[second])
        first, second = first[moves], second[moves]
        swapped = self._fixed[first]
        first, second = np.where(swapped, second, first), np.where(swapped, first, second)
        floor = np.full(len(self._free), FLOOR)
        return np.concatenate((first, self._free)), np.concatenate((second, floor))

    def advance(self, states: np.ndarray | None, substeps: int, length: float) -> np.ndarray:
        """Simulate from ``states``, or from where it is; returns the new states."""
        if not len(self._free):
            return np.zeros((0, 13))
        if states is not None:
            self._poses[self._free] = np.hstack((states[:, 4:7], states[:, :4]))
            turns = _axes(self._poses[self._free, 3:])
            spins = np.einsum("kji,kj->ki", turns, states[:, 7:10])
            self._twists[self._free] = np.hstack((states[:, 10:], spins))
            self._length = 0.0
        for _ in range(substeps):
            self._substep(length)
        poses, twists = self._poses[self._free], self._twists[self._free]
        spins = np.einsum("kij,kj->ki", _axes(poses[:, 3:]), twists[:, 3:])
        return np.hstack((poses[:, 3:], poses[:, :3], spins, twists[:, :3]))

    def _substep(self, length: float) -> None:
        found = self._contacts(length)
        closing = -found.rates * length
        soon = (found.gaps > CLOSED) & (found.gaps < FORESEEN * closing + CLOSED)
        widest = closing[soon].max(initial=0.0)
        parts = int(np.clip(np.ceil(widest / FINE), 1, MOST_PARTS))
        if length / parts != self._length:
            self._begin(length / parts)
        for part in range(parts):
            self._step(self._contacts(self._length) if part or parts > 1 else found)

    def _begin(self, length: float) -> None:
        """A simulation from the present state, with steps of this length."""
        self._end()
        self._length = length
        self._system = kernel.NonSmoothDynamicalSystem(0.0, np.inf)
        self._linked: dict[_Key, tuple[Any, Any]] = {}
        self._moving = {}
        for index in self._free.tolist():
            body = self._bodies[index]
            pose, twist = self._poses[index].tolist(), self._twists[index].tolist()
            moving = kernel.NewtonEulerDS(pose, twist, body.mass, np.diag(body.inertia))
            moving.setFExtPtr((body.mass * self._gravity).tolist())
            self._system.insertDynamicalSystem(moving)
            self._moving[index] = moving
        integrator = kernel.MoreauJeanOSI(THETA, FORESEEN)
        integrator.setConstraintActivationThreshold(CLOSED)
        self._problem = kernel.FrictionContact(3)
        options = self._problem.numericsSolverOptions()
        options.iparam[0], options.dparam[0] = self._iterations, TOLERANCE
        self._simulation = kernel.TimeStepping(self._system, kernel.TimeDiscretisation(0.0, length))
        self._simulation.insertIntegrator(integrator)
        self._simulation.insertNonSmoothProblem(self._problem)

    def _step(self, found: _Found) -> None:
        simulation, system = self._simulation, self._system
        self._link(found)
        simulation.initialize()
        simulation.clearNSDSChangeLog()
        # Which contacts are closed is decided by the points that have just been found. By itself
        # Siconos decides it by those of the step before, and takes the way along them for a gap.
        time = simulation.startingTime()
        system.computeInteractionJacobians(time)
        system.updateOutput(time, 0)
        system.updateOutput(time, 1)
        simulation.updateIndexSets()
        simulation.computeOneStep()
        simulation.nextStep()
        for index, moving in self._moving.items():
            self._poses[index], self._twists[index] = moving.q(), moving.twist()

    def _link(self, found: _Found) -> None:
        """Give Siconos the contacts of the present state; those that it has are moved."""
        for key in self._linked.keys() - set(found.keys):
            self._system.removeInteraction(self._linked.pop(key)[0])
        for key, jacobian, start in zip(found.keys, found.jacobians, found.starts, strict=True):
            pair = [self._moving[index] for index in key[:2] if index in self._moving]
            relation = self._linked[key][1] if key in self._linked else kernel.NewtonEulerR()
            relation.setJachq(jacobian[:, : 7 * len(pair)])
            relation.setE(start)
            if key not in self._linked:
                interaction = kernel.Interaction(self._law, relation)
                self._system.link(interaction, *pair)
                self._linked[key] = interaction, relation

    def _contacts(self, length: float) -> _Found:
        """Contacts of the present state, and those that a step of this length may close."""
        axes = _axes(self._poses[:, 3:])
        centres = self._poses[:, :3] + np.einsum("kij,kj->ki", axes, self._offsets)
        speeds = np.linalg.norm(self._twists[:, :3], axis=1)
        speeds += np.linalg.norm(self._twists[:, 3:], axis=1) * self._radii
        speeds += np.linalg.norm(self._gravity) * length
        reach = _REACH + 2.0 * length * np.append(speeds, 0.0)
        reaches = reach[self._first] + reach[self._second]
        boxes = Boxes(centres, axes, self._halves)
        return self._related(contacts_of(boxes, self._first, self._second, reaches), axes, length)

    def _related(self, found: Contacts, axes: np.ndarray, length: float) -> _Found:
        """Relations of contacts to the bodies, at their poses at the end of a step.

        They are written out here because the frame of a contact that Siconos makes is not
        orthogonal where its normal is nearest to z and not z itself (orthoBaseFromVector).
        """
        ahead = _moved(self._poses, self._twists, length)
        turned, turning = _axes(ahead[:, 3:]), _rates_of_attitude(ahead[:, 3:])
        now = _rates(self._poses, self._twists)
        second = np.where(found.second == FLOOR, found.first, found.second)
        still = (found.second == FLOOR) | self._fixed[second]
        middle = 0.5 * (found.on_first + found.on_second)
        frame = _frames(found.normal)
        gaps, rates = found.gaps, np.zeros(len(middle))
        jacobians, starts = np.zeros((len(middle), 3, 14)), np.zeros((len(middle), 3))
        starts[:, 0] = gaps
        for part, which, sign in ((0, found.first, 1.0), (7, second, np.where(still, 0.0, -1.0))):
            own = jacobians[:, :, part : part + 7]
            arm = np.einsum("kji,kj->ki", axes[which], middle - self._poses[which, :3])
            lever = np.einsum("kij,kj->ki", turned[which], arm)
            own[:, :, :3] = frame * np.reshape(sign, (-1, 1, 1))
            moments = np.einsum(
                "kij,kai->kaj", turned[which], np.cross(lever[:, None], own[:, :, :3])
            )
            own[:, :, 3:] = 2.0 * np.einsum("kaj,kij->kai", moments, turning[which])
            starts[:, 0] -= (own[:, 0] * self._poses[which]).sum(axis=1)
            rates += (own[:, 0] * now[which]).sum(axis=1)
        keys = zip(found.first.tolist(), found.second.tolist(), found.feature.tolist(), strict=True)
        return _Found(list(keys), jacobians, starts, gaps, rates)


class _Found(NamedTuple):
    """Contacts as Siconos takes them.

    ``jacobians``: of the velocities along the normal and two tangents, by the coordinates of both
    bodies (7 and 7), shape (n, 3, 14). ``starts``: added to that product to give the gap.
    ``gaps``: [m]. ``rates``: at which they open [m/s].
    """

    keys: list[_Key]
    jacobians: np.ndarray
    starts: np.ndarray
    gaps: np.ndarray
    rates: np.ndarray


def _frames(normals: np.ndarray) -> np.ndarray:
    """A normal and two tangents, orthonormal, in rows of (n, 3, 3)."""
    least = np.abs(normals).argmin(axis=1)
    tangents = np.cross(normals, np.eye(3)[least])
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    return np.stack((normals, tangents, np.cross(normals, tangents)), axis=1)


def _rates_of_attitude(attitudes: np.ndarray) -> np.ndarray:
    """Twice the rates of w, x, y, z by the angular velocity in body axes, shape (n, 4, 3)."""
    w, x, y, z = attitudes.T
    return _matrices(((-x, -y, -z), (w, -z, y), (z, w, -x), (-y, x, w)))


def _rates(poses: np.ndarray, twists: np.ndarray) -> np.ndarray:
    """Rates of poses, shape (n, 7)."""
    turning = np.einsum("kij,kj->ki", _rates_of_attitude(poses[:, 3:]), twists[:, 3:])
    return np.hstack((twists[:, :3], 0.5 * turning))


def _moved(poses: np.ndarray, twists: np.ndarray, length: float) -> np.ndarray:
    """Poses after a step at constant velocity, from where Siconos begins to look for the others."""
    turns = length * twists[:, 3:]
    angles = np.linalg.norm(turns, axis=1)[:, None]
    shares = 0.5 * np.sinc(angles / (2.0 * np.pi))
    by = _rates_of_attitude(poses[:, 3:])
    attitudes = np.cos(0.5 * angles) * poses[:, 3:] + np.einsum("kij,kj->ki", by, shares * turns)
    return np.hstack((poses[:, :3] + length * twists[:, :3], attitudes))


def _axes(attitudes: np.ndarray) -> np.ndarray:
    """Rotation matrices of unit quaternions (w, x, y, z)."""
    w, x, y, z = attitudes.T
    return _matrices(
        (
            (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
        )
    )


def _matrices(rows: Sequence[Sequence[np.ndarray]]) -> np.ndarray:
    """Matrices, one a body, of their elements, each for all bodies."""
    made = np.empty((len(rows[0][0]), len(rows), len(rows[0])))
    for row, elements in enumerate(rows):
        for column, values in enumerate(elements):
            made[:, row, column] = values
    return made
