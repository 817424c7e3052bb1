"""Pendulums that items which push each other move as, until a gap closes."""

from __future__ import annotations

from typing import Any

import numpy as np

from steadyload.statics.kernels.compiled import compiled
from steadyload.statics.kernels.constants import AT_REST, FAR, SAMPLES, TOUCH
from steadyload.statics.kernels.group_forces import merge, put_wrench


@compiled
def growth_of(
    rates: Any, mass: Any, points: Any, sources: Any, parts: Any, place: Any,
    gravity: float,
) -> Any:  # fmt: skip
    """k2 of every free body [1/s2]: that of the bodies that move and push each other."""
    count = len(rates)
    gain, energy, part = np.empty(count), np.empty(count), np.arange(count)
    for n in range(count):
        u, w = rates[n, :3], rates[n, 3:]
        gain[n] = gravity * mass[n, 0] * (w[0] * u[2] - w[2] * u[0])
        energy[n] = (mass[n] * rates[n] ** 2).sum()
    least = AT_REST * max(energy.max(), 1e-300)
    for column in range(len(sources)):
        first, second = points.pairs[sources[column] // 4]
        a, b = place[first], place[second]
        if parts[column] > 0.0 and a >= 0 and b >= 0 and min(energy[a], energy[b]) > least:
            merge(part, a, b)
    growth = np.empty(count)
    for n in range(count):
        gains, energies = 0.0, 0.0
        for m in range(count):
            if part[m] == part[n]:
                gains += gain[m]
                energies += energy[m]
        growth[n] = gains / (energies if energies > 0.0 else 1.0)
    return growth


@compiled
def coast(
    rates: Any, growth: Any, points: Any, known: int, at: Any, place: Any, free: Any, centres: Any,
    way: Any, left: float,
) -> float:  # fmt: skip
    """Move until a gap closes, or through the time that is left; the time passed [s]."""
    count = len(free)
    # How gaps change: the relative motion of the two bodies along the normal.
    along = np.zeros((known, 2))
    row, normal = np.empty(6), np.zeros(3)
    for k in range(known):
        normal[:] = 0.0
        normal[points.axes[k]] = 1.0
        for side in range(2):
            body = points.pairs[k, side]
            n = place[body]
            if n >= 0:
                put_wrench(row, normal, at[k], centres[body], way[body], 1.0 if side else -1.0)
                along[k, side] = (row * rates[n]).sum()
    gone = np.empty(count + 1)
    gone[count] = 0.0
    time = left
    for sample in range(1, SAMPLES + 1):
        time = left * sample / SAMPLES
        for n in range(count):
            gone[n] = _pendulum(growth[n], time)
        closes = False
        for k in range(known):
            if points.gaps[k] > TOUCH and (
                points.gaps[k] + _change(along[k], points.pairs[k], place, gone) <= TOUCH
            ):
                closes = True
                break
        if closes:
            break
    for k in range(known):
        points.gaps[k] += _change(along[k], points.pairs[k], place, gone)
    for n in range(count):
        for c in range(6):
            way[free[n], c] += rates[n, c] * gone[n]
    return time


@compiled
def _change(along: Any, pair: Any, place: Any, gone: Any) -> float:
    """How much a gap changes; bodies at rest stand last in ``gone``, at place -1."""
    return along[0] * gone[place[pair[0]]] + along[1] * gone[place[pair[1]]]


@compiled
def _pendulum(growth: float, t: float) -> float:
    """The way of s'' = 1 + k2 s from rest at s = 0; near k2 = 0 it is t2 / 2."""
    half = min(max(0.5 * np.sqrt(abs(growth)) * t, 1e-6), FAR)
    return 0.5 * t * t * ((np.sinh(half) if growth > 0.0 else np.sin(half)) / half) ** 2
