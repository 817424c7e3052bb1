"""MuJoCo: soft contact by convex optimisation, elliptic friction cones, one model per item count.

Compiling a model for every placed item would cost more than simulating it. A *ladder* holds one
compiled model with exactly j free boxes for each j; a world borrows a ladder, writes its boxes into
the arrays of rung j, and copies the state from rung j - 1. The trajectories are bit-identical to
those of freshly compiled models.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np

from engines.world import (
    Box,
    Capabilities,
    EngineError,
    FixedStepWorld,
    Poses,
    SettingSupport,
    Support,
    Velocities,
    WorldSettings,
    centres_from_mass_centres,
    declare,
    rotate,
)

_FLOOR_HALF = (1000.0, 1000.0, 10.0)

# A stiff, nearly hard contact. The default solimp (0.9, 0.95) lets a standing cube tip, and the
# default pyramidal cone lets one creep by 17-28 mm/s.
_SOLIMP = (0.95, 0.99, 0.001, 0.5, 2.0)

# Contact with restitution e as a damped oscillator that is resolved by 8 substeps a half period.
_HALF_PERIOD_SUBSTEPS = 8.0

_ARENA_PER_BOX = 512 * 1024
_ARENA_LEAST = 4 * 1024 * 1024

mujoco.set_mju_user_warning(lambda message: None)
# Without a handler every warning is written to MUJOCO_LOG.TXT in the working directory. The
# warnings themselves are counted in MjData.warning, where _advance looks.

_FATAL_WARNINGS = (mujoco.mjtWarning.mjWARN_CONTACTFULL, mujoco.mjtWarning.mjWARN_CNSTRFULL)


def _compile(box_count: int) -> mujoco.MjModel:
    """A model of a floor and ``box_count`` free boxes; every number in it is a placeholder."""
    spec = mujoco.MjSpec()
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.disableflags = (
        mujoco.mjtDisableBit.mjDSBL_AUTORESET  # an unstable state must be seen, not reset
        | mujoco.mjtDisableBit.mjDSBL_MIDPHASE  # one geom a body: nothing to traverse
    )
    spec.memory = max(_ARENA_LEAST, box_count * _ARENA_PER_BOX)
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX, size=_FLOOR_HALF, pos=(0.0, 0.0, -_FLOOR_HALF[2])
    )
    for index in range(box_count):
        body = spec.worldbody.add_body(pos=(0.0, 0.0, 10.0 * index + 10.0))
        body.explicitinertial = True
        body.mass = 1.0
        body.ipos = (0.0, 0.0, 0.0)
        body.inertia = (1.0, 1.0, 1.0)
        body.add_freejoint()
        # Off-centre, so that the compiler does not mark geom and body frames as the same.
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=(1.0, 1.0, 1.0), pos=(0.1, 0.1, 0.1))
    return spec.compile()


class _Rung:
    """The model with j boxes and its state."""

    def __init__(self, box_count: int) -> None:
        self.model = _compile(box_count)
        self.data = mujoco.MjData(self.model)
        self.length = math.nan


class _Ladder:
    """Compiled models by item count; owned by one world at a time."""

    def __init__(self) -> None:
        self._rungs: dict[int, _Rung] = {}

    def rung(self, box_count: int) -> _Rung:
        if box_count not in self._rungs:
            self._rungs[box_count] = _Rung(box_count)
        return self._rungs[box_count]


_idle_ladders: list[_Ladder] = []
"""Ladders that no world owns."""


class MujocoWorld(FixedStepWorld):
    """A MuJoCo world.

    Raises:
        EngineError: contacts or constraints did not fit into the arena (nothing is dropped
            silently).
    """

    capabilities = Capabilities(
        title="MuJoCo",
        dimensions=3,
        settings=declare(
            friction=SettingSupport(Support.HONOURED, "pairs take the maximum"),
            restitution=SettingSupport(
                Support.ON_REQUEST,
                "emulate=restitution makes contacts springy: bounces come out right within about "
                "0.06, but stacks are pushed apart (eight cubes fall under PS_3's values)",
            ),
            linear_damping=SettingSupport(Support.EMULATED, "joint damping -m ln(1 - d)"),
            angular_damping=SettingSupport(Support.EMULATED, "joint damping -I ln(1 - d)"),
            margin=SettingSupport(
                Support.EMULATED,
                "as a detection distance: contacts are found earlier and push only once touching",
            ),
            broad_phase=SettingSupport(Support.IGNORED, "MuJoCo has one, sweep and prune"),
            solver_iterations=SettingSupport(Support.HONOURED, "Newton iterations, default 100"),
        ),
    )

    def __init__(self, settings: WorldSettings) -> None:
        super().__init__(settings)
        self._ladder = _idle_ladders.pop() if _idle_ladders else _Ladder()
        self._rung: _Rung | None = None
        self._pending: list[Box] = []

    @classmethod
    def warm_up(cls, box_count: int) -> None:
        """Compile the models of a ladder."""
        ladder = _idle_ladders.pop() if _idle_ladders else _Ladder()
        for count in range(1, box_count + 1):
            ladder.rung(count)
        _idle_ladders.append(ladder)

    def prepare(self) -> None:
        """Climb to the rung for all boxes added so far."""
        self._climb()

    def _add(self, box: Box) -> None:
        self._pending.append(box)

    def _climb(self) -> _Rung | None:
        """The rung for all boxes added so far, with the state of those that were there before."""
        if not self._pending:
            return self._rung
        boxes = [*self.boxes]
        old, placed = self._rung, len(boxes) - len(self._pending)
        new = self._ladder.rung(len(boxes))
        self._write(new, boxes)
        _fresh_state(new.data)
        new.data.qpos.reshape(-1, 7)[:] = [_start(b) for b in boxes]
        if old is not None and placed:
            new.data.time = old.data.time
            new.data.qpos[: 7 * placed] = old.data.qpos
            new.data.qvel[: 6 * placed] = old.data.qvel
            new.data.qacc_warmstart[: 6 * placed] = old.data.qacc_warmstart
        self._rung = new
        self._pending.clear()
        return new

    def _write(self, rung: _Rung, boxes: list[Box]) -> None:
        model, settings = rung.model, self.settings
        mass = np.array([b.mass for b in boxes])
        inertia = np.array([b.inertia for b in boxes])
        half = 0.5 * np.array([b.size for b in boxes])
        model.body_mass[1:] = mass
        model.body_inertia[1:] = inertia
        model.body_subtreemass[0] = mass.sum()
        model.body_subtreemass[1:] = mass
        model.geom_size[1:] = half
        model.geom_aabb[1:, 3:] = half
        model.geom_rbound[1:] = np.sqrt((half * half).sum(axis=1))
        model.geom_pos[1:] = [[-r for r in b.mass_offset] for b in boxes]
        model.geom_friction[:, 0] = settings.friction
        model.geom_solimp[:] = _SOLIMP
        # MuJoCo 4: `margin` inflates the geometry, `gap` is detection alone.
        model.geom_gap[:] = settings.margin
        model.body_margin[:] = settings.margin
        model.opt.gravity[:] = settings.gravity
        model.opt.iterations = settings.solver_iterations or 100
        damping = model.dof_damping.reshape(-1, 6)
        damping[:, :3] = -math.log1p(-settings.linear_damping) * mass[:, None]
        damping[:, 3:] = -math.log1p(-settings.angular_damping) * inertia
        # What mj_setConst would derive from a free box whose frame is its centre of mass.
        rotational = (1.0 / inertia).mean(axis=1)
        model.dof_M0.reshape(-1, 6)[:, :3] = mass[:, None]
        model.dof_M0.reshape(-1, 6)[:, 3:] = inertia
        model.dof_invweight0.reshape(-1, 6)[:, :3] = (1.0 / mass)[:, None]
        model.dof_invweight0.reshape(-1, 6)[:, 3:] = rotational[:, None]
        model.body_invweight0[1:, 0] = 1.0 / mass
        model.body_invweight0[1:, 1] = rotational
        model.stat.meaninertia = model.dof_M0.mean()
        rung.length = math.nan  # contact parameters follow the substep and are due again

    def _contact_parameters(self, rung: _Rung, length: float) -> None:
        restitution = self.settings.restitution if "restitution" in self.settings.emulate else 0.0
        if restitution > 0.0:
            frequency = math.pi / (_HALF_PERIOD_SUBSTEPS * length)
            decay = -math.log(restitution)
            ratio = decay / math.hypot(decay, math.pi)
            rung.model.geom_solref[:] = (-(frequency**2), -2.0 * ratio * frequency)
        else:
            rung.model.geom_solref[:] = (2.0 * length, 1.0)
        rung.model.opt.timestep = length
        rung.length = length

    def _advance(self, substeps: int, length: float) -> None:
        rung = self._climb()
        if rung is None:
            return
        if rung.length != length:
            self._contact_parameters(rung, length)
        mujoco.mj_step(rung.model, rung.data, nstep=substeps)
        for warning in _FATAL_WARNINGS:
            if rung.data.warning[warning].number:
                raise EngineError(f"MuJoCo's arena is too small for {len(self.boxes)} boxes")

    def _poses(self) -> Poses:
        rung = self._climb()
        if rung is None:
            return Poses(np.empty((0, 3)), np.empty((0, 4)))
        # qpos, not xpos: the latter is one substep old.
        state = rung.data.qpos.reshape(-1, 7)
        quaternions = state[:, 3:] / np.linalg.norm(state[:, 3:], axis=1, keepdims=True)
        offsets = -rung.model.geom_pos[1:]
        return Poses(centres_from_mass_centres(state[:, :3], quaternions, offsets), quaternions)

    def _velocities(self) -> Velocities:
        rung = self._climb()
        if rung is None:
            return Velocities(np.empty((0, 3)), np.empty((0, 3)))
        velocity = rung.data.qvel.reshape(-1, 6)
        # A free joint's rotational velocity is expressed in the body's own axes.
        angular = rotate(rung.data.qpos.reshape(-1, 7)[:, 3:], velocity[:, 3:])
        return Velocities(velocity[:, :3].copy(), angular)

    def _reset(self) -> None:
        rung = self._climb()
        if rung is not None:
            _fresh_state(rung.data)
            rung.data.qpos.reshape(-1, 7)[:] = [_start(b) for b in self.boxes]

    def _close(self) -> None:
        self._rung = None
        _idle_ladders.append(self._ladder)


def _start(box: Box) -> tuple[float, ...]:
    centre, offset = box.centre, box.mass_offset
    return (*(c + r for c, r in zip(centre, offset, strict=True)), 1.0, 0.0, 0.0, 0.0)


def _fresh_state(data: mujoco.MjData) -> None:
    """Time, velocities and the solver's warm start as in a world that was never stepped."""
    data.time = 0.0
    data.qvel[:] = 0.0
    data.qacc[:] = 0.0
    data.qacc_warmstart[:] = 0.0
    for warning in data.warning:
        warning.number = 0
