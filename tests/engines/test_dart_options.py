"""DART without a matrix: as repeatable as its usual solver, and nearly as stiff."""

import numpy as np
import pytest

from steadyload.engines.dart_options import DartOptions
from steadyload.engines.registry import open_world
from steadyload.engines.world import Box, WorldSettings

SIDE, GAP = 0.2, 5e-4
PILE = [
    Box((SIDE, SIDE, SIDE), 4.0, (x * (SIDE + GAP), y * (SIDE + GAP), (z + 0.5) * SIDE))
    for z in range(4)
    for x in range(3)
    for y in range(3)
]
"""Each upper box stands on one below it."""

ACROSS = [Box((3.1 * SIDE, 3.1 * SIDE, SIDE), 30.0, (SIDE + GAP, SIDE + GAP, 4.5 * SIDE))]
"""A slab on all stacks joins them: 36 rows and more of one problem."""


def settled(options, *, twice=False):
    """Centres of the pile after 0.2 s, if asked for the second time of a reseated world."""
    settings = WorldSettings(friction=0.5, options=options)
    with open_world("dart", settings) as world:
        for box in PILE + ACROSS:
            world.add_box(box)
        for _ in range(1 + twice):
            world.reset_poses()
            world.stepSimulation(0.2, 100, 1.0 / 240.0)
        return world.poses().centres.copy()


@pytest.mark.parametrize("rows", [1, 97])
def test_a_pile_stands_without_a_matrix(rows):
    planned = np.array([box.centre for box in PILE + ACROSS])
    found, usual = settled(DartOptions(rows)), settled(None)
    assert np.abs(found - planned).max() < 2e-3
    assert np.abs(usual - planned).max() < 1e-3
    assert not np.array_equal(found, usual)  # it is another solver


def test_a_pile_stands_without_split_impulses():
    planned = np.array([box.centre for box in PILE + ACROSS])
    found = settled(DartOptions(97, split_impulse=0))
    assert np.abs(found - planned).max() < 2e-3
    assert not np.array_equal(found, settled(DartOptions(97)))


def test_without_a_matrix_a_reseated_world_moves_as_a_new_one():
    options = DartOptions(97)
    assert np.array_equal(settled(options), settled(options, twice=True))


def test_options_of_dart_are_checked():
    with pytest.raises(ValueError, match="matrix_free_rows is -1; allowed: 0 to"):
        DartOptions(-1)
    with pytest.raises(TypeError, match="options are 'fast'; allowed: DartOptions"):
        open_world("dart", WorldSettings(options="fast"))
