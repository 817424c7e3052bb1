"""Recorded motion of one rigid body over a level floor: a trial."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steadyload.engines.attitudes import lengths, rotate
from steadyload.escaping import shown
from steadyload.layouts.files.limits import MAX_TEXT_LENGTH
from steadyload.measured.bodies import Body
from steadyload.measured.errors import MotionError

FloatArray = NDArray[np.float64]

FEWEST = 3
"""Frames of a trial, at least: velocities by differences need as many."""

UNIT = 1e-3
"""By how much the length of a quaternion may differ from 1."""

FARTHEST, FASTEST, SPINNING = 1e3, 100.0, 1e3
"""Largest coordinate [m], speed [m/s] and angular speed [rad/s]."""

LATEST = 1e7
"""Largest time, either way [s]."""

SHORTEST, LONGEST = 1e-5, 10.0
"""Time between a frame and the next one [s]."""

LONGEST_TRIAL = 600.0
"""Time from the first frame of a trial to the last [s]."""

SUNK = 0.25, 0.005
"""Depth below the floor that a corner may have for errors of tracking: a share of the longest side,
and a length [m]."""

_FACTOR = 10.0
"""By how much stated velocities may move a body farther, or less far, than its positions do."""

_MOVED, _TURNED = 0.05, 1.0
"""Ways from which on velocities are compared with positions [m, rad]."""

COLUMNS = {
    "positions": ("x", "y", "z"),
    "attitudes": ("qw", "qx", "qy", "qz"),
    "velocities": ("vx", "vy", "vz"),
    "spins": ("wx", "wy", "wz"),
}
"""Array of a trial -> names of its columns in files."""

_RANGES = {
    "positions": (FARTHEST, "m"),
    "attitudes": (1.0 + UNIT, ""),
    "velocities": (FASTEST, "m/s"),
    "spins": (SPINNING, "rad/s"),
}


@dataclass(frozen=True, eq=False)
class Trial:
    """One body from the first frame that was recorded to the last. Arrays are read-only.

    World axes: z up, the floor is the plane z = 0. The body's own axes are along its sides.

    Attributes:
        name: printable, not empty.
        times: rising [s], shape (n,).
        positions: of the centre [m], shape (n, 3).
        attitudes: unit quaternions w, x, y, z, from the body's axes to the world's, shape (n, 4).
        velocities: of the centre, world axes [m/s], shape (n, 3); None where they were not given.
        spins: angular velocities in the *body's* axes, as a gyroscope on it measures them [rad/s],
            shape (n, 3); None where they were not given.
        body: what is known of it.

    Raises:
        MotionError: a shape, a number, a time, a gap between frames or a length of a quaternion
            that is not allowed, too few frames, too long a trial, a body below the floor, or
            velocities that do not fit the positions.
    """

    name: str
    times: FloatArray
    positions: FloatArray
    attitudes: FloatArray
    velocities: FloatArray | None = None
    spins: FloatArray | None = None
    body: Body = field(default_factory=Body)

    def __post_init__(self) -> None:
        if not (
            isinstance(self.name, str)
            and self.name.strip()
            and self.name.isprintable()
            and len(self.name) <= MAX_TEXT_LENGTH
        ):
            raise MotionError(f"a trial is called {shown(self.name)}; allowed: a printable name")
        try:
            self._check()
        except MotionError as error:
            raise MotionError(f"trial {shown(self.name)}{error}") from None

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.times)

    @property
    def corners(self) -> FloatArray | None:
        """Corners of the body in the world [m], shape (n, 8, 3); None without its size."""
        if self.body.size is None:
            return None
        return np.stack([self._corner(signs) for signs in np.ndindex(2, 2, 2)], axis=1)

    @property
    def world_spins(self) -> FloatArray | None:
        """Angular velocities in the world's axes, as engines take them [rad/s], shape (n, 3)."""
        return None if self.spins is None else rotate(self._unit(), self.spins)

    def _corner(self, signs: tuple[int, ...]) -> FloatArray:
        half = 0.5 * np.array(self.body.size) * (2.0 * np.array(signs) - 1.0)
        return self.positions + rotate(self._unit(), np.tile(half, (len(self), 1)))

    def _unit(self) -> FloatArray:
        return self.attitudes / lengths(self.attitudes)[:, None]

    def _check(self) -> None:
        times = _array(self.times, "times", ())
        if len(times) < FEWEST:
            raise MotionError(f" has {len(times)} frames; allowed: {FEWEST} or more")
        _refuse(np.isfinite(times) & (abs(times) <= LATEST), times, "time", LATEST, "s")
        late = np.flatnonzero(np.diff(times) <= 0.0)
        if len(late):
            k = int(late[0]) + 1
            twice = (
                "stands there twice" if times[k] == times[k - 1] else f"follows {times[k - 1]:g}"
            )
            raise MotionError(
                f", frame {k}: time {times[k]:g} {twice}; allowed: times that rise [s]"
            )
        _check_spans(times)
        object.__setattr__(self, "times", times)
        for key, names in COLUMNS.items():
            given = getattr(self, key)
            if given is not None:
                array = _array(given, key, (len(names),), len(times))
                most, unit = _RANGES[key]
                for name, column in zip(names, array.T, strict=True):
                    _refuse(np.isfinite(column) & (abs(column) <= most), column, name, most, unit)
                object.__setattr__(self, key, array)
        norms = lengths(self.attitudes)
        wrong = np.flatnonzero(abs(norms - 1.0) > UNIT)
        if len(wrong):
            raise MotionError(
                f", frame {wrong[0]}: its quaternion has the length {norms[wrong[0]]:.4g}; "
                f"allowed: 1, to within {UNIT:g}"
            )
        self._check_steps()
        self._check_floor()
        self._check_velocities()

    def _check_steps(self) -> None:
        """Positions that jump were in another unit, or are of another body."""
        speeds = lengths(np.diff(self.positions, axis=0)) / np.diff(self.times)
        fast = np.flatnonzero(speeds > FASTEST)
        if len(fast):
            raise MotionError(
                f", frame {fast[0] + 1}: has moved at {speeds[fast[0]]:.3g} m/s since the frame "
                f"before; allowed: up to {FASTEST:g} m/s, positions in m and times in s"
            )

    def _check_floor(self) -> None:
        corners, size = self.corners, self.body.size
        if corners is None or size is None:
            return
        lowest = corners[:, :, 2].min(axis=1)
        share, length = SUNK
        most = share * max(size) + length
        deep = np.flatnonzero(lowest < -most)
        if len(deep):
            raise MotionError(
                f", frame {deep[0]}: its lowest corner is {-lowest[deep[0]]:.3g} m below the "
                f"floor; allowed: up to {most:.3g} m, sizes and positions in m, z up, floor z = 0"
            )

    def _check_velocities(self) -> None:
        """Velocities in another unit move a body by other ways than its positions do."""
        spans = np.diff(self.times)
        if self.velocities is not None:
            steps = 0.5 * (self.velocities[1:] + self.velocities[:-1]) * spans[:, None]
            stated = float(lengths(np.cumsum(steps, axis=0)).max())
            seen = float(lengths(self.positions - self.positions[0]).max())
            if max(stated, seen) > _MOVED and max(stated, seen) > _FACTOR * min(stated, seen):
                raise MotionError(
                    f": its velocities move it by {stated:.3g} m, its positions by {seen:.3g} m; "
                    f"allowed: to within a factor of {_FACTOR:g}, positions in m and velocities in "
                    "m/s"
                )
        if self.spins is not None:
            speeds = lengths(self.spins)
            stated = float((0.5 * (speeds[1:] + speeds[:-1]) * spans).sum())
            unit = self._unit()
            alike = np.minimum(1.0, abs((unit[1:] * unit[:-1]).sum(axis=1)))
            seen = float(2.0 * np.arccos(alike).sum())
            if stated > _TURNED and stated > _FACTOR * seen:
                raise MotionError(
                    f": its angular velocities turn it by {stated:.3g} rad, its attitudes by "
                    f"{seen:.3g} rad; allowed: up to {_FACTOR:g} times as much, in rad/s"
                )


