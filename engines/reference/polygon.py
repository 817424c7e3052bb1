"""Contact of two boxes: separating axes, and the exact contact polygon with its derivatives.

Everything is seen from the *reference* box, the one whose face carries the contact: coordinates are
along its axes, from its geometric centre. The other box is the *incident* one. Derivatives are by
the incident box's motion relative to the reference box: translation (3 columns), then rotation
about the incident box's centre of mass (3 columns).
"""

from __future__ import annotations

import math

import numpy as np

from steadyload.engines.reference.compilation import compiled

APART, FACE_OF_FIRST, FACE_OF_SECOND, EDGES = 0, 1, 2, 3

CORNERS = 16
"""Room for a clipped polygon: a rectangle cut by four lines has at most eight corners."""

_PARALLEL = 1e-6
"""Sine of the angle below which two edges count as parallel: a face gives the same axis then."""

_SECOND_BIAS = 0.95
"""The second box's face must be this much less deep to carry a contact: between boxes of one size
both are equally deep however they are tilted, and rounding would choose anew at every look."""

_FACING = math.cos(math.radians(15.0))
_EDGE_BIAS = 0.9
_EDGE_DEPTH = 1e-6
"""Two crossing edges carry a contact only where no faces look at each other and every face is
clearly deeper. The corners of a polygon hold the crossing points of faces, too, and spread the load
without a jump; their normal is wrong by the angle between the faces at most."""

_ON_A_LINE = 1e-12
"""A point this close to a clipping plane counts as inside [m]; aligned edges are not cut."""

_SAME_CORNER = 1e-10
"""Corners this close are one [m]."""


@compiled
def separation(first, second, turn, shift):
    """Find the axis along which two boxes overlap least.

    Args:
        first: half edge lengths of the first box [m], shape (3,).
        second: half edge lengths of the second box [m], shape (3,).
        turn: second box's axes in the first's, as columns, shape (3, 3).
        shift: second's centre in the first's frame [m], shape (3,).

    Returns:
        The kind of contact, and the axes concerned: a face's axis, or an edge's axis on each box.
    """
    best, kind, one, two = -math.inf, FACE_OF_FIRST, 0, 0
    for i in range(3):
        reach = first[i]
        for j in range(3):
            reach += second[j] * abs(turn[i, j])
        gap = abs(shift[i]) - reach
        if gap >= 0.0:
            return APART, 0, 0
        if gap > best:
            best, one = gap, i
    for j in range(3):
        reach, along = second[j], 0.0
        for i in range(3):
            reach += first[i] * abs(turn[i, j])
            along += shift[i] * turn[i, j]
        gap = abs(along) - reach
        if gap >= 0.0:
            return APART, 0, 0
        if gap > (best if kind == FACE_OF_SECOND else _SECOND_BIAS * best):
            best, kind, one = gap, FACE_OF_SECOND, j
    limit = _EDGE_BIAS * best + _EDGE_DEPTH
    facing = 0.0
    for k in range(3):
        facing = max(facing, abs(turn[one, k] if kind == FACE_OF_FIRST else turn[k, one]))
    by_edges = facing < _FACING
    for i in range(3):
        i1, i2 = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            sine2 = turn[i1, j] * turn[i1, j] + turn[i2, j] * turn[i2, j]
            if sine2 < _PARALLEL * _PARALLEL:
                continue
            j1, j2 = (j + 1) % 3, (j + 2) % 3
            reach = first[i1] * abs(turn[i2, j]) + first[i2] * abs(turn[i1, j])
            reach += second[j1] * abs(turn[i, j2]) + second[j2] * abs(turn[i, j1])
            gap = abs(shift[i2] * turn[i1, j] - shift[i1] * turn[i2, j]) - reach
            if gap >= 0.0:
                return APART, 0, 0
            gap /= math.sqrt(sine2)
            if by_edges and gap > limit:
                limit, kind, one, two = gap, EDGES, i, j
    return kind, one, two


