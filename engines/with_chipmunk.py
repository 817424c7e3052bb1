"""Chipmunk through pymunk: two dimensions, impulses, the vertical x-z plane of the world."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pymunk

from steadyload.engines.world import (
    Box,
    BroadPhase,
    Capabilities,
    EngineError,
    FixedStepWorld,
    FloatArray,
    Poses,
    SettingSupport,
    Support,
    Velocities,
    WorldSettings,
    declare,
)

_FLOOR = [(-1000.0, -10.0), (1000.0, -10.0), (1000.0, 0.0), (-1000.0, 0.0)]
_ITERATIONS = 50

# Lengths here are metres; Chipmunk's default slop of 0.1 is meant for pixels.
_SLOP = 1e-5

# What a turn about y and a motion in the plane may have of others, by rounding.
_IN_PLANE = 1e-9


class _Body(NamedTuple):
    """A box of a world, and how it starts: centre of mass and velocity along x and z, angles."""

    body: pymunk.Body
    shape: pymunk.Poly
    start: tuple[float, float]
    angle: float
    velocity: tuple[float, float]
    turning: float

    def place(self) -> None:
        """Put it where it starts, with its velocities."""
        self.body.position, self.body.angle = self.start, self.angle
        self.body.velocity, self.body.angular_velocity = self.velocity, self.turning


class ChipmunkWorld(FixedStepWorld):
    """A Chipmunk world: only motion in the x-z plane exists.

    Of velocities that are set, the part out of the plane is dropped.

    Raises:
        EngineError: boxes that do not share their centre and size along y, or whose centre of mass
            lies off its middle, or that are turned or move out of the plane. They would need the
            third dimension.
    """

    capabilities = Capabilities(
        title="Chipmunk (pymunk)",
        dimensions=2,
        subsets=True,
        settings=declare(
            friction=SettingSupport(
                Support.HONOURED, "pairs multiply, so each shape gets the square root"
            ),
            restitution=SettingSupport(
                Support.HONOURED, "pairs multiply, so each shape gets the square root"
            ),
            linear_damping=SettingSupport(Support.HONOURED, "v (1 - d)^t, and angular alike"),
            angular_damping=SettingSupport(
                Support.IGNORED, "Chipmunk has one damping for both: linear_damping"
            ),
            margin=SettingSupport(Support.IGNORED, "its radius would inflate the boxes"),
            broad_phase=SettingSupport(
                Support.HONOURED,
                "a dynamic tree of bounding boxes",
                values=(BroadPhase.DBVT,),
            ),
            solver_iterations=SettingSupport(Support.HONOURED, f"default {_ITERATIONS}"),
        ),
        changing_gravity=SettingSupport(Support.HONOURED),
        in_flight=SettingSupport(
            Support.HONOURED, "turned about y, moving along x and z; refused otherwise"
        ),
        notes="Two dimensions: a layout is judged when it is planar, and refused otherwise. At "
        "60 Hz with restitution 0.5 a tower of six cubes falls within 4 s (PS_3, literal).",
    )

    def __init__(self, settings: WorldSettings) -> None:
        super().__init__(settings)
        self._check_gravity(settings.gravity)
        self._bodies: list[_Body] = []
        self._all_bodies: list[_Body] = []
        self._planned: tuple[FloatArray, FloatArray, bool] | None = None
        floor = pymunk.Body(body_type=pymunk.Body.STATIC)
        self._floor = floor, self._surface(pymunk.Poly(floor, _FLOOR))
        self._open_space()

    def _open_space(self) -> None:
        settings = self.settings
        self._space = space = pymunk.Space()
        self._set_gravity()
        space.damping = 1.0 - settings.linear_damping
        space.iterations = settings.solver_iterations or _ITERATIONS
        space.collision_slop = _SLOP
        space.add(*self._floor)
        self._entered = 0

    def _check_gravity(self, gravity: tuple[float, float, float]) -> None:
        if gravity[1]:
            raise EngineError("Chipmunk is 2-D: gravity must have no part along y")

    def _set_gravity(self) -> None:
        self._space.gravity = self.gravity[0], self.gravity[2]

    def _surface(self, shape: pymunk.Poly) -> pymunk.Poly:
        shape.friction = math.sqrt(self.settings.friction)
        shape.elasticity = math.sqrt(self.settings.restitution)
        return shape

    def _add(self, box: Box) -> None:
        self._check_planar(box)
        (x, _, z), (p, _, r) = box.size, box.mass_offset
        # The body stands at the centre of mass, its shape at an offset.
        corners = [
            (a * x - p, b * z - r) for a, b in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))
        ]
        kind = pymunk.Body.STATIC if box.fixed else pymunk.Body.DYNAMIC
        body = pymunk.Body(box.mass, box.inertia[1], kind)
        (w, _, turn, _), (a, _, c) = box.unit_attitude, box.mass_centre
        entry = _Body(
            body,
            self._surface(pymunk.Poly(body, corners)),
            (a, c),
            # Counter-clockwise from x to z is a negative turn about y.
            0.0 - 2.0 * math.atan2(turn, w),
            (box.velocity[0], box.velocity[2]),
            0.0 - box.angular_velocity[1],
        )
        entry.place()
        self._bodies.append(entry)
        self._all_bodies.append(entry)
        self._planned = None

    def _take_part(self, chosen: list[int]) -> None:
        self._bodies = [self._all_bodies[i] for i in chosen]
        self._planned = None

    def _prepare(self) -> None:
        # Not before: boxes are often added only to be left out of the placement that follows.
        for entry in self._bodies[self._entered :]:
            self._space.add(entry.body, entry.shape)
        self._entered = len(self._bodies)

    def _check_planar(self, box: Box) -> None:
        first = self._all_boxes[0] if self._all_boxes else box
        same = math.isclose(box.centre[1], first.centre[1], abs_tol=1e-3)
        same = same and math.isclose(box.size[1], first.size[1], abs_tol=1e-3)
        if not same or abs(box.mass_offset[1]) > 1e-3:
            raise EngineError("Chipmunk is 2-D: boxes must share their extent along y, centred")
        (_, a, _, c), (p, _, r) = box.attitude, box.angular_velocity
        if box.launched and max(map(abs, (a, c, box.velocity[1], p, r))) > _IN_PLANE:
            raise EngineError(
                "Chipmunk is 2-D: boxes must be turned about y, and move in its plane"
            )

    def _advance(self, substeps: int, length: float) -> None:
        self._prepare()
        step = self._space.step
        for _ in range(substeps):
            step(length)

    def _poses(self) -> Poses:
        planned, offsets, shifted = self._plan()
        states = [(*entry.body.position, entry.body.angle) for entry in self._bodies]
        x, z, angles = np.array(states).reshape(-1, 3).T
        half = 0.5 * angles
        # Counter-clockwise from x to z is a negative turn about y.
        w, y = np.cos(half), -np.sin(half)
        if shifted:
            # The rotation of `attitudes.rotate`, of which only this is left in the plane.
            p, r = offsets
            across, along = 2.0 * (y * r), -2.0 * (y * p)
            x, z = x - (p + w * across + y * along), z - (r + w * along - y * across)
        poses = Poses(planned.copy(), np.zeros((len(half), 4)))
        poses.centres[:, 0], poses.centres[:, 2] = x, z
        poses.quaternions[:, 0], poses.quaternions[:, 2] = w, y
        return poses

    def _plan(self) -> tuple[FloatArray, FloatArray, bool]:
        """Planned centres, offsets of the mass centres along x and z, and whether any is not 0."""
        if self._planned is None:
            rows = [(*box.centre, *box.mass_offset[::2]) for box in self.boxes]
            centres, offsets = np.split(np.array(rows).reshape(-1, 5), [3], axis=1)
            self._planned = centres, offsets.T, bool(offsets.any())
        return self._planned

    def _motions(self) -> list[tuple[float, float, float]]:
        moving = [entry.body for entry in self._bodies]
        return [(*body.velocity, body.angular_velocity) for body in moving]

    def _velocities(self) -> Velocities:
        x, z, turning = np.array(self._motions()).reshape(-1, 3).T
        linear, angular = np.zeros((2, len(x), 3))
        linear[:, 0], linear[:, 2], angular[:, 1] = x, z, -turning
        return Velocities(linear, angular)

    def _speeds(self) -> FloatArray:
        speeds = [(math.sqrt(x * x + z * z), abs(turning)) for x, z, turning in self._motions()]
        return np.array(speeds).reshape(-1, 2)

    def _set_velocities(self, velocities: Velocities) -> None:
        """Take over the part in the plane; velocity along y and turning about x and z are lost."""
        self._prepare()
        rows = zip(self.boxes, self._bodies, *map(np.ndarray.tolist, velocities), strict=True)
        for box, entry, (x, _, z), (_, turning, _) in rows:
            if not box.fixed:
                entry.body.velocity, entry.body.angular_velocity = (x, z), -turning

    def _reset(self) -> None:
        # A space counts the shapes that it has ever held, and solves contacts in an order that
        # depends on the count: only in a new space do boxes move as in a new world.
        self._space.remove(*self._space.shapes, *self._space.bodies)
        for entry in self._bodies:
            # Moving uses up the speed that pushes overlapping bodies apart.
            pymunk.Body.update_position(entry.body, 0.0)
            entry.place()
        self._open_space()

    def _close(self) -> None:
        del self._bodies, self._all_bodies, self._floor, self._space
