"""Histories of a horizontal acceleration, or of a tilt: what a load is put through."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from steadyload.escaping import shown
from steadyload.layouts.model.checks import is_number
from steadyload.numbers import number_within
from steadyload.reading import MAX_HISTORY_BYTES, content_of
from steadyload.transport.errors import TransportError

_HALF_SINE_POINTS = 65

_COLUMNS = ("time_s", "acceleration_g")

STEEPEST = 20.0
"""Largest acceleration of a history [g], either way."""

LONGEST = 600.0
"""Longest history [s]."""


@dataclass(frozen=True)
class History:
    """An acceleration over time, linear between points; 0 after the last one.

    Attributes:
        times: rising, from 0 [s].
        levels: accelerations then [g].
        tilted: the deck is tilted until the load feels these, instead of being accelerated:
            gravity keeps its size and turns.

    Raises:
        TransportError: fewer than two points, times that do not rise from 0, or a number that is
            out of range.
    """

    times: tuple[float, ...]
    levels: tuple[float, ...]
    tilted: bool = False

    def __post_init__(self) -> None:
        if len(self.times) < 2 or len(self.times) != len(self.levels):
            raise TransportError(
                f"a history of {len(self.times)} times and {len(self.levels)} accelerations; "
                "allowed: 2 or more points"
            )
        for value in (*self.times, *self.levels):
            if not is_number(value):
                raise TransportError(f"a history holds {shown(value)}; allowed: numbers")
        if self.times[0] != 0.0 or not all(a < b for a, b in pairwise(self.times)):
            raise TransportError("times of a history do not rise from 0 s")
        if not self.times[-1] <= LONGEST:
            raise TransportError(f"a history of {self.times[-1]:g} s; allowed: up to {LONGEST:g} s")
        for level in self.levels:
            if not abs(level) <= STEEPEST:
                raise TransportError(
                    f"an acceleration of {level:g} g; allowed: -{STEEPEST:g} to {STEEPEST:g}"
                )

    @property
    def duration(self) -> float:
        """Time of the last point [s]."""
        return self.times[-1]

    def mean(self, start: float, span: float) -> float:
        """The mean acceleration from a time on, over a span [s, s; g]: it has the same impulse."""
        times, end = np.asarray(self.times), start + span
        bends = times[(times > start) & (times < end)]
        if not len(bends):
            middle = start + 0.5 * span
            return float(np.interp(middle, times, self.levels, right=0.0))
        corners = np.clip(np.array([start, *bends, end]), 0.0, self.duration)
        return float(np.trapezoid(np.interp(corners, times, self.levels), corners)) / span

    def gravity(
        self, start: float, span: float, direction_deg: float, gravity: float
    ) -> tuple[float, ...]:
        """Gravity and acceleration that the boxes feel, in the frame of the deck [m/s2].

        Args:
            start: of the time over which it is the mean [s].
            span: length of that time [s].
            direction_deg: of the force on the boxes, seen from above: 0 along the layout's width,
                90 along its depth.
            gravity: [m/s2].

        Returns:
            Along the layout's width, its height and its depth.
        """
        level = self.mean(start, span)
        down = 1.0
        if self.tilted:
            down = 1.0 / math.hypot(1.0, level)
            level *= down
        angle = math.radians(direction_deg)
        across, along = level * math.cos(angle), level * math.sin(angle)
        return gravity * across, -gravity * down, gravity * along


def constant(level: float, hold: float) -> History:
    """An acceleration from one moment to another [g, s]."""
    return trapezoid(level, 0.0, hold)


def trapezoid(level: float, rise: float, hold: float, *, tilted: bool = False) -> History:
    """An acceleration that rises evenly, is held, and ends at once [g, s, s].

    Raises:
        TransportError: a number is not finite or out of range.
    """
    rise = number_within("rise", rise, 0.0, unit="[s]", error=TransportError)
    hold = number_within("hold", hold, 0.0, unit="[s]", error=TransportError)
    if not rise:
        return History((0.0, hold), (level, level), tilted)
    return History((0.0, rise, rise + hold), (0.0, level, level), tilted)


def half_sine(peak: float, duration: float) -> History:
    """Half a period of a sine [g, s]."""
    shares = np.linspace(0.0, 1.0, _HALF_SINE_POINTS)
    levels = peak * np.sin(np.pi * shares)
    return History(tuple((duration * shares).tolist()), tuple(levels.tolist()))


def recorded(path: Path) -> History:
    """A history from a CSV file with the columns ``time_s`` and ``acceleration_g``.

    Raises:
        TransportError: it cannot be read: says where and what is allowed.
        TooLargeError: it has too many bytes.
    """
    times, levels = [], []
    try:
        text = content_of(path, MAX_HISTORY_BYTES).decode("utf-8-sig")
        with io.StringIO(text, newline="") as file:
            rows = csv.reader(file)
            header = next(rows, [])
            if any(header.count(name) != 1 for name in _COLUMNS):
                raise TransportError(
                    f"{path}: columns are {shown(header)}; allowed: {' and '.join(_COLUMNS)}, once"
                )
            first, second = (header.index(name) for name in _COLUMNS)
            for cells in rows:
                if not cells:
                    continue
                try:
                    if len(cells) != len(header):
                        raise ValueError
                    times.append(float(cells[first]))
                    levels.append(float(cells[second]))
                except ValueError:
                    raise TransportError(
                        f"{path}: line {rows.line_num} is {shown(cells)}; "
                        f"allowed: {len(header)} cells, of them seconds and g"
                    ) from None
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise TransportError(f"{path}: cannot be read ({error})") from None
    try:
        return History(tuple(times), tuple(levels))
    except TransportError as error:
        raise TransportError(f"{path}: {error}") from None
