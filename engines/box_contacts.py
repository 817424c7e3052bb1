"""Points at which boxes touch each other and the floor, in double precision, of many pairs at once.

Pairs are sorted by the axis that separates them most (S. Gottschalk, M. C. Lin and D. Manocha,
SIGGRAPH 1996). Where it is the normal of a face, contacts are the corners of the polygon in which
that face and the opposite one overlap, eight at most; where it is normal to an edge of each, they
are the two points at which these edges are nearest. A process that imports nothing of ours takes
this file, too: it needs numpy alone.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.intp]

FLOOR = -1
"""Second of a pair, where it is the floor, z = 0."""

_NEAR = 1e-6
"""Lengths that differ by less are equal [m]; contacts are kept apart by more."""

_PARALLEL = 1e-4
"""Sine of the angle below which two edges have no common normal."""

_SQUARE = np.array([(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)])
_CUBE = np.array([(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])

_ON_A_FACE = 24
"""Candidates of two faces: four corners of each, and crossings of four edges with four lines."""


class Boxes(NamedTuple):
    """Boxes as contacts see them.

    ``centres``: [m], shape (n, 3). ``axes``: of the boxes, in the columns of (n, 3, 3).
    ``halves``: halves of the edges [m], shape (n, 3).
    """

    centres: FloatArray
    axes: FloatArray
    halves: FloatArray


class Contacts(NamedTuple):
    """Points at which pairs touch, or will soon.

    ``first``, ``second``: indices of the boxes, or :data:`FLOOR`. ``feature``: number of the
    corners or edges that touch, which names a contact of a pair as it moves. ``on_first``,
    ``on_second``: points in axes of the world [m]; they differ along the normal alone.
    ``normal``: unit vector from the second to the first.
    """

    first: IndexArray
    second: IndexArray
    feature: IndexArray
    on_first: FloatArray
    on_second: FloatArray
    normal: FloatArray

    @property
    def gaps(self) -> FloatArray:
        """Distances [m]; negative where boxes penetrate each other."""
        gaps: FloatArray = ((self.on_first - self.on_second) * self.normal).sum(axis=1)
        return gaps


def contacts_of(boxes: Boxes, first: IndexArray, second: IndexArray, reach: FloatArray) -> Contacts:
    """Contacts of pairs of boxes, and of boxes with the floor.

    Args:
        boxes: all of them.
        first: index of a box, one a pair.
        second: index of another one, or :data:`FLOOR`.
        reach: gap up to which a contact is reported [m], one a pair.
    """
    low = _lowest(boxes, first)
    on_floor = (second == FLOOR) & (low < reach)
    extents = np.einsum("kij,kj->ki", np.abs(boxes.axes), boxes.halves)
    apart = np.abs(boxes.centres[first] - boxes.centres[second])
    room = extents[first] + extents[second] + reach[:, None]
    between = (second != FLOOR) & (apart < room).all(axis=1)
    parts = [_of_the_floor(boxes, first[on_floor], reach[on_floor])]
    if between.any():
        parts += _of_pairs(boxes, first[between], second[between], reach[between])
    return Contacts(*(np.concatenate(fields) for fields in zip(*parts, strict=True)))


def _lowest(boxes: Boxes, which: IndexArray) -> FloatArray:
    heights = boxes.centres[which, 2]
    lowest: FloatArray = heights - (np.abs(boxes.axes[which, 2]) * boxes.halves[which]).sum(axis=1)
    return lowest


def _of_the_floor(boxes: Boxes, which: IndexArray, reach: FloatArray) -> Contacts:
    shifts = np.einsum("kij,kcj->kci", boxes.axes[which], _CUBE * boxes.halves[which, None])
    corners = boxes.centres[which, None] + shifts
    pair, corner = np.nonzero(corners[:, :, 2] < reach[:, None])
    above = corners[pair, corner]
    below = above * (1.0, 1.0, 0.0)
    normal = np.tile((0.0, 0.0, 1.0), (len(pair), 1))
    return Contacts(which[pair], np.full(len(pair), FLOOR), corner, above, below, normal)


def _of_pairs(
    boxes: Boxes, first: IndexArray, second: IndexArray, reach: FloatArray
) -> tuple[Contacts, Contacts]:
    """Contacts at faces, and at pairs of edges."""
    one, other = boxes.axes[first], boxes.axes[second]
    faces = np.swapaxes(np.concatenate((one, other), axis=2), 1, 2)
    normals = np.cross(faces[:, :3, None], faces[:, None, 3:]).reshape(-1, 9, 3)
    sines = np.linalg.norm(normals, axis=2)
    common = sines > _PARALLEL
    axes = np.concatenate((faces, normals / np.where(common, sines, 1.0)[..., None]), axis=1)
    along = np.einsum("kai,ki->ka", axes, boxes.centres[first] - boxes.centres[second])
    widths = sum(
        (np.abs(axes @ boxes.axes[which]) * boxes.halves[which, None]).sum(axis=2)
        for which in (first, second)
    )
    gaps = np.abs(along) - widths
    gaps[:, 6:][~common] = -np.inf
    gaps[:, 3:6] -= _NEAR  # of two parallel faces always the same one
    gaps[:, 6:] -= 2.0 * _NEAR
    axis = gaps.argmax(axis=1)
    pairs = np.arange(len(first))
    near = gaps[pairs, axis] < reach
    normal = axes[pairs, axis] * np.where(along[pairs, axis] < 0.0, -1.0, 1.0)[:, None]
    face, edge = near & (axis < 6), near & (axis >= 6)
    return (
        _of_faces(boxes, first[face], second[face], axis[face], normal[face], reach[face]),
        _of_edges(boxes, first[edge], second[edge], axis[edge] - 6, normal[edge]),
    )


def _of_faces(
    boxes: Boxes,
    first: IndexArray,
    second: IndexArray,
    axis: IndexArray,
    normal: FloatArray,
    reach: FloatArray,
) -> Contacts:
    """Corners of the polygons in which faces overlap, seen along the normal of one of them."""
    of_first = axis < 3
    base, facing = np.where(of_first, first, second), np.where(of_first, second, first)
    up = np.where(of_first[:, None], -normal, normal)
    x, y, half_x, half_y, middle = _face(boxes, base, axis % 3, up)
    frame = np.stack((x, y, up), axis=1)
    turned = np.einsum("kij,kil->kjl", boxes.axes[facing], up[:, :, None])[..., 0]
    side = np.abs(turned).argmax(axis=1)
    p, q, half_p, half_q, centre = _face(
        boxes, facing, side, -np.sign(np.take_along_axis(turned, side[:, None], 1))
        * _axis(boxes, facing, side),
    )  # fmt: skip
    centre = np.einsum("kij,kj->ki", frame, centre - middle)
    p = np.einsum("kij,kj->ki", frame, p * half_p[:, None])
    q = np.einsum("kij,kj->ki", frame, q * half_q[:, None])
    points, inside = _overlap(centre, p, q, np.stack((half_x, half_y), axis=1))
    pair, candidate = np.nonzero(inside & (points[..., 2] < reach[:, None]))
    local = points[pair, candidate]
    on_facing = middle[pair] + np.einsum("kij,ki->kj", frame[pair], local)
    on_base = on_facing - local[:, 2:] * up[pair]
    flip = of_first[pair, None]
    return Contacts(
        first[pair], second[pair], axis[pair] * _ON_A_FACE + candidate,
        np.where(flip, on_base, on_facing), np.where(flip, on_facing, on_base), normal[pair],
    )  # fmt: skip


def _axis(boxes: Boxes, which: IndexArray, axis: IndexArray) -> FloatArray:
    found: FloatArray = boxes.axes[which, :, axis % 3]
    return found


def _face(
    boxes: Boxes, which: IndexArray, axis: IndexArray, outward: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Directions of the edges of a face, halves of their lengths, and its centre."""
    halves = [boxes.halves[which, (axis + turn) % 3] for turn in range(3)]
    centre = boxes.centres[which] + outward * halves[0][:, None]
    return (
        _axis(boxes, which, axis + 1), _axis(boxes, which, axis + 2), halves[1], halves[2], centre,
    )  # fmt: skip


