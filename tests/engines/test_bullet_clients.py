"""What Bullet's clients keep from one world to the next."""

import numpy as np
import pytest

from steadyload.engines import with_bullet
from steadyload.engines.with_bullet import BulletWorld
from steadyload.engines.world import Box, WorldSettings

HIGH = Box((0.2, 0.2, 0.2), 5.0, (0.0, 0.0, 0.5))
LOW = Box((0.2, 0.2, 0.2), 5.0, (0.0, 0.0, 0.1))


def fallen():
    with BulletWorld(WorldSettings()) as world:
        world.add_box(HIGH)
        world.stepSimulation(0.5, 1000, 1.0 / 240.0)
        return world.poses().centres


def test_a_box_that_was_interrupted_is_not_in_the_next_world(monkeypatch):
    """A Ctrl-C after Bullet has the body and before the world knows it."""
    expected = fallen()

    def interrupted(body, *others, **named):
        raise KeyboardInterrupt

    with BulletWorld(WorldSettings()) as world:
        monkeypatch.setattr(with_bullet.pybullet, "changeDynamics", interrupted)
        with pytest.raises(KeyboardInterrupt):
            world.add_box(LOW)
        monkeypatch.undo()
    np.testing.assert_array_equal(fallen(), expected)
