"""DART through dartpy: free joints, exact box-box contact by Bullet's detector, Dantzig's LCP."""

from __future__ import annotations

import math
from typing import NamedTuple

import dartpy as dart
import numpy as np
from numpy.typing import ArrayLike

from steadyload.engines.attitudes import (
    axes_of_quaternion,
    centres_from_mass_centres,
    rotation_vector,
)
from steadyload.engines.box import drawn_in, shrink_of
from steadyload.engines.dart_options import DartOptions
from steadyload.engines.world import (
    Box,
    Capabilities,
    EngineError,
    FixedStepWorld,
    Poses,
    SettingSupport,
    Support,
    Velocities,
    WorldSettings,
    declare,
    planned_poses,
)

_SHRINK = 1e-5
"""Sideways shrink of each side face [m]. Without it a pile of touching boxes is one LCP, which
Dantzig's method pays for with the cube of its size (25 times slower, same verdicts)."""

_MOST_CONTACTS = 1000
"""DART's default limit; dartpy hands out the option as a copy, so it cannot be raised."""

_SWEEPS, _RELAXATION = 3000, 1.3
"""Of the solver without a matrix. With DART's own values, 30 and 0.9, it does not converge on
piles, and Dantzig's method follows."""

_ABSOLUTE = 1e-3
"""Its absolute tolerance, in shares of the relative one."""

_FLOOR_SIZE = (4096.0, 4096.0, 20.0)
"""[m]: the largest pallet, a kilometre wide, lies on it wherever the origin is."""


class _Body(NamedTuple):
    """A box of a world; ``start`` is its coordinates as planned, None for a fixed box.

    ``motion``: its velocities at the start, linear and angular; None where it starts at rest.
    """

    skeleton: dart.dynamics.Skeleton
    node: dart.dynamics.BodyNode
    start: np.ndarray | None
    offset: tuple[float, float, float]
    motion: tuple[tuple[float, float, float], tuple[float, float, float]] | None = None

    def place(self) -> None:
        """Put it where it starts, with its velocities."""
        self.skeleton.setPositions(self.start)
        self.skeleton.resetVelocities()
        if self.motion is not None:
            self.move(*self.motion)

    def move(self, linear: ArrayLike, angular: ArrayLike) -> None:
        """Give it velocities in world axes."""
        # A free joint's own coordinates are in body axes; these two take world axes. The body
        # frame stands at the centre of mass, so turning does not change the linear part.
        joint = self.skeleton.getJoint(0)
        joint.setAngularVelocity(angular)
        joint.setLinearVelocity(linear)


