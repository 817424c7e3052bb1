"""Rapier through rapier3d: soft contacts solved in small steps, in single precision."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from steadyload.engines.attitudes import rotation_vector
from steadyload.engines.rapier_options import RapierOptions
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
with contextlib.suppress(ModuleNotFoundError):
    import rapier3d

_ITERATIONS = 8

_DAMPING_RATIO = 10.0
"""Of contacts; Rapier's own."""

_FRICTION_MODEL = "SIMPLIFIED"
"""Rapier's own. Under its other one, Coulomb friction at every contact, a box with a square foot
slides along a side of it as if its friction were 0.44 and not 0.5, at any number of iterations."""

_SINK, _REACH, _FASTEST = 5e-5, 2e-4, 1e6
"""Penetration that is let be [m], distance at which contacts are looked for [m], largest speed
[m/s]. Rapier's own are 5 mm, 2 cm and 400 m/s."""


class RapierWorld(RebuiltWorld):
    """A Rapier world. Options: :class:`steadyload.engines.rapier_options.RapierOptions`.

    Rapier takes out a body whose numbers overflow; its pose is then not a number.
    """

    capabilities = Capabilities(
        title="Rapier (rapier3d)",
        dimensions=3,
        subsets=True,
        single_precision=True,
        settings=declare(
            friction=SettingSupport(Support.HONOURED, "pairs take the mean"),
            restitution=SettingSupport(Support.HONOURED, "pairs take the mean"),
            linear_damping=SettingSupport(Support.EMULATED, "v / (1 - h ln(1 - d)) a substep"),
            angular_damping=SettingSupport(Support.EMULATED, "w / (1 - h ln(1 - d)) a substep"),
            margin=SettingSupport(Support.IGNORED, "its contact skin would inflate the boxes"),
            broad_phase=SettingSupport(Support.IGNORED, "Rapier has one, a tree of boxes"),
            solver_iterations=SettingSupport(
                Support.HONOURED, f"small steps a substep, default {_ITERATIONS}"
            ),
        ),
        version=2,  # since boxes slide at their friction
        changing_gravity=SettingSupport(Support.HONOURED),
        in_flight=SettingSupport(
            Support.HONOURED,
            "attitudes fall behind what turns fast: by 1.4 per cent at 300 rad/s and 90 Hz, by 0.1 "
            "at 480 Hz; boxes that start at rest turn at an eighth of a turn a substep at most",
        ),
        notes="Single precision. A contact is a damped spring of a frequency of its own "
        "(`contact_frequency`), so that the foot of a pile sinks in. Scenes are simulated ten "
        "times as large, under ten times the gravity (`length_scale`), because some lengths "
        "within Rapier are fixed.",
    )

    def __init__(self, settings: WorldSettings) -> None:
        super().__init__(settings)
        self._options = self._own_options(RapierOptions)
        self._scale = self._options.length_scale

    def _build(self) -> rapier3d.PhysicsWorld:
        native = rapier3d.PhysicsWorld(gravity=self._scaled(self.gravity))
        native.set_num_threads(1)
        parameters = native.integration_parameters
        parameters.length_unit = self._scale
        parameters.normalized_allowed_linear_error = _SINK
        parameters.normalized_prediction_distance = _REACH
        parameters.normalized_max_linear_velocity = _FASTEST
        hardness = rapier3d.SpringCoefficients(self._options.contact_frequency, _DAMPING_RATIO)
        parameters.contact_softness = parameters.static_contact_softness = hardness
        parameters.num_solver_iterations = self.settings.solver_iterations or _ITERATIONS
        parameters.friction_model = getattr(rapier3d.FrictionModel, _FRICTION_MODEL)
        parameters.contact_recycling = False
        native.add_collider(self._surface(rapier3d.Collider.halfspace((0.0, 0.0, 1.0))))
        return native

    def _set_gravity(self) -> None:
        if self._native is not None:
            self._native.gravity = self._scaled(self.gravity)

    def _body(self, box: Box) -> rapier3d.RigidBody | None:
        shape = self._surface(rapier3d.Collider.cuboid(*(0.5 * s for s in self._scaled(box.size))))
        centre = self._scaled(box.centre)
        if box.fixed:
            wall = _turned(rapier3d.RigidBody.fixed().translation(centre), box)
            self._native.add_body(wall, [shape])
            return None
        inertia = [self._scale * self._scale * moment for moment in box.inertia]
        mass = rapier3d.MassProperties(self._scaled(box.mass_offset), box.mass, inertia)
        linear, angular = self.settings.decay_rates()
        builder = rapier3d.RigidBody.dynamic().translation(centre).can_sleep(False)
        builder = builder.linear_damping(linear).angular_damping(angular)
        if box.in_motion:
            # Rapier cuts what turns by more than an eighth of a turn in one of its small steps.
            builder = builder.allow_fast_rotation(True)
            builder = builder.linvel(self._scaled(box.velocity)).angvel(box.angular_velocity)
        handle = self._native.add_body(_turned(builder, box), [shape.mass_properties(mass)])
        return self._native.rigid_bodies[handle]

    def _scaled(self, lengths: Iterable[float]) -> list[float]:
        return [self._scale * length for length in lengths]

    def _surface(self, shape: rapier3d.ColliderBuilder) -> rapier3d.ColliderBuilder:
        return shape.friction(self.settings.friction).restitution(self.settings.restitution)

    def _run(self, substeps: int, length: float) -> None:
        self._native.integration_parameters.dt = length
        for _ in range(substeps):
            self._native.step()

    def _pose(self, body: rapier3d.RigidBody) -> tuple[Any, Any]:
        if not body.is_enabled:
            return np.nan, np.nan
        x, y, z, w = body.rotation.quaternion
        return [c / self._scale for c in body.translation.to_tuple()], (w, x, y, z)

    def _velocity(self, body: rapier3d.RigidBody) -> tuple[Any, Any]:
        return [v / self._scale for v in body.linvel.to_tuple()], body.angvel.to_tuple()

    def _set_velocity(
        self, body: rapier3d.RigidBody, linear: Sequence[float], angular: Sequence[float]
    ) -> None:
        body.linvel, body.angvel = self._scaled(linear), angular


def _turned(builder: rapier3d.RigidBodyBuilder, box: Box) -> rapier3d.RigidBodyBuilder:
    return builder.rotation(rotation_vector(box.unit_attitude)) if box.launched else builder
