"""Scenes of Drake, for the child process of :mod:`steadyload.engines.with_drake`; this file imports
nothing of ours.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    HalfSpace,
    HydroelasticContactRepresentation,
    ProximityProperties,
)
from pydrake.geometry import Box as BoxShape
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, ContactModel, CoulombFriction
from pydrake.multibody.tree import SpatialInertia, UnitInertia
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from pydrake.systems.framework import DiagramBuilder

if TYPE_CHECKING:
    from steadyload.engines.serving import Body

logging.getLogger("drake").setLevel(logging.ERROR)

ACCURACY = 1e-5
"""Largest estimated error of a step: metres, and components of a unit quaternion. At 1e-4 the
verdict changes on 2 of 60 layouts, at half the cost."""

MODULUS = 1e10
"""Pressure [Pa] where a box is compressed to its middle. A cube of 10 cm on another tips 0.7 mm too
early; at 1e9 it is 1.5 mm, at 1e11 no less."""

DISSIPATION = 50.0
"""Hunt and Crossley's coefficient [s/m]: stops whatever arrives faster than some 0.02 m/s."""

REPRESENTATION = HydroelasticContactRepresentation.kPolygon
"""Triangles, the default of a continuous plant, end in NaN where faces of a contact surface have no
area: a cube at rest on a fixed box, in 15 of 30 variants of stiffness and gap; polygons in none."""

STICTION_SPEED = 1e-4
"""Slip of a contact that sticks [m/s], at the limit of friction."""


class Scene:
    """A Drake simulation of boxes on the floor."""

    def __init__(
        self, gravity: tuple[float, float, float], bodies: Sequence[Body], friction: float
    ) -> None:
        builder = DiagramBuilder()
        # A plant without a time step is continuous, as the integrator asks for.
        self._plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
        plant = self._plant
        plant.set_contact_model(ContactModel.kHydroelastic)
        plant.set_contact_surface_representation(REPRESENTATION)
        plant.mutable_gravity_field().set_gravity_vector(np.array(gravity))
        ground = self._material(friction)
        AddRigidHydroelasticProperties(ground)
        world = plant.world_body()
        plant.RegisterCollisionGeometry(world, RigidTransform(), HalfSpace(), "floor", ground)
        material = self._material(friction)
        AddCompliantHydroelasticProperties(1.0, MODULUS, material)
        free = []
        for index, body in enumerate(bodies):
            name, shape = f"box{index}", BoxShape(*body.size)
            if body.fixed:
                turn = RotationMatrix(Quaternion(body.attitude))
                pose = RigidTransform(turn, body.mass_centre + turn @ np.array(body.shape_centre))
                plant.RegisterCollisionGeometry(world, pose, shape, name, material)
                continue
            x, y, z = np.array(body.inertia) / body.mass
            inertia = SpatialInertia(body.mass, np.zeros(3), UnitInertia(x, y, z))
            link = plant.AddRigidBody(name, inertia)
            pose = RigidTransform(np.array(body.shape_centre))
            plant.RegisterCollisionGeometry(link, pose, shape, name, material)
            free.append(link)
        plant.Finalize()
        plant.set_stiction_tolerance(STICTION_SPEED)
        self._positions = np.array([b.floating_positions_start() for b in free], int)
        self._velocities = np.array([b.floating_velocities_start_in_v() for b in free], int)
        self._simulator = Simulator(builder.Build())
        self._context = plant.GetMyMutableContextFromRoot(self._simulator.get_mutable_context())

    @staticmethod
    def _material(friction: float) -> ProximityProperties:
        properties = ProximityProperties()
        coefficient = CoulombFriction(friction, friction)
        AddContactMaterial(dissipation=DISSIPATION, friction=coefficient, properties=properties)
        return properties

    def advance(self, states: np.ndarray | None, substeps: int, length: float) -> np.ndarray:
        """Simulate from ``states``, or from where it is; returns the new states.

        A substep is the longest that the integrator takes.
        """
        if not self._positions.size:
            return np.zeros((0, 13))
        simulator = self._simulator
        if states is not None:
            self._start(states, length)
        simulator.get_mutable_integrator().set_maximum_step_size(length)
        simulator.AdvanceTo(simulator.get_context().get_time() + substeps * length)
        q = self._plant.GetPositions(self._context)[self._positions[:, None] + np.arange(7)]
        v = self._plant.GetVelocities(self._context)[self._velocities[:, None] + np.arange(6)]
        return np.hstack((q, v))

    def _start(self, states: np.ndarray, step: float) -> None:
        """Begin anew, with the integrator: it reuses contacts if the time has not changed."""
        simulator = self._simulator
        simulator.get_mutable_context().SetTime(0.0)
        q, v = np.zeros(7 * len(states)), np.zeros(6 * len(states))
        q[self._positions[:, None] + np.arange(7)] = states[:, :7]
        v[self._velocities[:, None] + np.arange(6)] = states[:, 7:]
        self._plant.SetPositions(self._context, q)
        self._plant.SetVelocities(self._context, v)
        config = SimulatorConfig(
            integration_scheme="cenic",
            max_step_size=step,
            accuracy=ACCURACY,
            use_error_control=True,
        )
        ApplySimulatorConfig(config, simulator)
        simulator.Initialize()
