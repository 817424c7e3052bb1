"""Checks that boxes and settings outside the limits never reach an engine."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

from steadyload.engines.checks.scenes import CUBE, WorldClass, expect, rounding
from steadyload.engines.errors import BadNumberError
from steadyload.engines.world import GRAVITY, Box, WorldSettings

_FINE = Box(CUBE, 1.0, (0.0, 0.0, 0.05))
_NOT_FINITE = (math.nan, math.inf, -math.inf)
_NOT_POSITIVE = (0.0, -0.1, 5e-324)

# An offset outside the box harms no engine, while a size that is no number can end the process: an
# adapter that lets all of them pass fails on the earlier ones first.
_BAD_BOXES: tuple[tuple[str, Box], ...] = (
    *(
        ("mass_offset", Box(CUBE, 1.0, _FINE.centre, offset))
        for offset in ((0.06, 0.0, 0.0), (0.0, -0.06, 0.0), *((0.0, 0.0, n) for n in _NOT_FINITE))
    ),
    *(
        ("attitude", Box(CUBE, 1.0, _FINE.centre, attitude=bad))
        for bad in (
            (0.0, 0.0, 0.0, 0.0),
            (1.0, 0.0, 0.1, 0.0),
            *((1.0, 0.0, n, 0.0) for n in _NOT_FINITE),
        )
    ),
    *(
        ("velocity", Box(CUBE, 1.0, _FINE.centre, velocity=(0.0, 0.0, bad)))
        for bad in (1e300, *_NOT_FINITE)
    ),
    *(
        ("angular_velocity", Box(CUBE, 1.0, _FINE.centre, angular_velocity=(0.0, 0.0, bad)))
        for bad in (1e300, *_NOT_FINITE)
    ),
    *(
        ("moments", Box(CUBE, 1.0, _FINE.centre, moments=bad))
        for bad in (
            (0.0, 1e-3, 1e-3),
            (1e-3, 1e-3, 4e-3),
            (1e-3, 1e-3, 2.1e-3),
            *((1e-3, n, 1e-3) for n in _NOT_FINITE),
        )
    ),
    ("velocities", Box(CUBE, 1.0, _FINE.centre, fixed=True, velocity=(1.0, 0.0, 0.0))),
    *(("centre", Box(CUBE, 1.0, (0.0, 0.0, bad))) for bad in _NOT_FINITE),
    *(("centre", Box(CUBE, 1.0, (bad, 0.0, 0.05))) for bad in _NOT_FINITE),
    *(("mass", Box(CUBE, bad, _FINE.centre)) for bad in (*_NOT_POSITIVE, 1e300, *_NOT_FINITE)),
    *(
        ("size", Box((0.1, bad, 0.1), 1.0, _FINE.centre))
        for bad in (*_NOT_POSITIVE, 1e300, *_NOT_FINITE)
    ),
)


def check_bad_numbers_are_refused(world_class: WorldClass) -> None:
    """Boxes and durations that cannot be are refused by name, and the world stays as it was."""
    half = 0.5 * CUBE[0]
    with world_class(WorldSettings()) as world:
        world.add_box(_FINE)
        for name, box in _BAD_BOXES:
            expect_refusal(partial(world.add_box, box), f"box 1: {name} ")
        for bad in _NOT_FINITE:
            expect_refusal(partial(world.stepSimulation, bad, 10, 0.01), "durations must be")
            expect_refusal(partial(world.stepSimulation, 0.1, 10, bad), "durations must be")
        index = world.add_box(Box(CUBE, 1.0, (0.5, 0.0, 10.0), (half, 0.0, -half)))
        assert index == 1, f"the box after refused ones has index {index}"
        world.stepSimulation(0.1, 100, 0.01)
        expect(world.poses().centres[0], _FINE.centre, 1e-3, "box beside refused ones")
        expect(
            world.velocities().linear[1, 2],
            -0.1 * GRAVITY,
            rounding(world_class),
            "speed of the next box",
        )


def expect_refusal(operation: Callable[[], object], message: str) -> None:
    """Fail unless an operation raises BadNumberError with a message that holds another."""
    try:
        operation()
    except BadNumberError as refusal:
        said = str(refusal)
    else:
        raise AssertionError(f"accepted what it should refuse with {message!r}")
    assert message in said, f"{message!r} is not in {said!r}"
