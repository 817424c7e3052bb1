"""A rigid box as engines are given it, and the limits of what may reach one.

The limits are far from anything that is judged. They are there so that squares and products of what
is allowed stay positive and finite, as moments of inertia must.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NoReturn

from steadyload.engines.errors import BadNumberError
from steadyload.engines.limits import are_within, is_within

SIZES = (1e-6, 1e6)
"""Allowed edge lengths [m]."""

MASSES = (1e-12, 1e12)
"""Allowed masses [kg]."""

FARTHEST = 1e9
"""Allowed coordinates of a centre [m], to both sides of zero."""

REACH = 0.505
"""Allowed offset of a centre of mass along an axis, as a share of the edge. A half is inside; a
hundredth more is left because edges may have been drawn in after the centre of mass was placed."""


@dataclass(frozen=True, slots=True)
class Box:
    """One rigid box of uniform density about a shifted centre of mass.

    Args:
        size: full edge lengths along the world's x, y, z [m], all positive.
        mass: [kg], positive.
        centre: planned position of the geometric centre [m].
        mass_offset: centre of mass minus geometric centre [m], inside the box.
        fixed: part of the surroundings: it carries and stops others and never moves.
    """

    size: tuple[float, float, float]
    mass: float
    centre: tuple[float, float, float]
    mass_offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    fixed: bool = False

    @property
    def inertia(self) -> tuple[float, float, float]:
        """Principal moments of the uniform box [kg m2], taken about the centre of mass.

        All engines are given the same moments wherever the centre of mass lies, so that they
        answer the same question; a shifted centre alone does not define an inertia.
        """
        x, y, z = self.size
        twelfth = self.mass / 12.0
        return (twelfth * (y * y + z * z), twelfth * (x * x + z * z), twelfth * (x * x + y * y))


def check_box(box: Box, index: int) -> None:
    """Refuse a box that is outside the limits of all engines.

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


def _refuse_box(box: Box, where: str) -> NoReturn:
    for name, (least, most), unit in (
        ("size", SIZES, "m"),
        ("centre", (-FARTHEST, FARTHEST), "m"),
    ):
        if not are_within(values := getattr(box, name), least, most):
            allowed = f"three numbers from {least:g} to {most:g} {unit}"
            raise BadNumberError(f"{where}: {name} is {values!r}; allowed: {allowed}")
    if not is_within(box.mass, *MASSES):
        raise BadNumberError(
            f"{where}: mass is {box.mass!r}; allowed: {MASSES[0]:g} to {MASSES[1]:g} kg"
        )
    raise BadNumberError(
        f"{where}: mass_offset is {box.mass_offset!r}; allowed: inside the box, whose size is "
        f"{box.size!r} m"
    )
