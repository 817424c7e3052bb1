"""States in which bodies are released: as measured in free flight, and moved within the noise."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from steadyload.engines.attitudes import lengths, rotate
from steadyload.engines.quantities import quantity
from steadyload.engines.world import GRAVITY, Box
from steadyload.measured.bodies import Body, Vector
from steadyload.measured.derived import spins, velocities
from steadyload.measured.errors import MotionError
from steadyload.measured.flight import flight_frames
from steadyload.measured.motion import FloatArray, Trial

CENTRED: Vector = (0.0, 0.0, 0.0)
"""The offset of a centre of mass in the middle of the body."""

_STRIDE = 0.002
"""Time between looks for a contact [s]."""

_ALIKE = 0.01
"""Share by which moments of inertia may differ for a body to turn as a cube does."""


@dataclass(frozen=True)
class Noise:
    """Standard deviations of a released state, along and about each axis.

    Attributes:
        position_m: of the centre of mass [m].
        attitude_deg: of a turn about each axis [degrees].
        velocity_ms: of the centre of mass [m/s].
        spin_rads: of the angular velocity [rad/s].
    """

    position_m: float = quantity(0.001, "of the centre of mass", unit="m", least=0, most=1)
    attitude_deg: float = quantity(0.7, "of a turn", unit="degrees", least=0, most=180)
    velocity_ms: float = quantity(0.02, "of the centre of mass", unit="m/s", least=0, most=10)
    spin_rads: float = quantity(0.3, "of the angular velocity", unit="rad/s", least=0, most=100)


@dataclass(frozen=True, eq=False)
class Release:
    """The state of a body at the first frame of a trial.

    Attributes:
        mass_centre: [m], shape (3,).
        attitude: unit quaternion w, x, y, z, from the body's axes to the world's, shape (4,).
        velocity: of the centre of mass, world axes [m/s], shape (3,).
        spin: angular velocity, world axes [rad/s], shape (3,).
    """

    mass_centre: FloatArray
    attitude: FloatArray
    velocity: FloatArray
    spin: FloatArray

    def box(self, body: Body, offset: Vector = CENTRED) -> Box:
        """The body as engines are given it.

        Args:
            body: its size and mass, and its moments of inertia where they are known.
            offset: centre of mass minus geometric centre, in the body's axes [m].

        Raises:
            MotionError: size or mass are not known.
        """
        if body.size is None or body.mass is None:
            raise MotionError(
                "size and mass of the body are not both known; allowed: a record that states them"
            )
        centre = self.mass_centre - rotate(self.attitude[None], np.array([offset]))[0]
        return Box(
            body.size,
            body.mass,
            _vector(centre),
            tuple(map(float, offset)),  # type: ignore[arg-type]
            attitude=tuple(self.attitude.tolist()),
            velocity=_vector(self.velocity),
            angular_velocity=_vector(self.spin),
            moments=body.inertia,
        )

    def flown(self, seconds: float, gravity: float = GRAVITY) -> Release:
        """The state after so much free flight of a body that turns as a cube does.

        Args:
            seconds: any number of them.
            gravity: downwards [m/s2].
        """
        fall = np.array((0.0, 0.0, -gravity))
        return Release(
            self.mass_centre + self.velocity * seconds + 0.5 * fall * seconds**2,
            turned(self.attitude, self.spin * seconds),
            self.velocity + fall * seconds,
            self.spin,
        )

    def moved(self, noise: Noise, factor: float, random: np.random.Generator) -> Release:
        """The state with normally distributed noise.

        Args:
            noise: its standard deviations.
            factor: that these are multiplied by, 0 or more.
            random: that twelve numbers are drawn from.
        """
        position, turn, velocity, spin = factor * random.standard_normal((4, 3))
        return Release(
            self.mass_centre + noise.position_m * position,
            turned(self.attitude, math.radians(noise.attitude_deg) * turn),
            self.velocity + noise.velocity_ms * velocity,
            self.spin + noise.spin_rads * spin,
        )


def release(trial: Trial, offset: Vector = CENTRED, gravity: float = GRAVITY) -> Release:
    """The state at the first frame, by least squares over all frames of free flight.

    The centre of mass moves on a parabola. A body with equal moments of inertia turns at one rate:
    the mean of the measured ones, and its attitude is the mean of the attitudes, each turned back
    to the first frame. Of another body both are those of the first frame.

    Args:
        trial: of a body whose size is known.
        offset: centre of mass minus geometric centre, in the body's axes [m].
        gravity: downwards [m/s2].

    Raises:
        MotionError: see :func:`steadyload.measured.flight.flight_frames`.
    """
    count = flight_frames(trial)
    times = trial.times[:count] - trial.times[0]
    turns = trial.attitudes[:count] / lengths(trial.attitudes[:count])[:, None]
    centres = trial.positions[:count] + rotate(turns, np.tile(offset, (count, 1)))
    centres[:, 2] += 0.5 * gravity * times**2
    lines = np.stack([np.ones(count), times], axis=1)
    (start, velocity), *_ = np.linalg.lstsq(lines, centres, rcond=None)
    rates = rotate(turns, spins(trial)[:count])
    if not turns_as_a_cube(trial.body):
        return Release(start, turns[0], velocity, rates[0])
    spin = rates.mean(axis=0)
    back = np.array([turned(q, -spin * t) for q, t in zip(turns, times, strict=True)])
    back[back @ turns[0] < 0.0] *= -1.0
    mean = back.sum(axis=0)
    return Release(start, mean / np.linalg.norm(mean), velocity, spin)


def first_frame(trial: Trial) -> Release:
    """The state at the first frame as it is recorded, of a body whose centre of mass is its middle.

    Velocities are those that are given, or else of the differences between frames.
    """
    attitude = trial.attitudes[0] / np.linalg.norm(trial.attitudes[0])
    spin = rotate(attitude[None], spins(trial)[:1])[0]
    return Release(trial.positions[0], attitude, velocities(trial)[0], spin)


def departure(
    trial: Trial, start: Release, offset: Vector = CENTRED, gravity: float = GRAVITY
) -> float:
    """Largest distance of the recorded centre from free flight, before the first contact [m].

    Args:
        trial: of a body whose size is known.
        start: its release.
        offset: with which that was found.
        gravity: likewise [m/s2].
    """
    count = flight_frames(trial)
    turns = trial.attitudes[:count] / lengths(trial.attitudes[:count])[:, None]
    flights = [start.flown(t, gravity).mass_centre for t in trial.times[:count] - trial.times[0]]
    centres = np.array(flights) - rotate(turns, np.tile(offset, (count, 1)))
    return float(lengths(trial.positions[:count] - centres).max())


def landed(start: Release, size: Vector, offset: Vector = CENTRED) -> Release:
    """The state at which a body that flies freely touches the floor.

    Args:
        start: its release, above the floor.
        size: its sides [m].
        offset: centre of mass minus geometric centre, in the body's axes [m].
    """
    corners = 0.5 * np.array(size) * (2.0 * np.array(list(np.ndindex(2, 2, 2))) - 1.0) - offset

    def height(seconds: float) -> float:
        state = start.flown(seconds)
        turns = np.tile(state.attitude, (8, 1))
        return float((state.mass_centre + rotate(turns, corners))[:, 2].min())

    later = 0.0
    while height(later) > 0.0:
        later += _STRIDE
    return start.flown(float(brentq(height, later - _STRIDE, later)) if later else 0.0)


def turns_as_a_cube(body: Body) -> bool:
    """Whether all moments of inertia are equal, so that free rotation is at one rate."""
    moments = body.inertia
    if moments is None:
        if body.size is None:
            return False
        x, y, z = (side * side for side in body.size)
        moments = (y + z, x + z, x + y)
    return max(moments) <= (1.0 + _ALIKE) * min(moments)


def turned(attitude: FloatArray, vector: FloatArray) -> FloatArray:
    """An attitude after a turn about axes of the world.

    Args:
        attitude: unit quaternion w, x, y, z, shape (4,).
        vector: the axis of the turn, as long as its angle [rad], shape (3,).
    """
    angle = float(np.linalg.norm(vector))
    x, y, z = 0.5 * np.sinc(0.5 * angle / math.pi) * vector
    w = math.cos(0.5 * angle)
    a, b, c, d = attitude
    return np.array(
        (
            w * a - x * b - y * c - z * d,
            w * b + x * a + y * d - z * c,
            w * c + y * a + z * b - x * d,
            w * d + z * a + x * c - y * b,
        )
    )


def _vector(values: FloatArray) -> Vector:
    x, y, z = map(float, values)
    return x, y, z