def _check_spans(times: FloatArray) -> None:
    """An engine would simulate long gaps in one call, and short ones in many."""
    spans = np.diff(times)
    odd = np.flatnonzero((spans < SHORTEST) | (spans > LONGEST))
    if len(odd):
        raise MotionError(
            f", frame {odd[0] + 1}: is {spans[odd[0]]:g} s after the one before; allowed: "
            f"{SHORTEST:g} to {LONGEST:g} s, times in s"
        )
    lasts = times[-1] - times[0]
    if lasts > LONGEST_TRIAL:
        raise MotionError(f": lasts {lasts:g} s; allowed: up to {LONGEST_TRIAL:g} s, times in s")


def _array(
    values: ArrayLike, name: str, shape: tuple[int, ...], count: int | None = None
) -> FloatArray:
    """A read-only copy of an array of so many rows; any number of them where none is said."""
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise MotionError(f": {name} are no numbers; allowed: an array of numbers") from None
    if array.ndim != 1 + len(shape) or array.shape[1:] != shape or count not in (None, len(array)):
        wanted = ", ".join(map(str, ("n" if count is None else count, *shape)))
        raise MotionError(f": {name} have the shape {array.shape}; allowed: ({wanted})")
    array.setflags(write=False)
    return array


def _refuse(
    allowed: NDArray[np.bool_], values: FloatArray, name: str, most: float, unit: str
) -> None:
    """Refuse the first of the numbers that is not allowed."""
    wrong = np.flatnonzero(~allowed)
    if len(wrong):
        raise MotionError(
            f", frame {wrong[0]}: {name} is {values[wrong[0]]:g}; allowed: a finite number, "
            f"{-most:g} to {most:g}{unit and f' [{unit}]'}"
        )
