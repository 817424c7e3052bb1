"""Bullet through pybullet: rigid bodies in maximal coordinates, sequential impulses."""

from __future__ import annotations

import contextlib
import math
import os
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from steadyload.engines.attitudes import centres_from_mass_centres, lengths
from steadyload.engines.box import AT_REST
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


# Without it the class still states its capabilities; the registry says what is missing.
with _without_banner(), contextlib.suppress(ModuleNotFoundError):
    import pybullet

# The Python API lowers these two below the native defaults (0.1 and 0.08); with its values a
# stack of ten cubes collapses within 0.3 s at 60 Hz. These are the values of native Bullet.
_WARM_STARTING = 0.85
_CONTACT_ERP = 0.2
_ITERATIONS = 50

# Contact points closer than this, in units of a shape's size, are taken for one. At the default of
# 0.02 the four corners of a base 1 cm wide and 60 cm long become two, and the item rolls over.
_BREAKING = 0.005

_FLOOR_HALF = (1000.0, 1000.0, 10.0)

# Too short to move anything; Bullet takes 2e-16 s and less for no step at all.
_INSTANT = 1e-12

# Bullet's own filters, group and mask: free bodies collide with all, fixed ones with what is free.
_FREE, _FIXED, _ABSENT = (1, -1), (2, ~2), (0, 0)

_FARTHEST = 1e6
"""Coordinates [m] up to which a client is trusted to have stayed sound."""

_MOST_BODIES = 1000
"""Bodies that a client holds one after the other before it is reset: removing one leaves memory
behind, some 4 KB, until then."""


@dataclass(slots=True)
class _Client:
    """A native world with nothing in it but the floor, for one world after the other.

    Connecting costs 40 ms, resetting 0.2 ms, the floor as any body 0.08 ms.

    Attributes:
        number: what the native library calls it.
        flags: it was reset with; None before the first time.
        floor: handle of the floor.
        bodies: that it has held since it was reset.
    """

    number: int
    flags: int | None = None
    floor: int = -1
    bodies: int = 0

    def make_ready(self, flags: int) -> None:
        """Reset, where it is due."""
        if self.flags == flags and self.bodies < _MOST_BODIES:
            return
        pybullet.resetSimulation(flags, physicsClientId=self.number)
        # A box, not a plane: a plane throws a grid of small cubes apart.
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_BOX, halfExtents=_FLOOR_HALF, physicsClientId=self.number
        )
        self.floor = pybullet.createMultiBody(
            0.0,
            shape,
            basePosition=(0.0, 0.0, -_FLOOR_HALF[2]),
            useMaximalCoordinates=1,
            physicsClientId=self.number,
        )
        self.flags, self.bodies = flags, 0


_idle_clients: list[_Client] = []
"""Those that no world owns."""


@lru_cache(maxsize=4096)
def _native_calls(substeps: int, length: float) -> tuple[tuple[float, int], ...]:
    """Native calls ``(fixedTimeStep, numSubSteps)`` that together run exactly ``substeps``.

    pybullet hands the substep count to Bullet, which counts them back in floating point and loses
    one for N = 27, 31, 54, 62 and others. A single variable step (``numSubSteps=0``) is exact and
    clears Bullet's remainder, so every batch is followed by one, and a batch that would lose a
    substep, or run one of another length, is made smaller.
    """
    calls: list[tuple[float, int]] = []
    left = substeps
    while left > 0:
        batch = left - 1
        while batch > 1 and not _is_exact(batch, length):
            batch -= 1
        if batch > 1:
            calls.append((length * batch, batch))
            left -= batch
        calls.append((length, 0))
        left -= 1
    return tuple(calls)


def _is_exact(batch: int, length: float) -> bool:
    native_length = length * batch / batch
    return native_length == length and int(length * batch / native_length) == batch


