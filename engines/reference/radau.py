"""The same equations under scipy's Radau: no code of ours between the forces and the solution.

A check on the integrator, not a way to make labels: it is an implicit method of order 5 with its
own error control, Newton iteration and step choice, knows nothing of groups of bodies, and takes
some twenty times as long. Only the Jacobian for its iteration, which does not enter the
answer, is taken from the linearisation.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from steadyload.engines.reference.contact import FLOOR
from steadyload.engines.reference.islands import (
    MOST_STRETCH,
    candidate_pairs,
    reaches,
    within,
)
from steadyload.engines.reference.law import Law
from steadyload.engines.reference.motion import (
    Field,
    accelerations,
    linearise,
    make_linearisation,
    rotation_rate,
    turn_by,
)
from steadyload.engines.reference.rodas import (
    FINISHED,
    NOT_FINITE,
    STEP_TOO_SMALL,
    Control,
)

_WINDOW = 0.01
"""Rotation vectors start anew, and candidates for contact are found anew, after this time [s]."""

_RELATIVE = 1e-8


def advance(
    law: Law,
    field: Field,
    bodies: np.recarray,
    p: NDArray[np.float64],
    turn: NDArray[np.float64],
    v: NDArray[np.float64],
    w: NDArray[np.float64],
    _next_steps: NDArray[np.float64],
    duration: float,
    control: Control,
    scratch: np.void,
) -> tuple[int, int, int]:
    """The task of :func:`steadyload.engines.reference.islands.advance`, solved by scipy's Radau.

    Positions are followed to a hundredth of the control's tolerance, velocities to a hundredth a
    second of that.
    """
    time, steps, stretch = 0.0, 0, 2.0
    while duration - time > 1e-9:
        window = min(_WINDOW, duration - time)
        reach = reaches(field, bodies, v, w, window, stretch)
        system = _System(law, field, bodies, p, turn, reach, scratch)
        start = np.concatenate((p, np.zeros_like(p), v, w), axis=1).ravel()
        error = np.repeat([0.01, 0.01, 1.0, 1.0], 3) * control.tolerance
        found = solve_ivp(
            system.rates,
            (0.0, window),
            start,
            method="Radau",
            jac=system.jacobian,
            rtol=_RELATIVE,
            atol=np.tile(error, len(p)),
            first_step=min(1e-5, window),
            max_step=control.most_time,
            t_eval=[window],
        )
        steps += found.njev
        if not found.success:
            return STEP_TOO_SMALL, steps, 0
        end = found.y[:, -1].reshape(-1, 12)
        places, turned = np.ascontiguousarray(end[:, :3]), np.empty_like(turn)
        turn_by(np.ascontiguousarray(end[:, 3:6]), turn, turned)
        if not within(bodies, p, turn, places, turned, reach):
            stretch *= 2.0
            if stretch > MOST_STRETCH:
                return NOT_FINITE, steps, 0
            continue
        p[:], turn[:], v[:], w[:] = places, turned, end[:, 6:9], end[:, 9:]
        time, stretch = time + window, 2.0
    return FINISHED, steps, 0


class _System:
    """The equations of motion as scipy wants them: twelve numbers a body, one after the other."""

    def __init__(
        self,
        law: Law,
        field: Field,
        bodies: np.recarray,
        p: NDArray[np.float64],
        turn: NDArray[np.float64],
        reach: NDArray[np.float64],
        scratch: np.void,
    ) -> None:
        self._law, self._field, self._bodies, self._start = law, field, bodies, turn.copy()
        self._free = ~np.array(bodies.fixed)
        self._pairs = candidate_pairs(field.floor, bodies, p, turn, reach)
        self._scratch = scratch
        self._turn = np.empty_like(turn)
        self._out = np.empty((len(p), 6))
        self._linearisation = make_linearisation(len(p), len(self._pairs))

    def _unpack(self, y: NDArray[np.float64]) -> list[NDArray[np.float64]]:
        state = y.reshape(-1, 12)
        p, t, v, w = (np.ascontiguousarray(state[:, k : k + 3]) for k in (0, 3, 6, 9))
        turn_by(t, self._start, self._turn)
        return [p, t, v, w]

    def rates(self, _: float, y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Right-hand side."""
        p, t, v, w = self._unpack(y)
        accelerations(
            self._law, self._field, self._bodies, self._pairs, p, self._turn, v, w, self._out,
            self._scratch,
        )  # fmt: skip
        rates = np.zeros((len(p), 12))
        for b in np.flatnonzero(self._free):
            rates[b, :3] = v[b]
            rotation_rate(t[b], w[b], rates[b, 3:6])
        rates[:, 6:] = self._out
        return rates.ravel()

    def jacobian(self, _: float, y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Its derivatives, exact for small rotation vectors."""
        p, _t, v, w = self._unpack(y)
        n, lin = len(p), self._linearisation
        touching = linearise(
            self._law, self._field, self._bodies, self._pairs, p, self._turn, v, w, self._out, lin,
            self._scratch,
        )  # fmt: skip
        jacobian = np.zeros((n, 12, n, 12))
        for b in np.flatnonzero(self._free):
            jacobian[b, :6, b, 6:] = np.eye(6)
            jacobian[b, 6:, b, :6] += lin.own_pose[b]
            jacobian[b, 6:, b, 6:] += lin.own_velocity[b]
        for k in range(touching):
            for x, i in enumerate(lin.ends[k]):
                for y_, j in enumerate(lin.ends[k]):
                    if FLOOR not in (i, j) and self._free[i] and self._free[j]:
                        rows, columns = slice(6 * x, 6 * x + 6), slice(6 * y_, 6 * y_ + 6)
                        jacobian[i, 6:, j, :6] += lin.by_pose[k][rows, columns]
                        jacobian[i, 6:, j, 6:] += lin.by_velocity[k][rows, columns]
        inverse = np.linalg.inv(lin.mass)
        jacobian[:, 6:] = np.einsum("bij,bjck->bick", inverse, jacobian[:, 6:])
        return jacobian.reshape(12 * n, 12 * n)
