"""Balance with forces at side faces and with friction, for the steps where vertical forces fail."""

from __future__ import annotations

import math
from enum import StrEnum

import numpy as np

from steadyload.core.constants import EDGE
from steadyload.layouts.model.layout import TOLERANCE, Arrangement, FloatArray
from steadyload.statics.least_squares import nonnegative_least_squares
from steadyload.statics.resolution import is_balanced, unresolved
from steadyload.statics.touching import Points, directions, touching_points, wrenches

_RESIDUE = 1e-8
"""As in :mod:`steadyload.statics.balance`; there are many more columns here."""

FINEST = 64
"""Edges of the finest pyramids of an exact cone: they differ by 0.12 % in friction."""


class Sides(StrEnum):
    """Contact forces at side faces that touch.

    ``none``: none; only vertical forces anywhere. ``frictionless``: they push; horizontal faces
    have friction. ``friction``: they push and rub.
    """

    NONE = "none"
    FRICTIONLESS = "frictionless"
    FRICTION = "friction"


def unbalanced_item(
    layout: Arrangement,
    step: int,
    sides: Sides,
    friction: float,
    facets: int,
    *,
    exact: bool = False,
) -> int | None:
    """The item whose balance cannot be met at a step, or None when forces exist for all.

    Args:
        layout: any layout.
        step: the item placed last; those joined to it by touching, at any face, are asked.
        sides: what side faces do, not ``none``.
        friction: Coulomb coefficient, 0 or more.
        facets: edges of the pyramid inside a friction cone, 3 or more.
        exact: refine pyramids inside and around the cones, up to :data:`FINEST` edges, until both
            give the same answer; what they still dispute then counts as balanced.

    Raises:
        UnresolvedError: the weights lie too far apart for an answer.
    """
    group = _joined(layout, step)
    points = touching_points(layout, group, grow=EDGE)
    rough = (points.axes == 1) | (sides is Sides.FRICTION)
    coefficients = np.where(rough, friction, 0.0)
    edges = facets
    while True:
        item = _fastest(layout, group, points, coefficients, edges)
        if item is None or not exact or not friction:
            return item
        # What pyramids around the cones cannot balance, the cones cannot.
        wider = coefficients / math.cos(math.pi / edges)
        item = _fastest(layout, group, points, wider, edges)
        if item is not None or edges >= FINEST:
            return item
        edges = min(2 * edges, FINEST)


def _joined(layout: Arrangement, step: int) -> list[int]:
    """Items joined to the new one by touching, directly or over others."""
    lower, upper = layout.lower[: step + 1], layout.upper[: step + 1]
    gaps = np.maximum(lower[:, None] - upper[None], lower[None] - upper[:, None]).max(axis=2)
    touching = gaps <= TOLERANCE
    joined = np.zeros(step + 1, dtype=bool)
    joined[step] = True
    while True:
        grown = joined | touching[joined].any(axis=0)
        if (grown == joined).all():
            return np.flatnonzero(joined).tolist()
        joined = grown


def _fastest(
    layout: Arrangement, group: list[int], points: Points, friction: FloatArray, facets: int
) -> int | None:
    """The item that starts fastest under the best forces; None when nothing starts."""
    masses = layout.weights[group] / layout.weights[group].mean()
    sizes = (layout.upper - layout.lower)[group]
    centres = (0.5 * (layout.lower + layout.upper) + layout.mass_offsets)[group]
    squares = sizes**2
    radii = np.sqrt((squares.sum(axis=1, keepdims=True) - squares) / 12.0)
    root = np.sqrt(masses)[:, None] * np.concatenate((np.ones_like(radii), radii), axis=1)
    target = np.zeros((len(group), 6))
    target[:, 1] = root[:, 1]
    loads = target
    if len(points):
        point, force = directions(points.axes, friction, facets)
        matrix = wrenches(points, points.positions, centres, point, force) / root[:, :, None]
        flat = matrix.reshape(target.size, -1)
        found, residue = nonnegative_least_squares(flat, target.ravel())
        loads = target + (np.abs(flat) @ found).reshape(target.shape)
        target = residue.reshape(target.shape)

    def motions(left: FloatArray) -> FloatArray:
        start = np.abs(left / root)
        return start[:, :3].sum(axis=1) + (start[:, 3:] * sizes).sum(axis=1)

    motion = motions(target)
    stands = is_balanced(motion, motions(loads), masses, _RESIDUE)
    if stands is None:
        raise unresolved(layout.weights[group])
    return None if stands else group[int(motion.argmax())]
