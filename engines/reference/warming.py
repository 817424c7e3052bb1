"""The reference's part of ``steadyload warm-up``."""

from __future__ import annotations

from steadyload.engines.reference.options import Integrator, ReferenceOptions
from steadyload.engines.reference.world import ReferenceWorld
from steadyload.engines.world import Box, WorldSettings


def warm_up() -> None:
    """Compile the reference with both integrators, or load the compiled code."""
    ReferenceWorld.warm_up(1)
    settings = WorldSettings(options=ReferenceOptions(integrator=Integrator.RADAU))
    with ReferenceWorld(settings) as world:
        world.add_box(Box((0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.05)))
        world.stepSimulation(1e-3, 1, 1e-3)
