"""The reference simulator as an engine: the adapter between the protocol and compiled code."""

from __future__ import annotations

import math

import numpy as np

from steadyload.engines.attitudes import (
    axes_of_quaternion,
    centres_from_mass_centres,
    quaternions_of_axes,
)
from steadyload.engines.reference import islands, radau
from steadyload.engines.reference.contact import BODY, make_scratch
from steadyload.engines.reference.motion import Field
from steadyload.engines.reference.options import Integrator, ReferenceOptions
from steadyload.engines.reference.rodas import (
    FINISHED,
    NOT_FINITE,
    SINGULAR,
    STEP_TOO_SMALL,
    TOO_MUCH_WORK,
    Control,
)
from steadyload.engines.world import (
    Box,
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
    planned_velocities,
)

_FIRST_STEP = 1e-4
"""Length of the first step after a start from rest [s]; the error decides from there on."""

_MOST_WORK = 20_000_000
"""Attempts at a step, times pairs that may touch, a group and window: half a minute. A placement of
20 items takes some thousand."""

_INTEGRATORS = {Integrator.RODAS: islands.advance, Integrator.RADAU: radau.advance}

_WHY = {
    STEP_TOO_SMALL: "the error stays above the tolerance however short the step is",
    NOT_FINITE: "the state became non-finite",
    SINGULAR: "a linear system is singular",
    TOO_MUCH_WORK: "it needs too many steps, by far",
}


class ReferenceWorld(FixedStepWorld):
    """Rigid boxes in compliant contact, integrated with error control.

    The substeps of the protocol only add up to a time: the integrator chooses its own steps.
    Options: :class:`steadyload.engines.reference.options.ReferenceOptions`.
    """

    capabilities = Capabilities(
        title="reference",
        dimensions=3,
        numerics=("numpy", "scipy"),
        error_controlled=True,
        compliant=True,
        settings=declare(
            friction=SettingSupport(Support.HONOURED, "static coefficient, regularised"),
            restitution=SettingSupport(
                Support.IGNORED, "contacts are damped; a coefficient is its own option, rebound"
            ),
            linear_damping=SettingSupport(Support.HONOURED, "v ln(1 - d) in the equations"),
            angular_damping=SettingSupport(Support.HONOURED, "w ln(1 - d) in the equations"),
            margin=SettingSupport(Support.IGNORED, "contacts begin where faces meet"),
            broad_phase=SettingSupport(Support.IGNORED, "has its own"),
            solver_iterations=SettingSupport(Support.IGNORED, "the linear solver is direct"),
        ),
        changing_gravity=SettingSupport(Support.HONOURED),
        in_flight=SettingSupport(Support.HONOURED),
        notes="Compliant contact over the exact contact polygon, integrated with error control "
        "(RODAS, order 4). The frequency has no effect but where it ends a call: steps are chosen "
        "by the error.",
    )

    def __init__(self, settings: WorldSettings) -> None:
        super().__init__(settings)
        options = self._own_options(ReferenceOptions)
        self._law = options.law(float(settings.friction))
        self._field = Field(
            np.array(settings.gravity, dtype=float),
            -options.value("floor_gap"),
            *settings.decay_rates(),
        )
        self._control = Control(options.tolerance, options.most_time, _MOST_WORK)
        self._integrate = _INTEGRATORS[options.integrator]
        self._scratch = make_scratch()
        self._added: list[Box] = []
        self._bodies = _bodies(self._added)
        self._mass_centres = self._linear = self._angular = np.empty((0, 3))
        self._axes = np.empty((0, 3, 3))
        self._next_steps = np.empty(0)

    @classmethod
    def warm_up(cls, box_count: int) -> None:
        """Compile, or load the compiled code."""
        with cls(WorldSettings()) as world:
            world.add_box(Box((0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.05)))
            world.stepSimulation(1e-3, 1, 1e-3)

    def _add(self, box: Box) -> None:
        self._added.append(box)  # taken over by _prepare, all at once

    def _prepare(self) -> None:
        new = self._added[len(self._mass_centres) :]
        if not new:
            return
        self._bodies = _bodies(self._added)
        centres, axes, linear, angular = _starts(new)
        self._mass_centres = np.concatenate((self._mass_centres, centres))
        self._axes = np.concatenate((self._axes, axes))
        self._linear = np.concatenate((self._linear, linear))
        self._angular = np.concatenate((self._angular, angular))
        self._next_steps = np.full(len(self._added), _FIRST_STEP)

    def _advance(self, substeps: int, length: float) -> None:
        self._prepare()
        if not self._added:
            return
        outcome, _, _ = self._integrate(
            self._law, self._field, self._bodies, self._mass_centres, self._axes, self._linear,
            self._angular, self._next_steps, float(substeps * length), self._control,
            self._scratch,
        )  # fmt: skip
        if outcome != FINISHED:
            raise EngineError(f"the integrator gave up: {_WHY[outcome]}")

    def _poses(self) -> Poses:
        self._prepare()
        quaternions = quaternions_of_axes(self._axes)
        centres = centres_from_mass_centres(
            self._mass_centres.copy(), quaternions, self._bodies.offset
        )
        for index in np.flatnonzero(self._bodies.fixed):
            centres[index] = self._added[index].centre
        return Poses(centres, quaternions)

    def _velocities(self) -> Velocities:
        self._prepare()
        return Velocities(self._linear.copy(), self._angular.copy())

    def _set_velocities(self, velocities: Velocities) -> None:
        self._prepare()
        free = ~self._bodies.fixed
        self._linear[free] = velocities.linear[free]
        self._angular[free] = velocities.angular[free]
        self._next_steps[:] = _FIRST_STEP

    def _set_gravity(self) -> None:
        self._field = self._field._replace(gravity=np.array(self.gravity, dtype=float))
        self._next_steps[:] = _FIRST_STEP

    def _reset(self) -> None:
        self._prepare()
        if self._added:
            starts = _starts(self._added)
            self._mass_centres, self._axes, self._linear, self._angular = starts
        self._next_steps[:] = _FIRST_STEP

    def _close(self) -> None:
        self._bodies = _bodies([])


def _starts(boxes: list[Box]) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Centres of mass, axes, and velocities, linear and angular, of boxes as they are added."""
    linear, angular = planned_velocities(boxes)
    axes = np.tile(np.eye(3), (len(boxes), 1, 1))
    for own, box in zip(axes, boxes, strict=True):
        if box.launched:
            own[:] = axes_of_quaternion(box.unit_attitude)
    return np.array([box.mass_centre for box in boxes]), axes, linear, angular


def _bodies(boxes: list[Box]) -> np.recarray:
    bodies = np.rec.array(np.zeros(len(boxes), BODY))
    for body, box in zip(bodies, boxes, strict=True):
        body.half = 0.5 * np.array(box.size)
        body.offset, body.fixed = box.mass_offset, box.fixed
        # What never moves needs no mass; any will do where one stands in a denominator.
        body.mass, body.inertia = (1.0, 1.0) if box.fixed else (box.mass, box.inertia)
        body.extent = math.hypot(*(body.half + np.abs(body.offset)))
    return bodies
