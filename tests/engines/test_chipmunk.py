"""Chipmunk's worlds after a reset, to the last bit, on layouts as they are packed."""

import numpy as np
import pytest

from steadyload.engines.with_chipmunk import ChipmunkWorld
from steadyload.engines.world import WorldSettings
from steadyload.methods.simulation.scene import boxes, planar_scene
from steadyload.tuning.cases import CaseSource, load_cases


@pytest.fixture(scope="module")
def scenes():
    cases = load_cases(CaseSource(directory="planar"))[:40]
    return [boxes(case.layout, across=planar_scene(case.layout).across) for case in cases]


def _filled(scene):
    world = ChipmunkWorld(WorldSettings())
    for box in scene:
        world.add_box(box)
    return world


def _moved(world):
    world.stepSimulation(0.3, 100, 1.0 / 120.0)
    return np.hstack([*world.poses(), *world.velocities(), world.speeds()])


def test_a_reset_world_moves_as_a_new_one(scenes):
    """Chipmunk's order of contacts would change where shapes went back into the space they left."""
    for scene in scenes:
        with _filled(scene) as world:
            first = _moved(world)
            for _ in range(3):
                world.reset_poses()
                assert np.array_equal(_moved(world), first)


def test_a_part_of_a_world_moves_as_a_world_of_its_own(scenes):
    rng = np.random.default_rng(1)
    for scene in scenes:
        with _filled(scene) as world:
            for _ in range(3):
                chosen = np.flatnonzero(rng.random(len(scene)) < 0.6).tolist() or [0]
                world.reset_poses(only=chosen)
                with _filled([scene[i] for i in chosen]) as alone:
                    assert np.array_equal(_moved(world), _moved(alone))
