"""Bullet through pybullet: rigid bodies in maximal coordinates, sequential impulses."""

from __future__ import annotations

import contextlib
import math
import os
from functools import lru_cache

import numpy as np

from engines.world import (
    Box,
    BroadPhase,
    Capabilities,
    FixedStepWorld,
    Poses,
    SettingSupport,
    Support,
    Velocities,
    WorldSettings,
    centres_from_mass_centres,
    declare,
)


@contextlib.contextmanager
def _without_banner():
    """pybullet greets on the C level of stderr when imported; a command's stderr is for errors."""
    saved = os.dup(2)
    null = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(null, 2)
        yield
    finally:
        os.dup2(saved, 2)
        os.close(saved)
        os.close(null)


with _without_banner():
    import pybullet

# The Python API lowers these two below the native defaults (0.1 and 0.08); with its values a
# stack of ten cubes collapses within 0.3 s at 60 Hz. These are the values of native Bullet.
_WARM_STARTING = 0.85
_CONTACT_ERP = 0.2
_ITERATIONS = 50
_BREAKING = 0.005

_FLOOR_HALF = (1000.0, 1000.0, 10.0)

_idle_clients: list[int] = []
"""Physics clients that no world owns: connecting costs 40 ms, resetting 0.2 ms."""


@lru_cache(maxsize=4096)
def _native_calls(substeps: int, length: float) -> tuple[tuple[float, int], ...]:
    """Native calls ``(fixedTimeStep, numSubSteps)`` that together run exactly ``substeps``.

    pybullet hands the substep count to Bullet, which counts them back in floating point and loses
    one for N = 27, 31, 54, 62 and others. A single variable step (``numSubSteps=0``) is exact and
    clears Bullet's remainder, so a call that would lose is split, and every batch ends with one.
    """
    calls: list[tuple[float, int]] = []
    left = substeps - 1
    while left > 0:
        batch = left
        while batch > 1 and int((length * batch) / ((length * batch) / batch)) != batch:
            batch -= 1
        calls.append((length * batch, batch) if batch > 1 else (length, 0))
        if batch > 1 and left > batch:
            calls.append((length, 0))
            left -= 1
        left -= batch
    calls.append((length, 0))
    return tuple(calls)


