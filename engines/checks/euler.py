"""Free rotation of a rigid body: Euler's equations, solved to 1e-12."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

FloatArray = NDArray[np.float64]

RELATIVE, ABSOLUTE = 1e-12, 1e-14
"""Tolerances of the integration."""


def spun(
    inertia: FloatArray,
    angular_velocity: Sequence[float],
    seconds: float,
    attitude: Sequence[float] = (1.0, 0.0, 0.0, 0.0),
) -> FloatArray:
    """Attitude (w, x, y, z) and angular velocity (body axes) of a free body, by Euler's equations.

    Args:
        inertia: principal moments [kg m2], along the axes of the body.
        angular_velocity: at the start, in the axes of the body [rad/s].
        seconds: how long it turns.
        attitude: at the start.
    """

    def rates(_: float, state: FloatArray) -> FloatArray:
        quaternion, spin = state[:4], state[4:]
        turning = 0.5 * np.array(
            [
                -quaternion[1:] @ spin,
                *(quaternion[0] * spin + np.cross(quaternion[1:], spin)),
            ]
        )
        return np.concatenate((turning, -np.cross(spin, inertia * spin) / inertia))

    state = solve_ivp(
        rates,
        (0.0, seconds),
        (*attitude, *angular_velocity),
        method="DOP853",
        rtol=RELATIVE,
        atol=ABSOLUTE,
    ).y[:, -1]
    state[:4] /= np.linalg.norm(state[:4])
    return state
