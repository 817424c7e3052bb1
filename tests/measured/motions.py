"""Motion in closed form, as trials that were recorded of it."""

import numpy as np

from steadyload.measured.bodies import Body
from steadyload.measured.motion import Trial

G = 9.81
CUBE = Body(size=(0.1, 0.1, 0.1), mass=0.5)


def turned(axis, angles):
    """Quaternions of turns about an axis [rad], shape (n, 4)."""
    axis = np.asarray(axis) / np.linalg.norm(axis)
    half = 0.5 * np.asarray(angles)[:, None]
    return np.concatenate([np.cos(half), np.sin(half) * axis], axis=1)


def upright(count):
    return np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))


def free_flight(axis=(1.0, 2.0, -0.5), rate=7.0, count=21, **more):
    """A cube that is thrown and spins about an axis of its own, 1 m above the floor."""
    times = np.linspace(0.0, 0.25, count)
    start, velocity = np.array([0.1, -0.2, 1.0]), np.array([1.0, -0.5, 2.0])
    positions = start + velocity * times[:, None]
    positions[:, 2] -= 0.5 * G * times**2
    return Trial("flight", times, positions, turned(axis, rate * times), **more)


def resting(count=10, height=0.05, **more):
    times = np.arange(count) / 100.0
    positions = np.tile([0.3, 0.1, height], (count, 1))
    return Trial("rest", times, positions, upright(count), **more)


def bouncing(bounces=3, height=0.5, restitution=0.6, rate=500.0):
    """A cube that is dropped flat, and lies still after so many bounces.

    Returns the trial, and the times of its impacts, the last one included.
    """
    speed = np.sqrt(2.0 * G * height)
    times = np.arange(0.0, 2.0, 1.0 / rate)
    heights = height - 0.5 * G * times**2
    impacts = [speed / G]
    for _ in range(bounces):
        speed *= restitution
        since = times - impacts[-1]
        heights = np.where(since > 0.0, speed * since - 0.5 * G * since**2, heights)
        impacts.append(impacts[-1] + 2.0 * speed / G)
    heights = np.where(times > impacts[-1], 0.0, heights)
    positions = np.stack([0.0 * times, 0.0 * times, 0.05 + heights], axis=1)
    return Trial("bounce", times, positions, upright(len(times)), body=CUBE), impacts
