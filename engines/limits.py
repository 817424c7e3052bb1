"""Numbers that an engine may be given. Whatever is beyond them never reaches one.

The limits of boxes are far from anything that is judged. They are there so that squares and
products of what is allowed stay positive and finite, as moments of inertia must.
"""

from __future__ import annotations

import math
import sys
from typing import TYPE_CHECKING, Any, NoReturn

from steadyload.engines.errors import BadNumberError

if TYPE_CHECKING:
    from steadyload.engines.capabilities import WorldSettings
    from steadyload.engines.world import Box

SIZES = (1e-6, 1e6)
"""Allowed edge lengths [m]."""

MASSES = (1e-12, 1e12)
"""Allowed masses [kg]."""

FARTHEST = 1e9
"""Allowed coordinates of a centre [m], to both sides of zero."""

REACH = 0.505
"""Allowed offset of a centre of mass along an axis, as a share of the edge. A half is inside; a
hundredth more is left because edges may have been drawn in after the centre of mass was placed."""

_LARGEST = sys.float_info.max
_BELOW_ONE = math.nextafter(1.0, 0.0)

_SETTINGS = {
    "friction": (0.0, _LARGEST, "a finite number, 0 or more"),
    "restitution": (0.0, 1.0, "0 to 1"),
    "linear_damping": (0.0, _BELOW_ONE, "0 to less than 1"),
    "angular_damping": (0.0, _BELOW_ONE, "0 to less than 1"),
    "margin": (0.0, _LARGEST, "a finite number, 0 or more [m]"),
}


def check_box(box: Box, index: int) -> None:
    """Refuse a box that no engine is to see.

    Args:
        box: as it was handed in.
        index: what it would be called in its world.

    Raises:
        BadNumberError: a size, mass, centre or offset that is not finite or out of range.
    """
    least, most = SIZES
    try:
        (x, y, z), (a, b, c), (p, q, r) = box.size, box.centre, box.mass_offset
        # One expression: this stands before every box of every world.
        if (
            least <= x <= most
            and least <= y <= most
            and least <= z <= most
            and MASSES[0] <= box.mass <= MASSES[1]
            and -FARTHEST <= a <= FARTHEST
            and -FARTHEST <= b <= FARTHEST
            and -FARTHEST <= c <= FARTHEST
            and -REACH * x <= p <= REACH * x
            and -REACH * y <= q <= REACH * y
            and -REACH * z <= r <= REACH * z
        ):
            return
    except (TypeError, ValueError):
        pass
    _refuse_box(box, f"box {index}")


def check_settings(settings: WorldSettings) -> None:
    """Refuse settings that no engine is to see.

    Raises:
        BadNumberError: a number that is not finite or out of range.
    """
    for name, (least, most, allowed) in _SETTINGS.items():
        value = getattr(settings, name)
        if not _is_within(value, least, most):
            raise BadNumberError(f"{name} is {value!r}; allowed: {allowed}")
    iterations = settings.solver_iterations
    counts = iterations is None or (_is_within(iterations, 1, _LARGEST) and iterations % 1 == 0)
    if not counts:
        raise BadNumberError(
            f"solver_iterations is {iterations!r}; allowed: None, or a whole number from 1 on"
        )
    if not _are_within(settings.gravity, -_LARGEST, _LARGEST):
        raise BadNumberError(f"gravity is {settings.gravity!r}; allowed: three finite numbers")


def _refuse_box(box: Box, where: str) -> NoReturn:
    for name, (least, most), unit in (
        ("size", SIZES, "m"),
        ("centre", (-FARTHEST, FARTHEST), "m"),
    ):
        if not _are_within(values := getattr(box, name), least, most):
            allowed = f"three numbers from {least:g} to {most:g} {unit}"
            raise BadNumberError(f"{where}: {name} is {values!r}; allowed: {allowed}")
    if not _is_within(box.mass, *MASSES):
        raise BadNumberError(
            f"{where}: mass is {box.mass!r}; allowed: {MASSES[0]:g} to {MASSES[1]:g} kg"
        )
    raise BadNumberError(
        f"{where}: mass_offset is {box.mass_offset!r}; allowed: inside the box, whose size is "
        f"{box.size!r} m"
    )


def _are_within(values: Any, least: float, most: float) -> bool:
    try:
        three: tuple[Any, ...] = tuple(values)
    except TypeError:
        return False
    return len(three) == 3 and all(_is_within(value, least, most) for value in three)


def _is_within(value: Any, least: float, most: float) -> bool:
    try:
        return bool(least <= value <= most)
    except (TypeError, ValueError):
        return False
