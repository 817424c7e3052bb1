"""How far items will have moved by the end of a placement, foreseen from how they have moved."""

from __future__ import annotations

import numpy as np

from steadyload.engines.world import FloatArray

VERSION = 1
"""Of what is foreseen: raised when placements end at other times."""

_FIRST, _FIRST_SHARE = 0.055, 0.1
"""Contacts take the weight of what is placed in this time [s], or in this share of a placement
where that is less; movements over less are not compared."""

_PARTS = 4
"""Movements are compared over a quarter of the time since then."""

_CREEP, _TIP = 2e-5, 5e-4
"""Slowest movement of which it matters that it becomes faster: a speed [m/s], and what is added to
it a second [m/s2]. A pile 2 m high that is 0.1 mm past its point of balance begins with three times
as much."""

_MOST_GROWTH = 40.0
"""Of the exponent: what grows by more is far beyond every threshold."""


class Foresight:
    """Foresees how far items will have moved by the end of a placement.

    An item goes on as fast as it moves, or, where it becomes faster, as something that tips: faster
    by the same factor in equal times. So a box just past its point of balance is never taken for
    one at rest, however little it has moved.

    Args:
        share: of what is left to every threshold; see :meth:`is_safe`.
        end: duration of a placement [s].
        eps_t: displacement that is one threshold [m].
    """

    def __init__(self, share: float, end: float, eps_t: float) -> None:
        self._share, self._end, self._eps_t = share, end, max(eps_t, 1e-12)
        self._least = min(_FIRST, _FIRST_SHARE * end)
        self._times = [0.0]
        self._looks: list[FloatArray] = []

    def is_safe(self, time: float, moved: FloatArray) -> bool:
        """Take in a look: whether no item comes near a threshold in the time that is left.

        What is to come must be at most the share of what is left to the threshold, for every item.

        Args:
            time: since the placement, longer than at the look before [s].
            moved: displacement of each item along three axes, and its rotation about them, in units
                of their thresholds, shape (n, 6).
        """
        if not self._looks:
            self._looks.append(np.zeros_like(moved))
        self._times.append(time)
        self._looks.append(moved)
        apart = max(self._least, (time - self._least) / _PARTS)
        now = len(self._times) - 1
        middle = self._last_by(time - apart)
        first = self._last_by(self._times[middle] - apart)
        if self._times[first] < self._least - 1e-9:
            return False
        speed, earlier = self._speed(middle, now), self._speed(first, middle)
        slowest = (_CREEP + _TIP * self._times[middle]) / self._eps_t
        between = 0.5 * (time - self._times[first])
        growth = np.log(np.maximum(speed, slowest) / np.maximum(earlier, slowest)) / between
        left = self._end - time
        exponent = np.clip(growth * left, 1e-9, _MOST_GROWTH)
        to_come = speed * left * np.expm1(exponent) / exponent
        return bool((to_come <= self._share * (1.0 - _furthest(moved))).all())

    def _last_by(self, time: float) -> int:
        """The last look that was no later; the start where none was."""
        return max(0, int(np.searchsorted(self._times, time + 1e-9, side="right")) - 1)

    def _speed(self, first: int, last: int) -> FloatArray:
        """Of every item between two looks [thresholds a second], shape (n,)."""
        moved = _furthest(self._looks[last] - self._looks[first])
        speed: FloatArray = moved / (self._times[last] - self._times[first])
        return speed


def _furthest(moved: FloatArray) -> FloatArray:
    """The larger of displacement and rotation of every item, shape (n,)."""
    squares = (moved * moved).reshape(-1, 2, 3).sum(axis=2)
    furthest: FloatArray = np.sqrt(squares.max(axis=1))
    return furthest
