"""RODAS: an L-stable, stiffly accurate Rosenbrock method of order 4 with an estimate of order 3.

E. Hairer and G. Wanner, Solving Ordinary Differential Equations II, section IV.7, in the form with
transformed stages; coefficients as in their code ``rodas``. Each stage is one linear solve with
the same matrix 1/(h gamma) - J. Positions are eliminated from it: what is left has six rows a body.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from steadyload.engines.reference.blocks import elimination_order, factorise, solve
from steadyload.engines.reference.compilation import compiled
from steadyload.engines.reference.contact import FLOOR
from steadyload.engines.reference.motion import (
    accelerations,
    linearise,
    make_linearisation,
    rotation_rate,
    turn_by,
)

STAGES = 6
GAMMA = 0.25

_A = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0],
        [1.544, 0.0, 0.0, 0.0, 0.0],
        [0.9466785280815826, 0.2557011698983284, 0.0, 0.0, 0.0],
        [3.314825187068521, 2.896124015972201, 0.9986419139977817, 0.0, 0.0],
        [1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 0.0],
        [1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 1.0],
    ]
)
_C = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0],
        [-5.6688, 0.0, 0.0, 0.0, 0.0],
        [-2.430093356833875, -0.2063599157091915, 0.0, 0.0, 0.0],
        [-0.1073529058151375, -9.594562251023355, -20.47028614809616, 0.0, 0.0],
        [7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160, 0.0],
        [8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136,
         -6.058818238834054],
    ]
)  # fmt: skip

_SAFETY, _LEAST_CHANGE, _MOST_CHANGE = 0.9, 0.2, 5.0

_VELOCITY_TOLERANCE = 100.0
"""Velocities may be wrong by this many times the tolerance of positions, a second [1/s]."""

_SMALLEST_STEP = 1e-13
"""A step [s] below which the equations cannot be followed."""

FINISHED, STEP_TOO_SMALL, NOT_FINITE, SINGULAR, TOO_MUCH_WORK = 0, 1, 2, 3, 4


class Control(NamedTuple):
    """Step-size control of the integrator.

    ``tolerance``: of a position [m]. ``most_time``: longest step [s]. ``most_work``: attempts
    at a step times pairs that may touch.
    """

    tolerance: float
    most_time: float
    most_work: int


class Count(NamedTuple):
    """Counts of an integration: its outcome, the step it would take next [s], steps and rejects."""

    outcome: int
    next_step: float
    accepted: int
    rejected: int


@compiled
def _assemble(bodies, lin, touching, spins, sigma, matrix, filled, behind):
    """The matrix of the velocities' stages, sigma M - D - C (sigma - A)^-1, block by block.

    ``behind`` gets (sigma - A)^-1 of every body's rotation vector, shape (n, 3, 3), with A = [w]x/2
    the derivative of its rate; of a centre of mass it is 1 / sigma.
    """
    n = len(spins)
    for b in range(n):
        x, y, z = 0.5 * spins[b, 0], 0.5 * spins[b, 1], 0.5 * spins[b, 2]
        scale = 1.0 / (sigma * (sigma * sigma + x * x + y * y + z * z))
        e = behind[b]
        e[0, 0], e[0, 1], e[0, 2] = sigma * sigma + x * x, x * y - sigma * z, x * z + sigma * y
        e[1, 0], e[1, 1], e[1, 2] = x * y + sigma * z, sigma * sigma + y * y, y * z - sigma * x
        e[2, 0], e[2, 1], e[2, 2] = x * z - sigma * y, y * z + sigma * x, sigma * sigma + z * z
        for i in range(3):
            for j in range(3):
                e[i, j] *= scale
        for c in range(n):
            if filled[b, c]:
                matrix[b, c, :, :] = 0.0
        for i in range(6):
            for j in range(6):
                matrix[b, b, i, j] = sigma * lin.mass[b, i, j]
        if not bodies[b].fixed:
            _subtract(matrix[b, b], lin.own_pose[b], lin.own_velocity[b], 0, 0, sigma, e)
    for k in range(touching):
        for x in range(2):
            i = lin.ends[k, x]
            if i == FLOOR or bodies[i].fixed:
                continue
            for y in range(2):
                j = lin.ends[k, y]
                if j == FLOOR or bodies[j].fixed:
                    continue
                _subtract(
                    matrix[i, j], lin.by_pose[k], lin.by_velocity[k], 6 * x, 6 * y, sigma, behind[j]
                )


@compiled
def _subtract(block, by_pose, by_velocity, row, column, sigma, behind):
    """Subtract D + C (sigma - A)^-1 of one 6 x 6 part from a block."""
    for i in range(6):
        for j in range(3):
            block[i, j] -= by_velocity[row + i, column + j] + by_pose[row + i, column + j] / sigma
            turned = 0.0
            for m in range(3):
                turned += by_pose[row + i, column + 3 + m] * behind[m, j]
            block[i, 3 + j] -= by_velocity[row + i, column + 3 + j] + turned


@compiled
def _stage(bodies, lin, touching, sigma, behind, matrix, filled, order, rates, forces, x, u):
    """One stage: solve for ``x`` and ``u`` (n, 6) from right-hand sides ``rates`` and ``forces``.

    ``rates`` is overwritten.
    """
    n = len(rates)
    for b in range(n):
        for i in range(3):
            x[b, i] = rates[b, i] / sigma
            turned = 0.0
            for m in range(3):
                turned += behind[b, i, m] * rates[b, 3 + m]
            x[b, 3 + i] = turned
    for b in range(n):
        for i in range(6):
            total = 0.0
            if not bodies[b].fixed:
                for m in range(6):
                    total += lin.mass[b, i, m] * forces[b, m] + lin.own_pose[b, i, m] * x[b, m]
            u[b, i] = total
    for k in range(touching):
        for first in range(2):
            i = lin.ends[k, first]
            if i == FLOOR or bodies[i].fixed:
                continue
            for second in range(2):
                j = lin.ends[k, second]
                if j == FLOOR or bodies[j].fixed:
                    continue
                for r in range(6):
                    total = 0.0
                    for c in range(6):
                        total += lin.by_pose[k, 6 * first + r, 6 * second + c] * x[j, c]
                    u[i, r] += total
    solve(matrix, filled, order, u)
    for b in range(n):
        if bodies[b].fixed:
            x[b] = 0.0
            continue
        for i in range(3):
            x[b, i] += u[b, i] / sigma
            for m in range(3):
                x[b, 3 + i] += behind[b, i, m] * u[b, 3 + m]


@compiled
def _error(bodies, x, u, tolerance):
    """The largest estimated error in units of the tolerance; not a number if the state is not."""
    worst = 0.0
    for b in range(len(x)):
        arm = bodies[b].extent
        for i in range(3):
            linear = max(abs(x[b, i]), abs(u[b, i]) / _VELOCITY_TOLERANCE)
            angular = max(abs(x[b, 3 + i]), abs(u[b, 3 + i]) / _VELOCITY_TOLERANCE) * arm
            if not (math.isfinite(linear) and math.isfinite(angular)):
                return math.nan
            worst = max(worst, linear, angular)
    return worst / tolerance


@compiled
def _orthonormal(turn):
    """Mend the rounding of rotation matrices in place (Gram and Schmidt)."""
    for b in range(len(turn)):
        r = turn[b]
        for c in range(2):
            if c == 1:
                dot = r[0, 0] * r[0, 1] + r[1, 0] * r[1, 1] + r[2, 0] * r[2, 1]
                for i in range(3):
                    r[i, 1] -= dot * r[i, 0]
            length = math.sqrt(r[0, c] ** 2 + r[1, c] ** 2 + r[2, c] ** 2)
            for i in range(3):
                r[i, c] /= length
        r[0, 2] = r[1, 0] * r[2, 1] - r[2, 0] * r[1, 1]
        r[1, 2] = r[2, 0] * r[0, 1] - r[0, 0] * r[2, 1]
        r[2, 2] = r[0, 0] * r[1, 1] - r[1, 0] * r[0, 1]


@compiled
def _pattern(lin, touching, filled):
    """Sparsity pattern: the pairs of bodies that share a block."""
    filled[:, :] = False
    for b in range(len(filled)):
        filled[b, b] = True
    for k in range(touching):
        i, j = lin.ends[k, 0], lin.ends[k, 1]
        if j != FLOOR:
            filled[i, j] = filled[j, i] = True


@compiled
def integrate(law, field, bodies, pairs, p, turn, v, w, duration, first_step, control, s):
    """Advance bodies by ``duration`` seconds, in place.

    Args:
        law: contact parameters.
        field: what acts besides contact.
        bodies: their sizes and masses.
        pairs: candidates for contact during that time, shape (m, 2); -1 is the floor.
        p: centres of mass [m], shape (n, 3).
        turn: axes as columns, shape (n, 3, 3).
        v: velocities [m/s].
        w: angular velocities [rad/s].
        duration: [s].
        first_step: length of the first step [s].
        control: how time is cut into steps.
        s: scratch.

    Returns:
        A :class:`Count`; on any outcome but ``FINISHED`` the state is that of the last good step.
    """
    n = len(p)
    lin = make_linearisation(n, len(pairs))
    matrix = np.zeros((n, n, 6, 6))
    filled = np.zeros((n, n), np.bool_)
    behind = np.zeros((n, 3, 3))
    xs, us = np.zeros((STAGES, n, 6)), np.zeros((STAGES, n, 6))
    first = np.zeros((n, 6))
    rates, forces = np.zeros((n, 6)), np.zeros((n, 6))
    x, p_now, v_now, w_now = np.zeros((n, 6)), p.copy(), v.copy(), w.copy()
    turn_now = turn.copy()
    h = min(first_step, control.most_time)
    time, accepted, rejected = 0.0, 0, 0
    fresh, touching = True, 0
    order = np.zeros(0, np.int64)
    while time < duration:
        if (accepted + rejected) * (len(pairs) + 1) >= control.most_work:
            return Count(TOO_MUCH_WORK, h, accepted, rejected)
        last = time + h * (1.0 + 1e-9) >= duration
        step = duration - time if last else h
        if fresh:
            touching = linearise(law, field, bodies, pairs, p, turn, v, w, first, lin, s)
            _pattern(lin, touching, filled)
            order = elimination_order(filled)
            fresh = False
        sigma = 1.0 / (step * GAMMA)
        _assemble(bodies, lin, touching, w, sigma, matrix, filled, behind)
        error = math.nan
        outcome = SINGULAR
        if factorise(matrix, filled, order):
            outcome = NOT_FINITE
            for k in range(STAGES):
                x[:, :] = 0.0
                v_now[:, :] = v
                w_now[:, :] = w
                for j in range(k):
                    a = _A[k, j]
                    for b in range(n):
                        for i in range(3):
                            x[b, i] += a * xs[j, b, i]
                            x[b, 3 + i] += a * xs[j, b, 3 + i]
                            v_now[b, i] += a * us[j, b, i]
                            w_now[b, i] += a * us[j, b, 3 + i]
                if k == 0:
                    forces[:, :] = first
                else:
                    for b in range(n):
                        for i in range(3):
                            p_now[b, i] = p[b, i] + x[b, i]
                    turn_by(x[:, 3:], turn, turn_now)
                    accelerations(
                        law, field, bodies, pairs, p_now, turn_now, v_now, w_now, forces, s
                    )
                for b in range(n):
                    rates[b, :3] = v_now[b]
                    rotation_rate(x[b, 3:], w_now[b], rates[b, 3:])
                    for j in range(k):
                        c = _C[k, j] / step
                        for i in range(6):
                            rates[b, i] += c * xs[j, b, i]
                            forces[b, i] += c * us[j, b, i]
                _stage(
                    bodies, lin, touching, sigma, behind, matrix, filled, order, rates, forces,
                    xs[k], us[k],
                )  # fmt: skip
            error = _error(bodies, xs[STAGES - 1], us[STAGES - 1], control.tolerance)
        if not error <= 1.0:
            rejected += 1
            change = _LEAST_CHANGE
            if math.isfinite(error):
                change = max(_LEAST_CHANGE, _SAFETY * error**-0.25)
                outcome = STEP_TOO_SMALL
            h = step * change
            if h < _SMALLEST_STEP:
                return Count(outcome, h, accepted, rejected)
            continue
        # The last stage's point, which the estimate was taken from, and the estimate added to it.
        for b in range(n):
            if bodies[b].fixed:
                continue
            for i in range(3):
                p[b, i] += x[b, i] + xs[STAGES - 1, b, i]
                x[b, 3 + i] += xs[STAGES - 1, b, 3 + i]
                v[b, i] = v_now[b, i] + us[STAGES - 1, b, i]
                w[b, i] = w_now[b, i] + us[STAGES - 1, b, 3 + i]
        turn_by(x[:, 3:], turn, turn_now)
        turn[:, :, :] = turn_now
        _orthonormal(turn)
        time = duration if last else time + step
        accepted += 1
        fresh = True
        change = _MOST_CHANGE if error < 1e-6 else min(_MOST_CHANGE, _SAFETY * error**-0.25)
        # A step cut short by the end says little about the next one.
        if not last or change < 1.0 or step >= h:
            h = step * max(_LEAST_CHANGE, change)
        h = min(h, control.most_time)
    return Count(FINISHED, h, accepted, rejected)
