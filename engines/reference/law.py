"""The forces at one point of contact: ADAMS' IMPACT and its regularised Coulomb friction."""

from __future__ import annotations

import math
from typing import NamedTuple

from scipy.optimize import brentq

from steadyload.engines.reference.compilation import compiled


class Law(NamedTuple):
    """Parameters of a contact, in SI.

    Attributes:
        stiffness: K of a whole contact polygon [N/m^exponent].
        exponent: of the depth, 1 or more.
        damping: C of a whole contact polygon at full depth [N s/m].
        damping_depth: depth at which the damping has become full [m].
        static_friction: coefficient at the stiction speed.
        dynamic_friction: coefficient from the friction speed on.
        stiction_speed: sliding speed at which friction is full [m/s].
        friction_speed: sliding speed at which friction has become dynamic [m/s].
        most_rate: a contact is made softer, damping and all, where a body of its own mass would
            vibrate on it at more than this [rad/s].
        damping_ratio: share of the critical damping that every contact has at full depth, in the
            place of ``damping``; 0 for ``damping``.
    """

    stiffness: float
    exponent: float
    damping: float
    damping_depth: float
    static_friction: float
    dynamic_friction: float
    stiction_speed: float
    friction_speed: float
    most_rate: float
    damping_ratio: float = 0.0


LEAST_REBOUND = 1e-4
"""Less restitution than this counts as this: it takes fifty times the critical damping."""


def damping_ratio(rebound: float) -> float:
    """The share of critical damping at which a linear contact has a coefficient of restitution.

    The bodies part where the force has become zero, which is before the depth has: T. Schwager and
    T. Poeschel, Coefficient of restitution and linear-dashpot model revisited, Granular Matter 9
    (2007) 465-469. At a share cos(a) their coefficient is exp(-2 a / tan(a)), and above critical
    damping, at cosh(a), it is exp(-2 a / tanh(a)). It depends on neither speed nor mass.

    Args:
        rebound: the coefficient, 0 to 0.999.
    """
    lost = -0.5 * math.log(max(rebound, LEAST_REBOUND))
    if lost < 1.0:
        return math.cos(brentq(lambda a: a / math.tan(a) - lost, 1e-9, 0.5 * math.pi, xtol=1e-15))
    return math.cosh(brentq(lambda a: a / math.tanh(a) - lost, 1e-9, lost, xtol=1e-15))


@compiled
def softening(law, mass):
    """The factor on the normal forces of a contact whose lighter body has this mass [kg].

    Without it a gramme rests on a stiff contact at a depth below that of rounding and of the
    tolerated errors, and hops on them for ever.
    """
    return min(1.0, mass * law.most_rate * law.most_rate / law.stiffness)


@compiled
def normal_force(law, damping, depth, rate):
    """K d^e + C step(d / d_max) d', never a pull, of a polygon's whole weight.

    Args:
        law: the parameters.
        damping: C [N s/m], ``law.damping`` unless that follows the bodies.
        depth: penetration d [m].
        rate: d' [m/s].

    Returns:
        The force [N] and its derivatives by depth and rate; zeros where there is no force.
    """
    if depth <= 0.0:
        return 0.0, 0.0, 0.0
    if law.exponent == 1.0:
        elastic, slope = law.stiffness * depth, law.stiffness
    else:
        elastic = law.stiffness * depth**law.exponent
        slope = law.exponent * elastic / depth
    share, share_slope = 1.0, 0.0
    if depth < law.damping_depth:
        u = depth / law.damping_depth
        share, share_slope = u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u) / law.damping_depth
    force = elastic + damping * share * rate
    if force <= 0.0:
        return 0.0, 0.0, 0.0
    return force, slope + damping * share_slope * rate, damping * share


@compiled
def friction_ratio(law, speed):
    """The coefficient of friction over the sliding speed, mu(s) / s, smooth at rest.

    mu rises as the cubic step of ADAMS from 0 to the static value at the stiction speed, and goes
    from there to the dynamic value at the friction speed.

    Returns:
        mu(s) / s [s/m], and the derivative of that by s, over s.
    """
    if speed < law.stiction_speed:
        u = speed / law.stiction_speed
        ratio = 0.5 * law.static_friction * (3.0 - u * u) / law.stiction_speed
        return ratio, -law.static_friction / law.stiction_speed**3
    mu, mu_slope = law.dynamic_friction, 0.0
    if speed < law.friction_speed:
        width = law.friction_speed - law.stiction_speed
        u = (speed - law.stiction_speed) / width
        drop = law.dynamic_friction - law.static_friction
        mu = law.static_friction + drop * u * u * (3.0 - 2.0 * u)
        mu_slope = drop * 6.0 * u * (1.0 - u) / width
    return mu / speed, (mu_slope * speed - mu) / speed**3
