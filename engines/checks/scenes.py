"""Building blocks of checks: scenes, measures, and the exceptions for what does not apply."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from steadyload.engines.attitudes import rotate
from steadyload.engines.world import (
    Box,
    FixedStepWorld,
    FloatArray,
    Poses,
    Support,
    Velocities,
)

WorldClass = type[FixedStepWorld]
Check = Callable[[WorldClass], None]

CUBE = (0.1, 0.1, 0.1)


class NotApplicable(Exception):  # noqa: N818 - an outcome, not an error
    """The engine declares that it lacks what a check is about."""


def expect(
    found: ArrayLike, expected: ArrayLike, absolute: float, what: str, relative: float = 0.0
) -> None:
    """Fail unless ``found`` is ``expected`` to within an absolute plus a relative tolerance."""
    ok = np.allclose(found, expected, rtol=relative, atol=absolute)
    assert ok, f"{what}: found {found!r}, expected {expected!r} +- {absolute:g} + {relative:.0%}"


def rounding(world_class: WorldClass) -> float:
    """Largest error by rounding of a quantity of about one, over some hundred substeps."""
    return 1e-4 if world_class.capabilities.single_precision else 1e-9


def require_space(world_class: WorldClass) -> None:
    """Leave a check of motion out of the plane to engines that have it."""
    if world_class.capabilities.dimensions < 3:
        raise NotApplicable(f"{world_class.__name__} has two dimensions")


def require(world_class: WorldClass, setting: str) -> None:
    """Leave a check that an engine declares itself out of."""
    if world_class.capabilities.settings[setting].support is Support.IGNORED:
        raise NotApplicable(f"{world_class.__name__} declares that it ignores {setting}")


def require_flight(world_class: WorldClass) -> None:
    """Leave a check of boxes that are turned or move from the start to engines that take them."""
    if world_class.capabilities.in_flight.support is Support.IGNORED:
        raise NotApplicable(f"{world_class.__name__} declares that its boxes start at rest")


def require_subsets(world_class: WorldClass) -> None:
    """Leave a check of boxes that are left out to engines that can do it."""
    if not world_class.capabilities.subsets:
        raise NotApplicable(f"{world_class.__name__} declares no subsets")


def fill(world: FixedStepWorld, scene: Sequence[Box]) -> None:
    """Add all boxes of a scene."""
    for box in scene:
        world.add_box(box)


def two_cubes(shift: float, offset: float = 0.0) -> list[Box]:
    """Two cubes of 10 cm, the upper one shifted along x, its centre of mass by ``offset`` more."""
    return [
        Box(CUBE, 1.0, (0.0, 0.0, 0.05)),
        Box(CUBE, 1.0, (shift, 0.0, 0.15), (offset, 0.0, 0.0)),
    ]


def flat_pile(count: int, x: float = 0.0) -> list[Box]:
    """Flat bars on one another, in which many forces balance."""
    size = (0.16, 0.1, 0.02)
    return [Box(size, 0.1, (x + 0.01 * (k % 3), 0.0, 0.01 + 0.02 * k)) for k in range(count)]


def fall_speed(world: FixedStepWorld) -> float:
    """Downward speed of the first box [m/s]."""
    velocities: Velocities = world.velocities()
    return -float(velocities.linear[0, 2])


def angles(poses: Poses) -> FloatArray:
    """Total angles [degrees]."""
    return np.degrees(2.0 * np.arccos(np.minimum(1.0, np.abs(poses.quaternions[:, 0]))))


def turned_about(axis: Sequence[float], degrees: float) -> tuple[float, float, float, float]:
    """Unit quaternion (w, x, y, z) of a turn about an axis of any length."""
    half = math.radians(0.5 * degrees)
    share = math.sin(half) / math.hypot(*axis)
    x, y, z = axis
    return (math.cos(half), share * x, share * y, share * z)


def mass_centres(poses: Poses, scene: Sequence[Box]) -> FloatArray:
    """Centres of mass [m], shape (n, 3)."""
    return poses.centres + rotate(poses.quaternions, np.array([b.mass_offset for b in scene]))


def lowest_corner(poses: Poses, box: Box, index: int = 0) -> float:
    """Height of the lowest corner of a box [m]."""
    signs = np.array([(a, b, c) for a in (-0.5, 0.5) for b in (-0.5, 0.5) for c in (-0.5, 0.5)])
    turned = rotate(np.tile(poses.quaternions[index], (8, 1)), signs * box.size)
    return float(poses.centres[index, 2] + turned[:, 2].min())