class _Body(NamedTuple):
    """A box of a world: its native handle, its kind, and how it starts.

    ``start``: its centre of mass [m]. ``offset``: of that, from its middle [m]. ``turn``: its
    attitude (x, y, z, w). ``motion``: its velocities; None where it starts at rest.
    """

    handle: int
    start: tuple[float, float, float]
    offset: tuple[float, float, float]
    turn: tuple[float, float, float, float]
    motion: tuple[tuple[float, float, float], tuple[float, float, float]] | None
    fixed: bool

    def place(self, client: int) -> None:
        """Put it where it starts, with its velocities."""
        pybullet.resetBasePositionAndOrientation(self.handle, self.start, self.turn, client)
        if self.motion is not None:  # else placing it has stopped it
            pybullet.resetBaseVelocity(self.handle, *self.motion, client)


def _connect() -> _Client:
    client = pybullet.connect(pybullet.DIRECT)
    if client < 0:
        raise EngineError("pybullet has no physics client left; are worlds not being closed?")
    return _Client(client)


class BulletWorld(FixedStepWorld):
    """A pybullet world. A diverged state shows in its poses.

    Raises:
        EngineError: more than some thousand worlds are open at once.
    """

    capabilities = Capabilities(
        title="Bullet (pybullet)",
        dimensions=3,
        subsets=True,
        version=2,  # since worlds after others move as first ones under the simple broad phase
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
        changing_gravity=SettingSupport(Support.HONOURED),
        in_flight=SettingSupport(
            Support.HONOURED,
            "an attitude turns by an eighth of a turn a substep at most, whatever its angular "
            "velocity: by 377 rad/s at 480 Hz, by 71 rad/s at 90 Hz",
        ),
    )

    def __init__(self, settings: WorldSettings) -> None:
        super().__init__(settings)
        flags = pybullet.RESET_USE_DISCRETE_DYNAMICS_WORLD
        if settings.broad_phase is BroadPhase.SIMPLE:
            flags |= pybullet.RESET_USE_SIMPLE_BROADPHASE
        self._friction = math.sqrt(settings.friction)
        self._restitution = math.sqrt(settings.restitution)
        self._owned = _idle_clients.pop() if _idle_clients else _connect()
        self._owned.make_ready(flags)
        self._client = self._owned.number
        self._set_gravity()
        pybullet.setPhysicsEngineParameter(
            numSolverIterations=settings.solver_iterations or _ITERATIONS,
            warmStartingFactor=_WARM_STARTING,
            contactERP=_CONTACT_ERP,
            contactBreakingThreshold=_BREAKING,
            # Contacts in the order of bodies: else they stand in that in which pairs were found,
            # which depends on all that the broad phase has seen.
            deterministicOverlappingPairs=1,
            physicsClientId=self._client,
        )
        self._as_planned = True
        self._bodies: list[_Body] = []
        self._all_bodies: list[_Body] = []
        pybullet.changeDynamics(
            self._owned.floor,
            -1,
            lateralFriction=self._friction,
            restitution=self._restitution,
            physicsClientId=self._client,
        )

    @classmethod
    def warm_up(cls, box_count: int) -> None:
        """Connect a client."""
        if not _idle_clients:
            _idle_clients.append(_connect())

    def _add(self, box: Box) -> None:
        client, settings = self._client, self.settings
        x, y, z = box.size
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_BOX, halfExtents=(0.5 * x, 0.5 * y, 0.5 * z), physicsClientId=client
        )
        body = pybullet.createMultiBody(
            0.0 if box.fixed else box.mass,
            shape,
            basePosition=box.centre,
            baseInertialFramePosition=(0.0, 0.0, 0.0) if box.fixed else box.mass_offset,
            useMaximalCoordinates=1,
            physicsClientId=client,
        )
        margin = {"collisionMargin": settings.margin} if settings.margin else {}
        motion = {
            "mass": box.mass,  # left out, setting the inertia sets the mass to zero
            "localInertiaDiagonal": box.inertia,
            "linearDamping": settings.linear_damping,
            "angularDamping": settings.angular_damping,
        }
        pybullet.changeDynamics(
            body,
            -1,
            lateralFriction=self._friction,
            restitution=self._restitution,
            physicsClientId=client,
            **margin,
            **({} if box.fixed else motion),
        )
        w, x, y, z = box.unit_attitude
        start, offset = (box.centre, AT_REST) if box.fixed else (box.mass_centre, box.mass_offset)
        first = (box.velocity, box.angular_velocity) if box.in_motion else None
        added = _Body(body, start, offset, (x, y, z, w), first, box.fixed)
        if box.launched:
            added.place(client)
        self._bodies.append(added)
        self._all_bodies.append(added)

    def _set_gravity(self) -> None:
        pybullet.setGravity(*self.gravity, physicsClientId=self._client)

    def _take_part(self, chosen: list[int]) -> None:
        self._bodies = [self._all_bodies[i] for i in chosen]
        for index, body in enumerate(self._all_bodies):
            if body.fixed:
                filters = _FIXED if index in chosen else _ABSENT
                pybullet.setCollisionFilterGroupMask(body.handle, -1, *filters, self._client)

    def _start_afresh(self) -> None:
        """Leave nothing of the past behind, before the boxes leave their planned poses.

        Placing a body drops neither its contacts, with the impulses that warm starting uses, nor
        the inertia of its last attitude. A new pair has no contacts, so all pairs are dissolved
        and formed again; only a step computes inertia, so one is done while there are no pairs.
        New worlds take the same way: they start with an inertia of Bullet's own making. What does
        not take part is left without pairs, and falls.
        """
        client, self._as_planned = self._client, False
        mask = pybullet.setCollisionFilterGroupMask
        for body in self._all_bodies:
            if not body.fixed:
                mask(body.handle, -1, *_ABSENT, client)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=_INSTANT, numSubSteps=0, physicsClientId=client
        )
        pybullet.stepSimulation(client)
        self._place()
        for body in self._bodies:
            if not body.fixed:
                mask(body.handle, -1, *_FREE, client)

    def _place(self) -> None:
        for body in self._all_bodies:
            body.place(self._client)

    def _advance(self, substeps: int, length: float) -> None:
        if self._as_planned:
            self._start_afresh()
        for duration, count in _native_calls(substeps, length):
            pybullet.setPhysicsEngineParameter(
                fixedTimeStep=duration, numSubSteps=count, physicsClientId=self._client
            )
            pybullet.stepSimulation(physicsClientId=self._client)

    def _poses(self) -> Poses:
        read, client = pybullet.getBasePositionAndOrientation, self._client
        rows = np.array([p + q for p, q in (read(b.handle, client) for b in self._bodies)])
        rows = rows.reshape(-1, 7)
        quaternions = rows[:, (6, 3, 4, 5)]
        offsets = np.array([b.offset for b in self._bodies]).reshape(-1, 3)
        return Poses(centres_from_mass_centres(rows[:, :3], quaternions, offsets), quaternions)

    def _velocities(self) -> Velocities:
        rows = self._velocity_rows()
        return Velocities(rows[:, 0].copy(), rows[:, 1].copy())

    def _speeds(self) -> FloatArray:
        return lengths(self._velocity_rows())

    def _velocity_rows(self) -> FloatArray:
        read, client = pybullet.getBaseVelocity, self._client
        return np.array([read(b.handle, client) for b in self._bodies]).reshape(-1, 2, 3)

    def _set_velocities(self, velocities: Velocities) -> None:
        if self._as_planned:
            self._start_afresh()
        rows = zip(self._bodies, *map(np.ndarray.tolist, velocities), strict=True)
        for body, linear, angular in rows:
            if not body.fixed:
                pybullet.resetBaseVelocity(body.handle, linear, angular, self._client)

    def _reset(self) -> None:
        self._place()
        self._as_planned = True

    def _close(self) -> None:
        owned, read, client = self._owned, pybullet.getBasePositionAndOrientation, self._client
        poses = [read(body.handle, client) for body in self._all_bodies]
        if not all(abs(c) < _FARTHEST for place, turn in poses for c in place + turn):
            owned.flags = None  # what overflowed may have left its mark: reset
        # The last one first: the simple broad phase hands out places the other way round than they
        # were given back, and sorts pairs by them. So the next world's are those of a first one.
        for body in reversed(self._all_bodies):
            pybullet.removeBody(body.handle, client)
        if pybullet.getNumBodies(client) != 1:
            owned.flags = None  # adding a box was interrupted half-way: one more than the floor
        owned.bodies += len(self._all_bodies)
        _idle_clients.append(owned)
