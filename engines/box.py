"""A rigid box as engines are given it, and the limits of what may reach one.

The limits are far from anything that is judged. They are there so that squares and products of what
is allowed stay positive and finite, as moments of inertia must.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from steadyload.engines.attitudes import rotate
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

FASTEST = 1e6
"""Allowed parts of a velocity [m/s] and of an angular velocity [rad/s], to both sides of zero."""

HOLLOW = (1e-3, 1.0)
"""Allowed moments of inertia, as shares of what all mass in the corners would have."""

_ROUNDING = 1e-3
"""Share by which stated moments may be off for the digits that were written."""

UNIT = 1e-6
"""Allowed difference of the length of an attitude from 1; it is scaled to 1."""

UPRIGHT = (1.0, 0.0, 0.0, 0.0)
AT_REST = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Box:
    """One rigid box, of uniform density about a shifted centre of mass unless moments are stated.

    Args:
        size: full edge lengths along its own axes [m], which are those of the world unless it is
            turned; all positive.
        mass: [kg], positive.
        centre: planned position of the geometric centre [m].
        mass_offset: centre of mass minus geometric centre in its own axes [m], inside the box.
        fixed: part of the surroundings: it carries and stops others and never moves.
        attitude: planned unit quaternion (w, x, y, z), by which it is turned.
        velocity: of the centre of mass, at the start, in axes of the world [m/s].
        angular_velocity: at the start, in axes of the world [rad/s].
        moments: of inertia about its own axes through its centre of mass [kg m2], where these are
            known; None for those of uniform density.
    """

    size: tuple[float, float, float]
    mass: float
    centre: tuple[float, float, float]
    mass_offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    fixed: bool = False
    attitude: tuple[float, float, float, float] = UPRIGHT
    velocity: tuple[float, float, float] = AT_REST
    angular_velocity: tuple[float, float, float] = AT_REST
    moments: tuple[float, float, float] | None = None

    @property
    def launched(self) -> bool:
        """Whether it starts otherwise than upright and at rest."""
        return self.attitude != UPRIGHT or self.in_motion

    @property
    def in_motion(self) -> bool:
        """Whether it starts with a velocity."""
        return self.velocity != AT_REST or self.angular_velocity != AT_REST

    @property
    def unit_attitude(self) -> tuple[float, float, float, float]:
        """The attitude, of length 1 to the last bits."""
        if self.attitude == UPRIGHT:
            return UPRIGHT
        (w, x, y, z), length = self.attitude, math.hypot(*self.attitude)
        return (w / length, x / length, y / length, z / length)

    @property
    def mass_centre(self) -> tuple[float, float, float]:
        """Planned position of the centre of mass [m]."""
        (a, b, c), (p, q, r) = self.centre, self.mass_offset
        if self.attitude != UPRIGHT:
            p, q, r = rotate(np.array([self.unit_attitude]), np.array([(p, q, r)]))[0].tolist()
        return (a + p, b + q, c + r)

    @property
    def inertia(self) -> tuple[float, float, float]:
        """Principal moments about the centre of mass [kg m2]: as stated, or of the uniform box.

        All engines are given the same moments wherever the centre of mass lies, so that they
        answer the same question; a shifted centre alone does not define an inertia.
        """
        if self.moments is not None:
            return self.moments
        x, y, z = self.size
        twelfth = self.mass / 12.0
        return (twelfth * (y * y + z * z), twelfth * (x * x + z * z), twelfth * (x * x + y * y))


def shrink_of(size: tuple[float, float, float], most: float) -> float:
    """By how much an engine draws side faces in [m]: so far, and a thousandth of a side, at most.

    Args:
        size: edge lengths [m].
        most: how far at most [m].
    """
    return min(most, 1e-3 * size[0], 1e-3 * size[1])


def drawn_in(size: tuple[float, float, float], shrink: float) -> tuple[float, float, float]:
    """Edge lengths of a box whose four side faces are drawn in, so that neighbours do not touch."""
    x, y, z = size
    return x - 2.0 * shrink, y - 2.0 * shrink, z


def check_box(box: Box, index: int) -> None:
    """Refuse a box that is outside the limits of all engines.

    Args:
        box: as it was handed in.
        index: what it would be called in its world.

    Raises:
        BadNumberError: a size, mass, centre, offset, attitude, velocity or moment of inertia that
            is not finite or out of range.
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
            and (not box.launched or _may_start(box))
            and (box.moments is None or _may_turn(box))
        ):
            return
    except (TypeError, ValueError):
        pass
    _refuse_box(box, f"box {index}")


def _is_unit(attitude: tuple[float, ...]) -> bool:
    try:
        return len(attitude) == 4 and is_within(math.hypot(*attitude), 1.0 - UNIT, 1.0 + UNIT)
    except TypeError:
        return False


def _most_moments(box: Box) -> tuple[float, float, float]:
    """Moments with all of the mass in the corners [kg m2]."""
    x, y, z = Box(box.size, box.mass, box.centre).inertia
    return (3.0 * x, 3.0 * y, 3.0 * z)


def _may_turn(box: Box) -> bool:
    """Whether some body of this size and mass has the stated moments."""
    least, most = HOLLOW
    try:
        x, y, z = box.moments or box.inertia
        return all(
            is_within(moment, least * bound, (most + _ROUNDING) * bound)
            for moment, bound in zip((x, y, z), _most_moments(box), strict=True)
        ) and 2.0 * max(x, y, z) <= (1.0 + _ROUNDING) * (x + y + z)
    except (TypeError, ValueError):
        return False


def _may_start(box: Box) -> bool:
    fastest = 0.0 if box.fixed else FASTEST
    motion = (box.velocity, box.angular_velocity)
    return _is_unit(box.attitude) and all(are_within(v, -fastest, fastest) for v in motion)


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
    if _may_start(box) and not _may_turn(box):
        bounds = ", ".join(
            f"{HOLLOW[0] * m:.3g} to {HOLLOW[1] * m:.3g}" for m in _most_moments(box)
        )
        raise BadNumberError(
            f"{where}: moments is {box.moments!r}; allowed: None, or three numbers of {bounds} "
            "kg m2, of which none is more than the sum of the others"
        )
    if _may_start(box):
        raise BadNumberError(
            f"{where}: mass_offset is {box.mass_offset!r}; allowed: inside the box, whose size is "
            f"{box.size!r} m"
        )
    if not _is_unit(box.attitude):
        raise BadNumberError(
            f"{where}: attitude is {box.attitude!r}; allowed: four numbers w, x, y, z, whose "
            f"length differs from 1 by at most {UNIT:g}"
        )
    for name, unit in (("velocity", "m/s"), ("angular_velocity", "rad/s")):
        value = getattr(box, name)
        if not are_within(value, -FASTEST, FASTEST):
            allowed = f"three numbers from {-FASTEST:g} to {FASTEST:g} {unit}"
            raise BadNumberError(f"{where}: {name} is {value!r}; allowed: {allowed}")
    raise BadNumberError(
        f"{where}: velocities are {box.velocity!r} and {box.angular_velocity!r}; allowed: zeros, "
        "as it is fixed"
    )
