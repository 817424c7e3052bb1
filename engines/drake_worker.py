"""The child process that runs Drake for :mod:`steadyload.engines.with_drake`; it imports nothing of
ours.

It answers one request after the other over a connection whose file number is its only argument,
and ends with its parent. A request is a tuple: its name, the number of a world, and

* ``build``: gravity [m/s2], Coulomb coefficient, :class:`Body` fields of every box;
* ``advance``: states to start from or None to go on, seconds, longest step [s];
* ``drop``: nothing.

A state is w, x, y, z of the attitude, the centre of mass [m], the angular velocity [rad/s] and
the velocity of the centre of mass [m/s], all in world axes: 13 numbers a free box. The answer is
``(None, states)``, with states of None except to ``advance``, or ``(message, None)``.
"""

from __future__ import annotations

import logging
import signal
import sys
from collections.abc import Sequence
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

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


class Body(NamedTuple):
    """A box as the worker takes it: SI units, the shape about the centre of mass."""

    size: tuple[float, float, float]
    mass: float
    inertia: tuple[float, float, float]
    mass_centre: tuple[float, float, float]
    attitude: tuple[float, float, float, float]
    shape_centre: tuple[float, float, float]
    fixed: bool


class Scene:
    """A Drake simulation of boxes on the floor."""

    def __init__(
        self, gravity: tuple[float, float, float], friction: float, bodies: Sequence[Body]
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

    def advance(self, states: np.ndarray | None, seconds: float, step: float) -> np.ndarray:
        """Simulate ``seconds`` from ``states``, or from where it is; returns the new states."""
        if not self._positions.size:
            return np.zeros((0, 13))
        simulator = self._simulator
        if states is not None:
            self._start(states, step)
        simulator.get_mutable_integrator().set_maximum_step_size(step)
        simulator.AdvanceTo(simulator.get_context().get_time() + seconds)
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


def serve(connection: Connection) -> None:
    """Answer requests until the other end is closed."""
    scenes: dict[int, Scene] = {}
    while True:
        try:
            name, world, *values = connection.recv()
        except EOFError:
            return
        try:
            connection.send((None, _answer(scenes, name, world, values)))
        except (RuntimeError, ValueError) as error:
            scenes.pop(world, None)
            connection.send((str(error), None))


def _answer(
    scenes: dict[int, Scene], name: str, world: int, values: list[Any]
) -> np.ndarray | None:
    scene = scenes.pop(world, None)
    if name == "build":
        gravity, friction, bodies = values
        scenes[world] = Scene(gravity, friction, [Body(*fields) for fields in bodies])
    elif name == "advance":
        assert scene is not None, "a world is built before it is advanced"
        scenes[world] = scene
        return scene.advance(*values)
    return None


if __name__ == "__main__":
    # The parent decides when this process ends, also when its user presses Ctrl-C.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    logging.getLogger("drake").setLevel(logging.ERROR)
    serve(Connection(int(sys.argv[1])))