def _overlap(
    centre: FloatArray, p: FloatArray, q: FloatArray, halves: FloatArray
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Candidates for corners of a polygon, shape (n, 24, 3), and which of them are corners.

    Args:
        centre: of a parallelogram, in the frame of a rectangle, whose normal is z.
        p: half of one of its edges, in that frame.
        q: half of the other one.
        halves: halves of the edges of the rectangle, shape (n, 2).
    """
    own = centre[:, None] + _SQUARE[:, :1] * p[:, None] + _SQUARE[:, 1:] * q[:, None]
    own_inside = np.all(np.abs(own[..., :2]) <= halves[:, None] + _NEAR, axis=2)

    corners = _SQUARE * halves[:, None]
    area = (p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0])[:, None]
    x, y = np.moveaxis(corners - centre[:, None, :2], 2, 0)
    s = (x * q[:, None, 1] - y * q[:, None, 0]) / area
    t = (y * p[:, None, 0] - x * p[:, None, 1]) / area
    lengths = [np.hypot(edge[:, 0], edge[:, 1])[:, None] for edge in (p, q)]
    inside = (np.abs(s) <= 1.0 + _NEAR / lengths[0]) & (np.abs(t) <= 1.0 + _NEAR / lengths[1])
    apart = np.abs(corners[:, :, None] - own[:, None, :, :2]).max(axis=3) > 4.0 * _NEAR
    inside &= (apart | ~own_inside[:, None]).all(axis=2)
    heights = centre[:, None, 2] + s * p[:, None, 2] + t * q[:, None, 2]

    points, valid = [own, np.concatenate((corners, heights[..., None]), axis=2)], [own_inside]
    valid.append(inside)
    ahead = np.roll(own, -1, axis=1)
    for axis in (0, 1):
        for sign in (-1.0, 1.0):
            line = sign * halves[:, None, axis]
            before, behind = own[..., axis] - line, ahead[..., axis] - line
            # An end that is nearer to the line is a corner by itself.
            crosses = (before * behind < 0.0) & (np.minimum(abs(before), abs(behind)) > _NEAR)
            share = before / np.where(crosses, before - behind, 1.0)
            found = own + np.where(crosses, share, 0.0)[..., None] * (ahead - own)
            crosses &= np.abs(found[..., 1 - axis]) < halves[:, None, 1 - axis] - _NEAR
            points.append(found)
            valid.append(crosses)
    return np.concatenate(points, axis=1), np.concatenate(valid, axis=1)


def _of_edges(
    boxes: Boxes, first: IndexArray, second: IndexArray, pair: IndexArray, normal: FloatArray
) -> Contacts:
    """Points at which two edges are nearest, seen along their common normal."""
    middle, u, half_u = _edge(boxes, first, pair // 3, -normal)
    other, v, half_v = _edge(boxes, second, pair % 3, normal)
    between = middle - other
    cosine, along_u, along_v = (
        (a * b).sum(axis=1) for a, b in ((u, v), (u, between), (v, between))
    )
    sine = 1.0 - cosine * cosine
    s = np.clip((cosine * along_v - along_u) / sine, -half_u, half_u)
    t = np.clip((along_v - cosine * along_u) / sine, -half_v, half_v)
    points = 0.5 * (middle + s[:, None] * u + other + t[:, None] * v)
    gap = (between * normal).sum(axis=1)[:, None]
    on_first, on_second = points + 0.5 * gap * normal, points - 0.5 * gap * normal
    return Contacts(first, second, 6 * _ON_A_FACE + pair, on_first, on_second, normal)


def _edge(
    boxes: Boxes, which: IndexArray, axis: IndexArray, towards: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Middle, direction and half the length of the edges that lie farthest in a direction."""
    pairs = np.arange(len(which))
    signs = np.where(np.einsum("kij,ki->kj", boxes.axes[which], towards) < 0.0, -1.0, 1.0)
    signs[pairs, axis] = 0.0
    shift = np.einsum("kij,kj->ki", boxes.axes[which], signs * boxes.halves[which])
    return boxes.centres[which] + shift, _axis(boxes, which, axis), boxes.halves[which, axis]
