"""Convex hulls in the horizontal plane (x, z), as plain numbers: fast for a few points."""

from __future__ import annotations

Point = tuple[float, float]
"""(x, z) [cm]."""


def strictly_inside_hull(point: Point, corners: list[Point], least: float) -> bool:
    """True if a point lies strictly inside the convex hull of points in the plane.

    Args:
        point: the point [cm].
        corners: any points [cm].
        least: the cross product of every edge and the way to the point must exceed this [cm2].
    """
    hull = convex_hull(corners)
    if len(hull) < 3:
        return False
    x, z = point
    return all(
        (bx - ax) * (z - az) - (bz - az) * (x - ax) > least
        for (ax, az), (bx, bz) in zip(hull, hull[1:] + hull[:1], strict=True)
    )


def convex_hull(points: list[Point]) -> list[Point]:
    """Corners of the convex hull, counter-clockwise (Andrew's monotone chain)."""

    def chain(ordered: list[Point]) -> list[Point]:
        line: list[Point] = []
        for x, z in ordered:
            while len(line) > 1:
                (ax, az), (bx, bz) = line[-2:]
                if (bx - ax) * (z - az) - (bz - az) * (x - ax) > 0.0:
                    break
                line.pop()
            line.append((x, z))
        return line[:-1]

    ordered = sorted(set(points))
    return chain(ordered) + chain(ordered[::-1])