@compiled
def rigid(point, centre, out):
    """Derivatives of a point fixed to the incident box, shape (3, 6): [1, -r x] about its mass."""
    x, y, z = point[0] - centre[0], point[1] - centre[1], point[2] - centre[2]
    out[:, :] = 0.0
    out[0, 0] = out[1, 1] = out[2, 2] = 1.0
    out[0, 4], out[0, 5] = z, -y
    out[1, 3], out[1, 5] = -z, x
    out[2, 3], out[2, 4] = y, -x


@compiled
def incident_face(second, turn, shift, normal_axis, sign, points):
    """The four corners of the incident box's face that looks against the reference face."""
    k = 0
    for j in range(1, 3):
        if abs(turn[normal_axis, j]) > abs(turn[normal_axis, k]):
            k = j
    side = -second[k] if sign * turn[normal_axis, k] > 0.0 else second[k]
    u, v = (k + 1) % 3, (k + 2) % 3
    for m in range(4):
        a = second[u] if m == 0 or m == 3 else -second[u]
        b = second[v] if m < 2 else -second[v]
        for i in range(3):
            points[m, i] = shift[i] + turn[i, k] * side + turn[i, u] * a + turn[i, v] * b


@compiled
def clip(count, points, slopes, spare, spare_slopes, axis, sign, limit, want):
    """Cut a polygon by the half space ``sign * x[axis] <= limit`` (Sutherland and Hodgman).

    Corners stay in ``points``, their derivatives, if wanted, in ``slopes``; returns their number.
    """
    outside = False
    for m in range(count):
        outside = outside or sign * points[m, axis] - limit > _ON_A_LINE
    if not outside:
        return count
    kept = 0
    for m in range(count):
        n = m + 1 if m + 1 < count else 0
        here = sign * points[m, axis] - limit
        there = sign * points[n, axis] - limit
        if here <= _ON_A_LINE:
            spare[kept] = points[m]
            if want:
                spare_slopes[kept] = slopes[m]
            kept += 1
        if (here <= _ON_A_LINE) != (there <= _ON_A_LINE):
            t = min(1.0, max(0.0, here / (here - there)))
            for i in range(3):
                spare[kept, i] = points[m, i] + t * (points[n, i] - points[m, i])
            if want:
                over = 1.0 / (here - there)
                for c in range(6):
                    here_slope, there_slope = sign * slopes[m, axis, c], sign * slopes[n, axis, c]
                    dt = over * over * (here * there_slope - there * here_slope)
                    for i in range(3):
                        spare_slopes[kept, i, c] = (
                            slopes[m, i, c]
                            + t * (slopes[n, i, c] - slopes[m, i, c])
                            + dt * (points[n, i] - points[m, i])
                        )
            kept += 1
    points[:kept] = spare[:kept]
    if want:
        slopes[:kept] = spare_slopes[:kept]
    return kept


@compiled
def merge_corners(count, points, slopes, one, two, want):
    """Make one of corners that coincide in the plane of axes ``one`` and ``two``."""
    kept = 0
    for m in range(count):
        if kept and _close(points[m], points[kept - 1], one, two):
            continue
        if m == count - 1 and kept and _close(points[m], points[0], one, two):
            continue
        if kept != m:
            points[kept] = points[m]
            if want:
                slopes[kept] = slopes[m]
        kept += 1
    return kept


@compiled
def _close(p, q, one, two):
    return abs(p[one] - q[one]) < _SAME_CORNER and abs(p[two] - q[two]) < _SAME_CORNER


