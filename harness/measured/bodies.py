"""The body of a trial: a box, as far as it is known."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from steadyload.escaping import shown
from steadyload.measured.errors import MotionError
from steadyload.numbers import number_within

Vector = tuple[float, float, float]

SIDES = (1e-3, 20.0)
"""Sides of a body [m]."""

MASSES = (1e-6, 1e5)
"""Masses of a body [kg]."""

DENSITIES = (1.0, 23_000.0)
"""Mean densities of a body [kg/m3]: from that of air to that of osmium."""

MOST_FRICTION = 10.0

_ROUNDING = 1e-3
"""Share by which stated moments of inertia may be off for the digits that were written."""


@dataclass(frozen=True, kw_only=True)
class Body:
    """A rigid box whose centre of mass is its geometric centre; None for what is not known.

    Attributes:
        size: along its own x, y and z [m].
        mass: [kg].
        inertia: moments of inertia about its own axes through its centre [kg m2].
        friction: Coulomb coefficient on the floor, 0 or more.
        restitution: coefficient of an impact on the floor, 0 to 1.

    Raises:
        MotionError: a number that is not finite or out of range, a mass that does not fit the size,
            or moments of inertia that no such body has.
    """

    size: Vector | None = None
    mass: float | None = None
    inertia: Vector | None = None
    friction: float | None = None
    restitution: float | None = None

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        if self.size is not None:
            set_(self, "size", _three("size", self.size, *SIDES, "[m]"))
        if self.mass is not None:
            set_(self, "mass", _within("mass", self.mass, *MASSES, "[kg]"))
        if self.inertia is not None:
            set_(self, "inertia", _three("inertia", self.inertia, 1e-15, 1e8, "[kg m2]"))
            self._check_inertia(*self.inertia)
        if self.friction is not None:
            set_(self, "friction", _within("friction", self.friction, 0.0, MOST_FRICTION))
        if self.restitution is not None:
            set_(self, "restitution", _within("restitution", self.restitution, 0.0, 1.0))
        self._check_density()

    def _check_density(self) -> None:
        if self.size is None or self.mass is None:
            return
        width, depth, height = self.size
        density = self.mass / (width * depth * height)
        least, most = DENSITIES
        if not least <= density <= most:
            raise MotionError(
                f"a mass of {self.mass:g} kg in {width:g} x {depth:g} x {height:g} m is "
                f"{density:.3g} kg/m3; allowed: {least:g} to {most:,.0f}, sizes in m and masses in "
                "kg"
            )

    def _check_inertia(self, *moments: float) -> None:
        largest = max(moments)
        if largest > (sum(moments) - largest) * (1.0 + _ROUNDING):
            raise MotionError(
                f"moments of inertia are {_listed(moments)} kg m2, of which one is more than the "
                "sum of the others; allowed: at most that sum, which no body exceeds"
            )
        if self.size is None or self.mass is None:
            return
        squares = [side * side for side in self.size]
        # All of the mass in the corners of the box.
        bounds = [0.25 * self.mass * (sum(squares) - own) for own in squares]
        for axis, moment, bound in zip("xyz", moments, bounds, strict=True):
            if moment > bound * (1.0 + _ROUNDING):
                raise MotionError(
                    f"inertia_{axis} is {moment:g}; allowed: up to {bound:.3g} [kg m2], which a "
                    "box of this size and mass has with all mass in its corners"
                )


def _three(name: str, values: object, least: float, most: float, unit: str) -> Vector:
    if isinstance(values, str) or not isinstance(values, Collection) or len(values) != 3:
        raise MotionError(f"{name} is {shown(values)}; allowed: three numbers {unit}")
    x, y, z = (
        _within(f"{name}_{axis}", value, least, most, unit)
        for axis, value in zip("xyz", values, strict=True)
    )
    return x, y, z


def _within(name: str, value: object, least: float, most: float, unit: str = "") -> float:
    return number_within(name, value, least, most, unit=unit, error=MotionError)


def _listed(numbers: Sequence[float]) -> str:
    return ", ".join(f"{number:g}" for number in numbers)