class DartWorld(FixedStepWorld):
    """A DART world. Options: :class:`steadyload.engines.dart_options.DartOptions`.

    Raises:
        EngineError: more contacts than DART keeps (some 250 touching pairs).
    """

    capabilities = Capabilities(
        title="DART (dartpy)",
        dimensions=3,
        subsets=True,
        settings=declare(
            friction=SettingSupport(Support.HONOURED, "pairs take the minimum"),
            restitution=SettingSupport(
                Support.HONOURED, "pairs multiply, so each body gets the square root"
            ),
            linear_damping=SettingSupport(
                Support.EMULATED, "joint damping -m ln(1 - d), in body axes"
            ),
            angular_damping=SettingSupport(
                Support.EMULATED, "joint damping -I ln(1 - d), in body axes"
            ),
            margin=SettingSupport(Support.IGNORED, "DART has none"),
            broad_phase=SettingSupport(Support.IGNORED, "belongs to the collision detector"),
            solver_iterations=SettingSupport(Support.IGNORED, "Dantzig's method is direct"),
        ),
        changing_gravity=SettingSupport(Support.HONOURED),
        in_flight=SettingSupport(Support.HONOURED),
        notes="Side faces are drawn in by 0.01 mm, so that touching neighbours do not form one "
        "linear complementarity problem. DART keeps 1000 contacts (some 250 touching pairs): a "
        "layout that needs more ends with status `error`, never with contacts dropped in silence. "
        "Contacts of large piles can be solved by iteration, with no matrix (`matrix_free_rows`): "
        "loose tolerances are quick, and let piles creep. Impulses against penetration are solved "
        "a second time, which then takes most of the time; `split_impulse=0` does without.",
    )

    def __init__(self, settings: WorldSettings) -> None:
        super().__init__(settings)
        options = self._own_options(DartOptions)
        world = dart.simulation.World()
        world.setCollisionDetector(dart.simulation.CollisionDetectorType.BULLET)
        solver = world.getConstraintSolver()
        solver.setSplitImpulseEnabled(bool(options.split_impulse))
        if options.matrix_free_rows:
            matrix_free = solver.getMatrixFreeContactSolverOptions()
            matrix_free.mEnabled, matrix_free.mMinRows = True, options.matrix_free_rows
            matrix_free.mMaxIterations, matrix_free.mSor = _SWEEPS, _RELAXATION
            matrix_free.mRelativeDeltaTolerance = options.matrix_free_tolerance
            matrix_free.mDeltaTolerance = _ABSOLUTE * options.matrix_free_tolerance
            solver.setMatrixFreeContactSolverOptions(matrix_free)
        sleep = dart.simulation.DeactivationOptions()
        sleep.mEnabled = False
        world.setDeactivationOptions(sleep)
        self._world = world
        self._set_gravity()
        self._bodies: list[_Body] = []
        self._all_bodies: list[_Body] = []
        self._floor = floor = dart.dynamics.Skeleton("floor")
        _, node = floor.createWeldJointAndBodyNodePair()
        shape = self._shape(node, _FLOOR_SIZE)
        shape.setRelativeTranslation([0.0, 0.0, -_FLOOR_SIZE[2] / 2.0])
        floor.setMobile(False)
        world.addSkeleton(floor)

    def _shape(self, node, size):
        shape = node.createShapeNode(dart.dynamics.BoxShape(np.array(size)))
        shape.createCollisionAspect()
        surface = shape.createDynamicsAspect()
        surface.setFrictionCoeff(self.settings.friction)
        surface.setRestitutionCoeff(math.sqrt(self.settings.restitution))
        return shape

    def _box_shape(self, node, box: Box):
        return self._shape(node, drawn_in(box.size, shrink_of(box.size, _SHRINK)))

    def _add(self, box: Box) -> None:
        skeleton = dart.dynamics.Skeleton(f"box{len(self._all_bodies)}")
        if box.fixed:
            _, node = skeleton.createWeldJointAndBodyNodePair()
            shape = self._box_shape(node, box)
            shape.setRelativeTranslation(list(box.centre))
            if box.launched:
                shape.setRelativeRotation(axes_of_quaternion(box.unit_attitude))
            skeleton.setMobile(False)
            self._enter(_Body(skeleton, node, None, (0.0, 0.0, 0.0)))
            return
        joint, node = skeleton.createFreeJointAndBodyNodePair()
        # The body frame stands at the centre of mass: then joint damping acts there too.
        self._box_shape(node, box).setRelativeTranslation([-r for r in box.mass_offset])
        node.setInertia(dart.dynamics.Inertia(box.mass, np.zeros(3), np.diag(box.inertia)))
        linear, angular = self.settings.decay_rates()
        if angular or linear:
            for axis in range(3):
                joint.setDampingCoefficient(axis, angular * box.inertia[axis])
                joint.setDampingCoefficient(3 + axis, linear * box.mass)
        start = np.zeros(6)
        if box.launched:
            start[:3] = rotation_vector(box.unit_attitude)
        start[3:] = box.mass_centre
        motion = (box.velocity, box.angular_velocity) if box.in_motion else None
        body = _Body(skeleton, node, start, box.mass_offset, motion)
        body.place()
        self._enter(body)

    def _enter(self, body: _Body) -> None:
        self._world.addSkeleton(body.skeleton)
        self._bodies.append(body)
        self._all_bodies.append(body)

    def _set_gravity(self) -> None:
        self._world.setGravity(list(self.gravity))

    def _take_part(self, chosen: list[int]) -> None:
        self._bodies = [self._all_bodies[i] for i in chosen]

    @property
    def _free(self) -> list[int]:
        return [i for i, body in enumerate(self._bodies) if body.start is not None]

    def _advance(self, substeps: int, length: float) -> None:
        if self._world.getTimeStep() != length:
            self._world.setTimeStep(length)
        step, result = self._world.step, self._world.getLastCollisionResult
        for _ in range(substeps):
            step()
            if result().getNumContacts() >= _MOST_CONTACTS:
                raise EngineError(
                    f"DART keeps {_MOST_CONTACTS} contacts and drops the rest; this layout has more"
                )

    def _poses(self) -> Poses:
        # A free joint's coordinates: rotation vector, then translation, of the centre of mass.
        free = self._free
        moving = [self._bodies[i] for i in free]
        states = np.array([body.skeleton.getPositions() for body in moving]).reshape(-1, 6)
        angles = np.sqrt((states[:, :3] * states[:, :3]).sum(axis=1))
        quaternions = np.empty((len(states), 4))
        quaternions[:, 0] = np.cos(0.5 * angles)
        # sin(a / 2) / a, by numpy's sin(pi x) / (pi x), which knows its limit at 0.
        quaternions[:, 1:] = (0.5 * np.sinc(angles * (0.5 / math.pi)))[:, None] * states[:, :3]
        offsets = np.array([body.offset for body in moving]).reshape(-1, 3)
        moved = centres_from_mass_centres(states[:, 3:], quaternions, offsets)
        if len(free) == len(self.boxes):
            return Poses(moved, quaternions)
        poses = planned_poses(self.boxes)
        poses.centres[free], poses.quaternions[free] = moved, quaternions
        return poses

    def _velocities(self) -> Velocities:
        linear, angular = np.zeros((2, len(self.boxes), 3))
        for index, body in enumerate(self._bodies):
            if body.start is not None:
                linear[index] = body.node.getCOMLinearVelocity()
                angular[index] = body.node.getAngularVelocity()
        return Velocities(linear, angular)

    def _set_velocities(self, velocities: Velocities) -> None:
        for body, linear, angular in zip(self._bodies, *velocities, strict=True):
            if body.start is not None:
                body.move(linear, angular)

    def _reset(self) -> None:
        for body in self._bodies:
            if body.start is not None:
                body.place()
                body.skeleton.resetAccelerations()
                body.skeleton.clearConstraintImpulses()
        # The collision detector keeps contact points from step to step, and an order of pairs,
        # until it is empty.
        world = self._world
        for skeleton in [world.getSkeleton(index) for index in range(world.getNumSkeletons())]:
            world.removeSkeleton(skeleton)
        world.addSkeleton(self._floor)
        for body in self._bodies:
            world.addSkeleton(body.skeleton)

    def _close(self) -> None:
        self._bodies.clear()
        self._all_bodies.clear()
        del self._floor, self._world
