"""Attitudes of many boxes at once: unit quaternions (w, x, y, z) and rotation matrices."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]


def centres_from_mass_centres(
    mass_centres: FloatArray, quaternions: FloatArray, offsets: FloatArray
) -> FloatArray:
    """Geometric centres [m] from centres of mass, shape (n, 3): c = p - R(q) r.

    Args:
        mass_centres: [m], shape (n, 3).
        quaternions: w, x, y, z, shape (n, 4), unit length.
        offsets: centre of mass minus geometric centre in body axes [m], shape (n, 3).
    """
    return mass_centres - rotate(quaternions, offsets) if offsets.any() else mass_centres


def lengths(vectors: FloatArray) -> FloatArray:
    """Euclidean lengths of vectors along the last axis."""
    return np.sqrt((vectors * vectors).sum(axis=-1))


def cross(first: FloatArray, second: FloatArray) -> FloatArray:
    """Cross products of vectors (n, 3), at a fraction of what ``np.cross`` costs for few."""
    (a, b, c), (x, y, z) = first.T, second.T
    found = np.empty_like(first)
    found[:, 0], found[:, 1], found[:, 2] = b * z - c * y, c * x - a * z, a * y - b * x
    return found


def rotate(quaternions: FloatArray, vectors: FloatArray) -> FloatArray:
    """Vectors (n, 3) turned by unit quaternions (n, 4; w, x, y, z)."""
    w, x, y, z = quaternions.T
    vx, vy, vz = vectors.T
    # 2 q x v, written out: np.cross costs more than the whole rotation for a few items.
    tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
    return np.stack(
        (
            vx + w * tx + y * tz - z * ty,
            vy + w * ty + z * tx - x * tz,
            vz + w * tz + x * ty - y * tx,
        ),
        axis=1,
    )


def rotation_vector(quaternion: Sequence[float]) -> tuple[float, float, float]:
    """Axis of a unit quaternion (w, x, y, z), as long as its angle, 0 to pi [rad]."""
    w, *axis = quaternion
    sine = math.hypot(*axis)
    if sine == 0.0:
        return (0.0, 0.0, 0.0)
    x, y, z = (2.0 * math.atan2(math.copysign(sine, w), abs(w)) / sine * part for part in axis)
    return (x, y, z)


def degrees_apart(found: ArrayLike, expected: ArrayLike) -> float:
    """Angle between two attitudes [degrees]; accurate for small ones, as an arc cosine is not.

    Args:
        found: unit quaternion (w, x, y, z), shape (4,); its opposite is the same attitude.
        expected: likewise.
    """
    one, other = np.asarray(found), np.asarray(expected)
    apart = min(float(np.linalg.norm(one - sign * other)) for sign in (1.0, -1.0))
    return math.degrees(4.0 * math.asin(min(1.0, 0.5 * apart)))


def axes_of_quaternion(quaternion: Sequence[float]) -> FloatArray:
    """Rotation matrix (3, 3) of a unit quaternion (w, x, y, z); its columns are the axes."""
    return rotate(np.tile(np.array(quaternion), (3, 1)), np.eye(3)).T


def quaternions_of_axes(axes: FloatArray) -> FloatArray:
    """Unit quaternions (n, 4; w, x, y, z) of rotation matrices (n, 3, 3), with w >= 0.

    By the largest of the four components, as S. W. Shepperd, J. Guidance Control 1 (1978).
    """
    x, y, z = axes[:, 0, 0], axes[:, 1, 1], axes[:, 2, 2]
    squares = np.stack((x + y + z, x - y - z, y - x - z, z - x - y), axis=1)
    products = np.empty((len(axes), 4, 4))
    products[:, range(4), range(4)] = 1.0 + squares
    for a, b, c in ((1, 2, 3), (2, 3, 1), (3, 1, 2)):
        minus = axes[:, c - 1, b - 1] - axes[:, b - 1, c - 1]
        plus = axes[:, c - 1, b - 1] + axes[:, b - 1, c - 1]
        products[:, 0, a] = products[:, a, 0] = minus
        products[:, b, c] = products[:, c, b] = plus
    largest = squares.argmax(axis=1)
    rows = products[np.arange(len(axes)), largest]
    rows /= np.sqrt((rows * rows).sum(axis=1))[:, None]
    rows[rows[:, 0] < 0.0] *= -1.0
    return rows
