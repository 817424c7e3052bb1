"""Motion of a group of items that lost its balance, over a given time: a model, no simulation.

Rigid items, contacts that neither stretch nor give. The model goes from event to event:

- At every event the group is at rest, and its accelerations follow from Gauss' principle of least
  constraint, as the residue of one non-negative least-squares problem for the contact forces
  (pyramids instead of friction cones).
- Until the next event, the items that push each other go on as one pendulum does: with the
  direction of their motion fixed, the way s along it obeys s'' = 1 + k2 s, where k2 is how fast the
  levers of the weights grow along that motion (below 0 they shrink). For one box that tips over an
  edge this is the equation of the inverted pendulum, (r2 + d2 + h2) a'' = g (d + h a): the centre
  of mass d past the edge and h above it, radius of gyration r, angle a below some 20 degrees.
- An event is a gap that closes; it takes all speed away. Plastic impacts that keep what speed they
  may were tried: friction cones let bodies take off there, and fewer verdicts were right.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from steadyload.core.constants import AT_REST, EVENTS, FAR, RESIDUE, SAMPLES, TOUCH
from steadyload.core.timed import thin_side
from steadyload.engines.attitudes import cross
from steadyload.engines.world import GRAVITY
from steadyload.layouts.model.layout import FloatArray
from steadyload.statics.least_squares import nonnegative_least_squares
from steadyload.statics.touching import FIRM, Indices, Points, directions, wrenches

VERSION = 2
"""Of how far items get: raised when it comes to other verdicts."""

_G = 100.0 * GRAVITY
_FACETS = 4


@dataclass(frozen=True, slots=True)
class Bodies:
    """A group of boxes: weights [kg] (n,), centres of mass and sides [cm] (n, 3)."""

    weights: FloatArray
    centres: FloatArray
    sizes: FloatArray


@dataclass(frozen=True, slots=True)
class Displacements:
    """Displacements of bodies: of centres of mass [cm] and about the axes [rad], (n, 3) each."""

    shifts: FloatArray
    turns: FloatArray


def displacements_after(
    bodies: Bodies, points: Points, friction: FloatArray, seconds: float
) -> Displacements:
    """Displacements of a group that starts at rest, after some time.

    Args:
        bodies: the group.
        points: where its bodies touch each other and what is firm, or may come to.
        friction: Coulomb coefficient of every point.
        seconds: how long it moves.
    """
    run = _Run(bodies, points, friction)
    left = seconds
    for _ in range(EVENTS):
        left -= run.advance(left)
        if left <= 0.0:
            break
    return Displacements(run.way[:, :3], run.way[:, 3:])


class _Run:
    def __init__(self, bodies: Bodies, points: Points, friction: FloatArray) -> None:
        self.bodies, self.points = bodies, points
        self.point, self.force = directions(points.axes, friction, _FACETS)
        masses = bodies.weights / bodies.weights.mean()
        squares = bodies.sizes**2
        inertia = (masses[:, None] / 12.0) * (squares.sum(axis=1, keepdims=True) - squares)
        self.mass = np.concatenate((np.repeat(masses[:, None], 3, axis=1), inertia), axis=1)
        self.root = np.sqrt(self.mass)
        self.way = np.zeros_like(self.mass)
        self.gaps = points.gaps.copy()
        self.normals = np.zeros((len(points), 3))
        self.normals[np.arange(len(points)), points.axes] = 1.0

    def advance(self, left: float) -> float:
        """Move from rest to the next event, or through the time that is left.

        Returns:
            The time passed [s].
        """
        n = len(self.mass)
        used = np.flatnonzero((self.gaps <= TOUCH)[self.point])
        positions = self._positions()
        rate = np.zeros((n, 6))
        rate[:, 1] = -_G
        pushing = np.zeros(0, dtype=np.intp)
        if len(used):
            unit = wrenches(
                self.points, positions, self._centres(), self.point[used], self.force[used]
            )
            scaled = (unit / self.root[:, :, None]).reshape(6 * n, -1)
            fall = (rate * self.root).ravel() / _G
            found, left_over = nonnegative_least_squares(scaled, -fall)
            rest = left_over.reshape(n, 6)
            # What rounding leaves would grow without end in a narrow piece, which tips fast.
            felt = np.abs(fall) + np.abs(scaled) @ found
            still = self._corner_rates(rest) <= RESIDUE * self._corner_rates(felt.reshape(n, 6))
            rest[still & (self.bodies.sizes.min(axis=1) < thin_side(_G, left))] = 0.0
            rate = -_G * rest / self.root
            pushing = self.point[used[found > 0.0]]
        return self._coast(rate, self._growth(rate, pushing), positions, left)

    def _corner_rates(self, forces: FloatArray) -> FloatArray:
        """How fast forces can accelerate any corner of a body [g], shape (n,)."""
        start = np.abs(forces) / self.root
        found: FloatArray = start[:, :3].sum(axis=1)
        return found + (start[:, 3:] * self.bodies.sizes).sum(axis=1)

    def _growth(self, rate: FloatArray, pushing: Indices) -> FloatArray:
        """k2 of every body [1/s2]: that of the items that move and push each other.

        Along s, a body that turns with w about an axis at a height h below its centre of mass
        loses the height w2 h s2 / 2 beyond what the start says; w2 h is (w x u) upwards, with the
        speed u of its centre of mass.
        """
        n = len(rate)
        u, w = rate[:, :3], rate[:, 3:]
        gain = _G * self.mass[:, 0] * (w[:, 0] * u[:, 2] - w[:, 2] * u[:, 0])
        energy = (self.mass * rate**2).sum(axis=1)
        moving = energy > AT_REST * max(energy.max(), 1e-300)
        a, b = self.points.first[pushing], self.points.second[pushing]
        inner = (a != FIRM) & (b != FIRM)
        inner[inner] &= moving[a[inner]] & moving[b[inner]]
        part = _parts(n, zip(a[inner].tolist(), b[inner].tolist(), strict=True))
        total = np.bincount(part, energy, n)
        growth = np.bincount(part, gain, n) / np.where(total > 0.0, total, 1.0)
        return growth[part]

    def _coast(
        self, rate: FloatArray, growth: FloatArray, positions: FloatArray, left: float
    ) -> float:
        """Move until a gap closes, or through the time that is left."""
        times = left * np.arange(1, SAMPLES + 1) / SAMPLES
        steps = rate[:, :, None] * _pendulum(growth[:, None], times[None])[:, None]
        # How gaps change: the relative motion of the two bodies along the normal.
        every = np.arange(len(self.points))
        along = wrenches(self.points, positions, self._centres(), every, self.normals)
        change = np.einsum("nck,ncs->ks", along, steps)
        closing = (self.gaps > TOUCH)[:, None] & (self.gaps[:, None] + change <= TOUCH)
        hits = np.flatnonzero(closing.any(axis=0))
        at = int(hits[0]) if len(hits) else SAMPLES - 1
        self.way += steps[:, :, at]
        self.gaps += change[:, at]
        return float(times[at])

    def _centres(self) -> FloatArray:
        return self.bodies.centres + self.way[:, :3]

    def _positions(self) -> FloatArray:
        """Contact points go with their first body; those on what is firm stay."""
        positions = self.points.positions.copy()
        on = np.flatnonzero(self.points.first != FIRM)
        who = self.points.first[on]
        lever = positions[on] - self.bodies.centres[who]
        positions[on] += self.way[who, :3] + cross(self.way[who, 3:], lever)
        return positions


def _parts(count: int, joined: Iterable[tuple[int, int]]) -> list[int]:
    """The part that every body belongs to, where bodies of joined pairs are in one part."""
    part = list(range(count))
    for one, other in joined:
        if part[one] != part[other]:
            new, old = part[one], part[other]
            part = [new if p == old else p for p in part]
    return part


def _pendulum(growth: FloatArray, t: FloatArray) -> FloatArray:
    """The way of s'' = 1 + k2 s from rest at s = 0; near k2 = 0 it is t2 / 2."""
    half = 0.5 * np.sqrt(np.abs(growth)) * t
    half = np.clip(half, 1e-6, FAR)
    return 0.5 * t * t * (np.where(growth > 0.0, np.sinh(half), np.sin(half)) / half) ** 2
