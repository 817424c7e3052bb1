"""Chipmunk through pymunk: two dimensions, impulses, the vertical x-z plane of the world."""

from __future__ import annotations

import math

import numpy as np
import pymunk

from engines.world import (
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

_FLOOR_HALF_WIDTH = 1000.0
_FLOOR_THICKNESS = 10.0
_ITERATIONS = 50

# Lengths here are metres; Chipmunk's default slop of 0.1 is meant for pixels.
_SLOP = 1e-5


class ChipmunkWorld(FixedStepWorld):
    """A Chipmunk world: only motion in the x-z plane exists.

    Of velocities that are set, the part out of the plane is dropped.

    Raises:
        EngineError: boxes that do not share their centre and size along y, or whose centre of mass
            lies off its middle. They would need the third dimension.
    """

    capabilities = Capabilities(
        title="Chipmunk (pymunk)",
        dimensions=2,
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
        notes="Two dimensions: a layout is judged when it is planar, and refused otherwise. At "
        "60 Hz with restitution 0.5 a tower of six cubes falls within 4 s (PS_3, literal).",
    )

    def __init__(self, settings: WorldSettings) -> None:
        super().__init__(settings)
        if settings.gravity[1]:
            raise EngineError("Chipmunk is 2-D: gravity must have no part along y")
        self._space = space = pymunk.Space()
        space.gravity = settings.gravity[0], settings.gravity[2]
        space.damping = 1.0 - settings.linear_damping
        space.iterations = settings.solver_iterations or _ITERATIONS
        space.collision_slop = _SLOP
        self._bodies: list[pymunk.Body] = []
        self._starts: list[tuple[float, float]] = []
        self._planned: tuple[FloatArray, FloatArray, bool] | None = None
        right, bottom = _FLOOR_HALF_WIDTH, -_FLOOR_THICKNESS
        corners = [(-right, bottom), (right, bottom), (right, 0.0), (-right, 0.0)]
        space.add(self._surface(pymunk.Poly(space.static_body, corners)))

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
        if box.fixed:
            body = pymunk.Body(body_type=pymunk.Body.STATIC)
        else:
            body = pymunk.Body(box.mass, box.inertia[1])
        start = (box.centre[0] + p, box.centre[2] + r)
        body.position = start
        self._space.add(body, self._surface(pymunk.Poly(body, corners)))
        self._bodies.append(body)
        self._starts.append(start)
        self._planned = None

    def _check_planar(self, box: Box) -> None:
        first = self.boxes[0] if self.boxes else box
        same = math.isclose(box.centre[1], first.centre[1], abs_tol=1e-3)
        same = same and math.isclose(box.size[1], first.size[1], abs_tol=1e-3)
        if not same or abs(box.mass_offset[1]) > 1e-3:
            raise EngineError("Chipmunk is 2-D: boxes must share their extent along y, centred")

    def _advance(self, substeps: int, length: float) -> None:
        step = self._space.step
        for _ in range(substeps):
            step(length)

    def _poses(self) -> Poses:
        planned, offsets, shifted = self._plan()
        states = [(*body.position, body.angle) for body in self._bodies]
        x, z, angles = np.array(states).reshape(-1, 3).T
        half = 0.5 * angles
        # Counter-clockwise from x to z is a negative turn about y.
        w, y = np.cos(half), -np.sin(half)
        if shifted:
            # The rotation of `attitudes.rotate`, of which only this is left in the plane.
            p, r = offsets
            across, along = 2.0 * (y * r), -2.0 * (y * p)
            x = x - (p + w * across + y * along)
            z = z - (r + w * along - y * across)
        centres, quaternions = planned.copy(), np.zeros((len(half), 4))
        centres[:, 0], centres[:, 2] = x, z
        quaternions[:, 0], quaternions[:, 2] = w, y
        return Poses(centres, quaternions)

    def _plan(self) -> tuple[FloatArray, FloatArray, bool]:
        """Planned centres, offsets of the mass centres along x and z, and whether any is not 0."""
        if self._planned is None:
            offsets = np.array([box.mass_offset for box in self.boxes]).reshape(-1, 3)
            centres = np.array([box.centre for box in self.boxes]).reshape(-1, 3)
            self._planned = centres, offsets[:, ::2].T.copy(), bool(offsets.any())
        return self._planned

    def _velocities(self) -> Velocities:
        states = [(*body.velocity, body.angular_velocity) for body in self._bodies]
        linear, angular = np.zeros((2, len(states), 3))
        x, z, turning = np.array(states).reshape(-1, 3).T
        linear[:, 0], linear[:, 2], angular[:, 1] = x, z, -turning
        return Velocities(linear, angular)

    def _speeds(self) -> FloatArray:
        # For the few boxes of most worlds a loop costs less than arrays.
        states = [(*body.velocity, body.angular_velocity) for body in self._bodies]
        speeds = [(math.sqrt(x * x + z * z), abs(turning)) for x, z, turning in states]
        return np.array(speeds).reshape(-1, 2)

    def _set_velocities(self, velocities: Velocities) -> None:
        """Take over the part in the plane; velocity along y and turning about x and z are lost."""
        rows = zip(self.boxes, self._bodies, *map(np.ndarray.tolist, velocities), strict=True)
        for box, body, (x, _, z), (_, turning, _) in rows:
            if not box.fixed:
                body.velocity, body.angular_velocity = (x, z), -turning

    def _reset(self) -> None:
        # Two things outlast a new pose: the contacts with the impulses of the last step, which go
        # with a shape, and the speed that pushes overlapping bodies apart, which moving uses up.
        shapes = [shape for body in self._bodies for shape in body.shapes]
        self._space.remove(*shapes)
        for box, body, start in zip(self.boxes, self._bodies, self._starts, strict=True):
            if box.fixed:
                continue
            pymunk.Body.update_position(body, 0.0)
            body.position, body.angle = start, 0.0
            body.velocity, body.angular_velocity = (0.0, 0.0), 0.0
        self._space.add(*shapes)

    def _close(self) -> None:
        self._bodies.clear()
        del self._space
