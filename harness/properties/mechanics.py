"""Mechanics of single bodies: closed forms, and equations of motion solved to 1e-12.

Nothing here knows an engine. Units are SI, angles in radians unless a name says otherwise; layouts
have their own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from steadyload.engines.checks.euler import ABSOLUTE, RELATIVE
from steadyload.engines.checks.euler import spun as spun
from steadyload.engines.world import GRAVITY
from steadyload.layouts.model.layout import Arrangement

FloatArray = NDArray[np.float64]


def height_change(seconds: float) -> float:
    """Free fall from rest: -g t^2 / 2 [m]."""
    return -0.5 * GRAVITY * seconds**2


def slid(slope: float, friction: float, seconds: float) -> float:
    """Way of a block from rest down a ``slope`` = tan(angle): g (sin - f cos) t^2 / 2 [m]."""
    angle = math.atan(slope)
    return 0.5 * GRAVITY * (math.sin(angle) - friction * math.cos(angle)) * seconds**2


def stopping(speed: float, friction: float) -> float:
    """Way of a block on level ground from a speed [m/s] to rest: v^2 / (2 mu g) [m]."""
    return speed**2 / (2.0 * friction * GRAVITY)


def box_inertia(size: Sequence[float], mass: float) -> FloatArray:
    """Principal moments of a uniform box about its centre [kg m2]."""
    squares = np.square(size)
    return mass / 12.0 * (squares.sum() - squares)


def tipping_time(size: tuple[float, float], past_edge: float, angle: float) -> float:
    """Time [s] in which a uniform box at rest turns by ``angle`` about the edge that carries it.

    (k^2 + d^2 + h^2) a'' = g (d cos a + h sin a), with the centre of mass d past the edge and h
    above it, and the radius of gyration k.

    Args:
        size: of the box along the overhang and upwards [m].
        past_edge: d [m], above 0.
        angle: [rad], below a quarter turn.
    """
    width, height = size
    above = 0.5 * height
    square = (width**2 + height**2) / 12.0 + past_edge**2 + above**2

    def rates(_: float, state: FloatArray) -> tuple[float, float]:
        pull = past_edge * math.cos(state[0]) + above * math.sin(state[0])
        return state[1], GRAVITY * pull / square

    def reached(_: float, state: FloatArray) -> float:
        return state[0] - angle

    reached.terminal = True  # type: ignore[attr-defined]
    return float(_solved(rates, (0.0, 0.0), 60.0, reached).t_events[0][0])


def harmonic_overhangs(count: int, length: float) -> list[float]:
    """Overhang of each of ``count`` equal blocks over the one below, from the top down [m].

    L/2, L/4, L/6, ...: the centre of mass of every upper part lies exactly above the edge that
    carries it. The lowest block stands on the floor, so there are ``count`` - 1 of them.
    """
    return [length / (2.0 * k) for k in range(1, count)]


def column_limit(column: Arrangement, friction: float, direction_deg: float) -> float:
    """The acceleration at which a column slides or tips, in a direction along a side [g].

    At every face the part above it slides from the friction on, and tips from b / h on: its centre
    of mass lies b behind the edge of the face, in the direction of the force, and h above it. The
    weakest face counts.

    Args:
        column: boxes in loading order, each with all of its base on the one before.
        friction: Coulomb coefficient at every face, 0 or more.
        direction_deg: of the force on the boxes, seen from above, a multiple of 90; see
            :class:`steadyload.transport.limits.Limit`.

    Returns:
        0 where a part has its centre of mass past its edge.
    """
    angle = math.radians(direction_deg)
    along = np.round((math.cos(angle), math.sin(angle)))
    axis, sign = (0, along[0]) if along[0] else (2, along[1])
    centres = 0.5 * (column.lower + column.upper) + column.mass_offsets
    held = friction
    for level in range(len(column.weights)):
        weights = column.weights[level:]
        centre = weights @ centres[level:] / weights.sum()
        edge = column.upper[level, axis] if sign > 0.0 else column.lower[level, axis]
        height = centre[1] - column.lower[level, 1]
        held = min(held, max(0.0, sign * (edge - centre[axis])) / height)
    return float(held)


def _solved(rates: Callable, start: Sequence[float], seconds: float, event: Callable | None = None):
    return solve_ivp(
        rates,
        (0.0, seconds),
        start,
        method="DOP853",
        events=event,
        rtol=RELATIVE,
        atol=ABSOLUTE,
    )
