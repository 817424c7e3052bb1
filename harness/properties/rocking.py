"""Mechanics of a block that rocks on its two lower edges, and is overturned by the ground.

G. W. Housner, "The behavior of inverted pendulum structures during earthquakes", Bulletin of the
Seismological Society of America 53 (1963) 403-417. Friction holds the edges; an impact on the other
edge takes no time and keeps the angular momentum about it. Nothing here knows an engine. Units are
SI, angles in radians.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from steadyload.engines.checks.euler import ABSOLUTE, RELATIVE
from steadyload.engines.world import GRAVITY

FloatArray = NDArray[np.float64]


class Block(NamedTuple):
    """A uniform block of a width and a height [m]."""

    width: float
    height: float

    @property
    def slenderness(self) -> float:
        """Angle alpha at which its centre stands over an edge: atan(width / height)."""
        return math.atan2(self.width, self.height)

    @property
    def rate(self) -> float:
        """p = sqrt(m g R / I) = sqrt(3 g / (4 R)) [1/s], R half its diagonal, I about an edge."""
        return math.sqrt(1.5 * GRAVITY / math.hypot(self.width, self.height))

    @property
    def overturning(self) -> float:
        """The least acceleration of the ground that lifts it off an edge: g tan(alpha) [m/s2]."""
        return GRAVITY * self.width / self.height


def time_to_impact(block: Block, share: float) -> float:
    """Time in which a block falls from ``share`` of alpha back to its base [s]: T / 4.

    By a'' = -p^2 sin(alpha - a). For slender blocks acosh(1 / (1 - share)) / p.
    """
    alpha, square = block.slenderness, block.rate**2

    def rates(_: float, state: FloatArray) -> tuple[float, float]:
        return state[1], -square * math.sin(alpha - state[0])

    def reached(_: float, state: FloatArray) -> float:
        return state[0]

    reached.terminal = True  # type: ignore[attr-defined]
    solved = solve_ivp(
        rates,
        (0.0, 60.0),
        (share * alpha, 0.0),
        method="DOP853",
        events=reached,
        rtol=RELATIVE,
        atol=ABSOLUTE,
    )
    return float(solved.t_events[0][0])


def energy_after_impact(block: Block) -> float:
    """Share of the kinetic energy that an impact leaves: (1 - 3/2 sin^2 alpha)^2.

    The angular momentum about the new edge is I w - 2 m R^2 sin^2(alpha) w, with I = 4/3 m R^2.
    """
    return (1.0 - 1.5 * math.sin(block.slenderness) ** 2) ** 2


def energy_at(block: Block, angle: float) -> float:
    """Energy at rest at an angle over that on the base, in m g R: cos(alpha - a) - cos(alpha)."""
    alpha = block.slenderness
    return math.cos(alpha - abs(angle)) - math.cos(alpha)


def overturning_pulse(block: Block, seconds: float) -> float:
    """The least peak of a half sine of ground acceleration that overturns, over g tan(alpha).

    a'' = p^2 (s(t) cos(alpha - a) - sin(alpha - a)), s the acceleration over g, from the moment at
    which s = tan(alpha); a block overturns that has w > 2 p sin((alpha - a) / 2) at the end of the
    pulse, as its energy then takes it over the edge. Housner's own condition, sqrt(1 + (w / p)^2)
    for a slender block, is higher: it does not start from the moment at which the block lifts, as
    B. Shi, A. Anooshehpoor, Y. Zeng and J. N. Brune, Bulletin of the Seismological Society of
    America 86 (1996) 1364-1371, do. For slender blocks see :func:`slender_overturning_pulse`.

    Args:
        block: at rest on its base.
        seconds: duration of the pulse.
    """
    alpha, rate, frequency = block.slenderness, block.rate, math.pi / seconds

    def beyond(peak: float) -> float:
        height = peak * math.tan(alpha)

        def rates(time: float, state: FloatArray) -> tuple[float, float]:
            left, push = alpha - state[0], height * math.sin(frequency * time)
            return state[1], rate**2 * (push * math.cos(left) - math.sin(left))

        def over(_: float, state: FloatArray) -> float:
            return state[0] - alpha

        over.terminal = True  # type: ignore[attr-defined]
        end = solve_ivp(
            rates,
            (math.asin(1.0 / peak) / frequency, seconds),
            (0.0, 0.0),
            method="DOP853",
            events=over,
            rtol=RELATIVE,
            atol=ABSOLUTE,
        ).y[:, -1]
        return float(end[1] - 2.0 * rate * math.sin(0.5 * (alpha - end[0])))

    return _root_above_one(beyond)


def slender_overturning_pulse(rate: float, seconds: float) -> float:
    """The same for a slender block: peak q with 1 = p q int exp(-p (t - t0)) sin(w t) dt.

    The integral is from t0, with q sin(w t0) = 1, to the end of the pulse: s = a - alpha + w / p
    obeys s' = p s + p alpha q sin(w t), starts at -alpha, and must not end below 0.

    Args:
        rate: p [1/s].
        seconds: duration of the pulse.
    """
    frequency = math.pi / seconds

    def beyond(peak: float) -> float:
        lifted = math.asin(1.0 / peak) / frequency

        def whole(time: float) -> float:
            angle, decay = frequency * time, math.exp(-rate * (time - lifted))
            both = rate * math.sin(angle) + frequency * math.cos(angle)
            return -decay * both / (rate**2 + frequency**2)

        return rate * peak * (whole(seconds) - whole(lifted)) - 1.0

    return _root_above_one(beyond)


def _root_above_one(beyond: Callable[[float], float]) -> float:
    most = 2.0
    while beyond(most) < 0.0:
        most *= 2.0
    return float(brentq(beyond, 1.0, most, xtol=1e-11))