@compiled
def corner_weights(count, points, slopes, one, two, weights, weight_slopes, want):
    """Exterior angle over 2 pi at every corner: the share of the contact that it carries.

    The weights add up to 1, and those of two corners to that of the one they split from, so the
    force is continuous while corners appear, split and merge.
    """
    if count == 1:
        weights[0] = 1.0
        weight_slopes[0, :] = 0.0
        return
    for m in range(count):
        p, n = (m - 1 if m else count - 1), (m + 1 if m + 1 < count else 0)
        ax, ay = points[m, one] - points[p, one], points[m, two] - points[p, two]
        bx, by = points[n, one] - points[m, one], points[n, two] - points[m, two]
        cross = ax * by - ay * bx
        weights[m] = math.atan2(abs(cross), ax * bx + ay * by) / (2.0 * math.pi)
        if want:
            sign = 1.0 if cross >= 0.0 else -1.0
            a2, b2 = 1.0 / (ax * ax + ay * ay), 1.0 / (bx * bx + by * by)
            for c in range(6):
                dax = slopes[m, one, c] - slopes[p, one, c]
                day = slopes[m, two, c] - slopes[p, two, c]
                dbx = slopes[n, one, c] - slopes[m, one, c]
                dby = slopes[n, two, c] - slopes[m, two, c]
                turn = (bx * dby - by * dbx) * b2 - (ax * day - ay * dax) * a2
                weight_slopes[m, c] = sign * turn / (2.0 * math.pi)


@compiled
def crossing(
    first, second, turn, shift, centre, i, j,
    normal, normal_slopes, point, slopes, depth_slopes,
):  # fmt: skip
    """The contact of two crossing edges: its normal (first to second), point and depth.

    Args:
        first: half edge lengths of the first box [m].
        second: half edge lengths of the second box [m].
        turn: the second box's axes in the first's frame.
        shift: the second box's centre in the first's frame [m].
        centre: the second box's centre of mass in the first's frame [m].
        i: the axis of the first box's edge.
        j: the axis of the second box's edge.
        normal: filled in, shape (3,).
        normal_slopes: filled in, its derivatives, shape (3, 6).
        point: filled in [m], shape (3,).
        slopes: filled in, its derivatives, shape (3, 6).
        depth_slopes: filled in, derivatives of the depth, shape (6,).

    Returns:
        The depth [m].
    """
    i1, i2 = (i + 1) % 3, (i + 2) % 3
    # e_i x turn[:, j]
    normal[i], normal[i1], normal[i2] = 0.0, -turn[i2, j], turn[i1, j]
    length = math.sqrt(normal[i1] ** 2 + normal[i2] ** 2)
    towards = normal[i1] * shift[i1] + normal[i2] * shift[i2]
    sign = (1.0 if towards >= 0.0 else -1.0) / length
    normal *= sign
    start, other = np.zeros(3), shift.copy()
    for a in (i1, i2):
        start[a] = first[a] if normal[a] > 0.0 else -first[a]
    for b in range(3):
        if b != j:
            facing = turn[0, b] * normal[0] + turn[1, b] * normal[1] + turn[2, b] * normal[2]
            side = -second[b] if facing > 0.0 else second[b]
            other += side * np.ascontiguousarray(turn[:, b])
    gap = start - other
    cosine, sine2 = turn[i, j], length * length
    along_first = gap[i]
    along_second = gap[0] * turn[0, j] + gap[1] * turn[1, j] + gap[2] * turn[2, j]
    reach = (cosine * along_second - along_first) / sine2
    point[:] = start
    point[i] += reach
    depth = gap[0] * normal[0] + gap[1] * normal[1] + gap[2] * normal[2]
    moved = np.zeros((3, 6))
    rigid(other, centre, moved)
    slopes[:, :] = 0.0
    for c in range(6):
        edge = np.zeros(3)  # derivative of the second edge's direction
        if c >= 3:
            a1, a2 = (c + 1) % 3, (c + 2) % 3
            edge[a1], edge[a2] = -turn[a2, j], turn[a1, j]
        change = np.zeros(3)
        change[i1], change[i2] = -sign * edge[i2], sign * edge[i1]
        along = change[i1] * normal[i1] + change[i2] * normal[i2]
        change -= along * normal
        normal_slopes[:, c] = change
        cosine_slope = edge[i]
        second_slope, depth_slope = 0.0, 0.0
        for a in range(3):
            second_slope += gap[a] * edge[a] - moved[a, c] * turn[a, j]
            depth_slope += change[a] * gap[a] - normal[a] * moved[a, c]
        depth_slopes[c] = depth_slope
        numerator = cosine_slope * along_second + cosine * second_slope + moved[i, c]
        slopes[i, c] = (numerator + 2.0 * cosine * cosine_slope * reach) / sine2
    return depth
