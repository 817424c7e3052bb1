"""Checks of going back to the plan: with all boxes, and with some."""

from __future__ import annotations

import numpy as np

from steadyload.engines.checks.scenes import (
    WorldClass,
    expect,
    fill,
    flat_pile,
    require_subsets,
    two_cubes,
)
from steadyload.engines.substeps import StepCount
from steadyload.engines.world import Box, FixedStepWorld, Poses, WorldSettings


def check_reseat_equals_a_fresh_world(world_class: WorldClass) -> None:
    """After ``reset_poses`` all boxes, later ones too, move as in a new world, to within 1e-9 m.

    Among them a flat pile, in which many forces balance, and boxes that slide and topple: what
    survives of forces, contacts or attitudes grows in them to 1e-4 m.
    """
    plank = (0.2, 0.1, 0.02)
    scene = [
        *flat_pile(6, x=1.0),
        *two_cubes(0.05),
        Box(plank, 0.1, (0.3, 0.0, 0.3), fixed=True),
        Box((0.06, 0.1, 0.2), 0.7, (0.38, 0.0, 0.41), (0.01, 0.0, 0.05)),
        Box(plank, 0.5, (0.06, 0.0, 0.21), (0.02, 0.0, 0.0)),
    ]
    planned = np.array([b.centre for b in scene])
    with world_class(WorldSettings()) as world:
        fill(world, scene)
        world.stepSimulation(0.3, 1000, 1.0 / 240.0)
        expected = world.poses()
    assert np.abs(expected.centres - planned).max() > 1e-3, "something should topple"
    with world_class(WorldSettings()) as world:
        for part in (scene[:9], scene[9:], []):
            fill(world, part)
            world.stepSimulation(0.3, 1000, 1.0 / 240.0)
            again = world.poses()
            world.stepSimulation(0.5 / 240.0, 1000, 1.0 / 240.0)
            world.reset_poses()
            count = world.stepSimulation(0.5 / 240.0, 1000, 1.0 / 240.0)
            assert count == StepCount(0, 0, 0), "half a substep survived the reset"
            world.reset_poses()
            moved = np.abs(world.poses().centres - planned[: len(world.boxes)]).max()
            assert moved < 1e-12, "not at the planned poses"
            assert not any(v.any() for v in world.velocities()), "not at rest"
            if len(again.centres) == len(scene):
                expect(again.centres, expected.centres, 1e-9, "centres after reseating")
                expect(again.quaternions, expected.quaternions, 1e-8, "attitudes after reseating")


def check_a_subset_equals_a_world_of_its_own(world_class: WorldClass) -> None:
    """With boxes left out, the others move as if those had never been added, to within 1e-9 m.

    Those left out carry, stop and push others while they take part, and one is fixed. They are
    taken in again, and a box is added while some are out.
    """
    require_subsets(world_class)
    bar = (0.16, 0.1, 0.02)
    scene = [
        *two_cubes(0.04),
        Box(bar, 0.1, (0.08, 0.0, 0.21), fixed=True),
        Box(bar, 3.0, (0.08, 0.0, 0.23), (0.01, 0.0, 0.0)),
        Box((0.1, 0.1, 0.3), 0.7, (-0.1, 0.0, 0.15)),
        *flat_pile(5, x=1.0),
        Box((0.06, 0.1, 0.2), 0.7, (0.11, 0.0, 0.34), (0.01, 0.0, 0.05)),
    ]
    last = len(scene) - 1
    parts: list[list[int] | None] = [[0, 1], [1, 3, 6], [2, 3, 4, 5, 7], None, [3], [0, 2, 3]]

    def moved(world: FixedStepWorld) -> Poses:
        world.stepSimulation(0.3, 1000, 1.0 / 240.0)
        return world.poses()

    def alone(chosen: list[int]) -> Poses:
        with world_class(WorldSettings()) as world:
            fill(world, [scene[i] for i in chosen])
            return moved(world)

    def compare(found: Poses, chosen: list[int]) -> None:
        wanted = alone(chosen)
        expect(found.centres, wanted.centres, 1e-9, f"centres of boxes {chosen}")
        expect(found.quaternions, wanted.quaternions, 1e-8, f"attitudes of boxes {chosen}")

    with world_class(WorldSettings()) as world:
        fill(world, scene[:last])
        for chosen in parts:
            world.reset_poses(only=chosen)
            index = list(range(last)) if chosen is None else chosen
            planned = np.array([scene[i].centre for i in index])
            assert world.boxes == [scene[i] for i in index], "other boxes than those chosen"
            assert np.abs(world.poses().centres - planned).max() < 1e-12, "not as planned"
            assert not any(v.any() for v in world.velocities()), "not at rest"
            compare(moved(world), index)
        world.reset_poses(only=[0, 2, 3])
        assert world.add_box(scene[last]) == last, "boxes are counted with those left out"
        compare(moved(world), [0, 2, 3, last])
        for wrong in ([1, 0], [0, 0], [-1], [last + 1]):
            try:
                world.reset_poses(only=wrong)
            except ValueError:
                continue
            raise AssertionError(f"accepts boxes {wrong}")