class BulletWorld(FixedStepWorld):
    """A pybullet world. Raises nothing of its own; a diverged state shows in its poses."""

    capabilities = Capabilities(
        title="Bullet (pybullet)",
        dimensions=3,
        settings=declare(
            friction=SettingSupport(
                Support.HONOURED, "pairs multiply, so each body gets the square root"
            ),
            restitution=SettingSupport(
                Support.HONOURED,
                "pairs multiply, so each body gets the square root; position correction adds "
                "speed: 0.50 comes out as 0.50 at 240 Hz and as 0.59 at 1 kHz",
            ),
            linear_damping=SettingSupport(Support.HONOURED, "v (1 - d)^t"),
            angular_damping=SettingSupport(Support.HONOURED, "w (1 - d)^t"),
            margin=SettingSupport(
                Support.HONOURED, "native collision margin; boxes keep their size under it"
            ),
            broad_phase=SettingSupport(
                Support.HONOURED,
                "simple or dbvt (default); pybullet offers no sweep",
                values=(BroadPhase.SIMPLE, BroadPhase.DBVT),
            ),
            solver_iterations=SettingSupport(Support.HONOURED, f"default {_ITERATIONS}"),
        ),
    )

    def __init__(self, settings: WorldSettings) -> None:
        super().__init__(settings)
        flags = pybullet.RESET_USE_DISCRETE_DYNAMICS_WORLD
        if settings.broad_phase is BroadPhase.SIMPLE:
            flags |= pybullet.RESET_USE_SIMPLE_BROADPHASE
        self._client = _idle_clients.pop() if _idle_clients else pybullet.connect(pybullet.DIRECT)
        pybullet.resetSimulation(flags, physicsClientId=self._client)
        pybullet.setGravity(*settings.gravity, physicsClientId=self._client)
        # numSubSteps and fixedTimeStep survive a reset; these do not.
        pybullet.setPhysicsEngineParameter(
            numSolverIterations=settings.solver_iterations or _ITERATIONS,
            warmStartingFactor=_WARM_STARTING,
            contactERP=_CONTACT_ERP,
            contactBreakingThreshold=_BREAKING,
            physicsClientId=self._client,
        )
        self._bodies: list[int] = []
        self._starts: list[tuple[float, float, float]] = []
        # A box, not a plane: a plane throws a grid of small cubes apart.
        floor = pybullet.createCollisionShape(
            pybullet.GEOM_BOX, halfExtents=_FLOOR_HALF, physicsClientId=self._client
        )
        self._surface(
            pybullet.createMultiBody(
                0.0,
                floor,
                basePosition=(0.0, 0.0, -_FLOOR_HALF[2]),
                useMaximalCoordinates=1,
                physicsClientId=self._client,
            )
        )

    def _surface(self, body: int) -> None:
        pybullet.changeDynamics(
            body,
            -1,
            lateralFriction=math.sqrt(self.settings.friction),
            restitution=math.sqrt(self.settings.restitution),
            physicsClientId=self._client,
        )

    def _add(self, box: Box) -> None:
        client, settings = self._client, self.settings
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_BOX, halfExtents=[s / 2.0 for s in box.size], physicsClientId=client
        )
        body = pybullet.createMultiBody(
            box.mass,
            shape,
            basePosition=box.centre,
            baseInertialFramePosition=box.mass_offset,
            useMaximalCoordinates=1,
            physicsClientId=client,
        )
        extra = {"collisionMargin": settings.margin} if settings.margin else {}
        self._surface(body)
        pybullet.changeDynamics(
            body,
            -1,
            mass=box.mass,  # left out, setting the inertia sets the mass to zero
            linearDamping=settings.linear_damping,
            angularDamping=settings.angular_damping,
            localInertiaDiagonal=box.inertia,
            physicsClientId=client,
            **extra,
        )
        self._bodies.append(body)
        self._starts.append(pybullet.getBasePositionAndOrientation(body, physicsClientId=client)[0])

    def _advance(self, substeps: int, length: float) -> None:
        for duration, count in _native_calls(substeps, length):
            pybullet.setPhysicsEngineParameter(
                fixedTimeStep=duration, numSubSteps=count, physicsClientId=self._client
            )
            pybullet.stepSimulation(physicsClientId=self._client)

    def _poses(self) -> Poses:
        read, client = pybullet.getBasePositionAndOrientation, self._client
        rows = [read(body, physicsClientId=client) for body in self._bodies]
        mass_centres = np.array([r[0] for r in rows]).reshape(-1, 3)
        xyzw = np.array([r[1] for r in rows]).reshape(-1, 4)
        quaternions = xyzw[:, (3, 0, 1, 2)]
        offsets = np.array([b.mass_offset for b in self.boxes]).reshape(-1, 3)
        return Poses(centres_from_mass_centres(mass_centres, quaternions, offsets), quaternions)

    def _velocities(self) -> Velocities:
        rows = [pybullet.getBaseVelocity(b, physicsClientId=self._client) for b in self._bodies]
        return Velocities(
            np.array([r[0] for r in rows]).reshape(-1, 3),
            np.array([r[1] for r in rows]).reshape(-1, 3),
        )

    def _reset(self) -> None:
        client = self._client
        for body, start in zip(self._bodies, self._starts, strict=True):
            pybullet.resetBasePositionAndOrientation(
                body, start, (0.0, 0.0, 0.0, 1.0), physicsClientId=client
            )
            pybullet.resetBaseVelocity(
                body, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), physicsClientId=client
            )

    def _close(self) -> None:
        _idle_clients.append(self._client)
