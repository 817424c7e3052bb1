"""PhysX 5 on the CPU through sapien: temporal Gauss-Seidel, patch friction, in single precision."""

from __future__ import annotations

import contextlib
import math
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from steadyload.engines.rebuilt import RebuiltWorld
from steadyload.engines.world import (
    Box,
    Capabilities,
    SettingSupport,
    Support,
    WorldSettings,
    declare,
)

# Without it the class still states its capabilities; the registry says what is missing.
with warnings.catch_warnings(), contextlib.suppress(ModuleNotFoundError):
    # It looks for Vulkan, to draw scenes, when it is imported.
    warnings.simplefilter("ignore")
    import sapien
    from sapien import physx

_ITERATIONS = 20

_REACH = 1e-3
"""Distance at which contacts are looked for [m]; sapien's own is 1 cm."""

_BOUNCE = 0.1
"""Speed from which a contact bounces [m/s]; PhysX's own, 2 m/s, lets nothing in a pallet bounce."""

_FASTEST_TURN = 1e4
"""Largest angular speed [rad/s]; PhysX's own is 100."""

_SETTLING = 1
"""Velocity iterations, after the position iterations; PhysX's own."""

_PLANE = ([0.0, 0.0, 0.0], [math.sqrt(0.5), 0.0, -math.sqrt(0.5), 0.0])
"""Pose of the floor: PhysX's plane looks along x; turned, it looks up."""

_NO_TORQUE = np.zeros(3)


class PhysxWorld(RebuiltWorld):
    """A PhysX world on the CPU, in the process's own thread."""

    capabilities = Capabilities(
        title="PhysX (sapien)",
        dimensions=3,
        subsets=True,
        single_precision=True,
        settings=declare(
            friction=SettingSupport(Support.HONOURED, "pairs take the mean"),
            restitution=SettingSupport(
                Support.HONOURED, "pairs take the mean; contacts slower than 0.1 m/s do not bounce"
            ),
            linear_damping=SettingSupport(Support.EMULATED, "v (1 + h ln(1 - d)) a substep"),
            angular_damping=SettingSupport(Support.EMULATED, "w (1 + h ln(1 - d)) a substep"),
            margin=SettingSupport(Support.IGNORED, "its rest offset would inflate the boxes"),
            broad_phase=SettingSupport(Support.IGNORED, "sapien offers no choice"),
            solver_iterations=SettingSupport(
                Support.HONOURED, f"position iterations, default {_ITERATIONS}"
            ),
        ),
        changing_gravity=SettingSupport(Support.EMULATED, "forces at the centres of mass"),
        in_flight=SettingSupport(
            Support.HONOURED, f"boxes turn at {_FASTEST_TURN:g} rad/s at most"
        ),
        notes="Installed with `pip install -e '.[physx]'`. Single precision. What sapien "
        "takes for a scene is of the whole process and is set before each.",
    )

    def __init__(self, settings: WorldSettings) -> None:
        super().__init__(settings)
        friction = settings.friction
        self._material = physx.PhysxMaterial(friction, friction, settings.restitution)
        self._built_under = settings.gravity

    def _build(self) -> sapien.Scene:
        # Of the process, and read when a system is made: all of it is set every time.
        own = physx.PhysxSceneConfig()
        with np.errstate(over="ignore"):  # what overflows shows in the poses
            own.gravity = self._built_under = self.gravity
        own.bounce_threshold = _BOUNCE
        own.enable_pcm = own.enable_tgs = own.enable_friction_every_iteration = True
        own.enable_enhanced_determinism, own.enable_ccd = True, False
        physx.set_scene_config(own)
        scene = sapien.Scene([physx.PhysxCpuSystem()])
        floor = physx.PhysxRigidStaticComponent()
        floor.attach(_touching(physx.PhysxCollisionShapePlane(self._material)))
        _enter(scene, floor, sapien.Pose(*_PLANE))
        return scene

    def _body(self, box: Box) -> physx.PhysxRigidDynamicComponent | None:
        half = [0.5 * edge for edge in box.size]
        part = physx.PhysxRigidStaticComponent() if box.fixed else self._moved(box)
        part.attach(_touching(physx.PhysxCollisionShapeBox(half, self._material)))
        if not box.fixed:
            # After the shape, which sets them by its density.
            part.mass, part.inertia = box.mass, box.inertia
            part.cmass_local_pose = sapien.Pose(box.mass_offset)
        _enter(self._native, part, sapien.Pose(box.centre, box.unit_attitude))
        if box.in_motion:
            self._set_velocity(part, box.velocity, box.angular_velocity)
        return None if box.fixed else part

    def _moved(self, box: Box) -> physx.PhysxRigidDynamicComponent:
        part = physx.PhysxRigidDynamicComponent()
        part.linear_damping, part.angular_damping = self.settings.decay_rates()
        part.max_angular_velocity = _FASTEST_TURN
        part.sleep_threshold = 0.0
        part.solver_position_iterations = self.settings.solver_iterations or _ITERATIONS
        part.solver_velocity_iterations = _SETTLING
        return part

    def _set_gravity(self) -> None:
        """Nothing: what differs from the gravity of the scene acts as forces, see :meth:`_run`."""

    def _run(self, substeps: int, length: float) -> None:
        system = self._native.physx_system
        system.timestep = length
        more = np.subtract(self.gravity, self._built_under)
        pushed = [body for body in self._bodies if body is not None] if more.any() else []
        for _ in range(substeps):
            for body in pushed:
                body.add_force_torque(body.mass * more, _NO_TORQUE)
            system.step()

    def _pose(self, body: physx.PhysxRigidDynamicComponent) -> tuple[Any, Any]:
        pose = body.entity_pose
        return pose.p, pose.q

    def _velocity(self, body: physx.PhysxRigidDynamicComponent) -> tuple[Any, Any]:
        return body.linear_velocity, body.angular_velocity

    def _set_velocity(
        self,
        body: physx.PhysxRigidDynamicComponent,
        linear: Sequence[float],
        angular: Sequence[float],
    ) -> None:
        body.linear_velocity, body.angular_velocity = linear, angular


def _touching(shape: physx.PhysxCollisionShape) -> physx.PhysxCollisionShape:
    """A shape whose contacts begin where it touches, whatever the process has for new ones."""
    shape.contact_offset, shape.rest_offset = _REACH, 0.0
    return shape


def _enter(scene: sapien.Scene, part: physx.PhysxRigidBaseComponent, pose: sapien.Pose) -> None:
    entity = sapien.Entity()
    entity.add_component(part)
    entity.set_pose(pose)
    scene.add_entity(entity)
