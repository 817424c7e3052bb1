"""Contacts of boxes against convex polygons, distances of convex sets, and mirrored pairs."""

import math

import numpy as np
import pytest
from scipy.optimize import lsq_linear
from scipy.spatial import ConvexHull, HalfspaceIntersection
from scipy.spatial.transform import Rotation

from steadyload.engines.box_contacts import FLOOR, Boxes, contacts_of

CUBE = (0.5, 0.5, 0.5)


def contacts(centres, turns, halves, first=(0,), second=(1,), reach=1e-3):
    boxes = Boxes(
        np.array(centres, float), Rotation.concatenate(turns).as_matrix(), np.array(halves, float)
    )
    pairs = np.array(first), np.array(second)
    return contacts_of(boxes, *pairs, np.full(len(first), reach))


def upright(degrees=0.0):
    return Rotation.from_euler("z", degrees, degrees=True)


def distance(centre, turn, halves, other, other_turn, other_halves):
    """Of two boxes, by least squares over the points of both."""
    axes = np.hstack((turn.as_matrix(), -other_turn.as_matrix()))
    most = np.concatenate((halves, other_halves))
    found = lsq_linear(axes, np.subtract(other, centre), (-most, most), tol=1e-14)
    return math.sqrt(2.0 * found.cost)


def corners_of_overlap(shift, degrees, halves, other):
    """Corners of the polygon in which two rectangles overlap, by half planes."""
    lines = []
    for centre, angle, (x, y) in (((0.0, 0.0), 0.0, halves), (shift, degrees, other)):
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        for normal, width in (((c, s), x), ((-s, c), y)):
            along = np.dot(normal, centre)
            lines += [(*normal, -along - width), (*np.negative(normal), along - width)]
    inside = np.array(shift) * 0.5
    points = HalfspaceIntersection(np.array(lines), inside).intersections
    return points[ConvexHull(points).vertices]


@pytest.mark.parametrize("degrees", [0.0, 7.0, 45.0, 90.0, 171.0])
@pytest.mark.parametrize("shift", [(0.3, 0.1), (-0.7, 0.45), (0.2, -0.7)])
@pytest.mark.parametrize("below", [True, False])
def test_flat_faces_touch_at_the_corners_of_their_overlap(degrees, shift, below):
    low, high = (0.5, 0.4, 0.2), (0.6, 0.7, 0.1)
    expected = corners_of_overlap(shift, degrees, low[:2], high[:2])
    gap = 2e-4
    scene = [((0.0, 0.0, 0.2), upright(), low), ((*shift, 0.5 + gap), upright(degrees), high)]
    found = contacts(*zip(*(scene if below else scene[::-1]), strict=True))
    assert len(found.feature) == len(set(found.feature.tolist())) == len(expected)
    for points, height in ((found.on_first, 0.4), (found.on_second, 0.4 + gap)):
        height = height if below else 0.8 + gap - height
        assert points[:, 2] == pytest.approx(height, abs=1e-12)
        for corner in expected:
            assert np.abs(points[:, :2] - corner).max(axis=1).min() < 1e-9
    assert found.gaps == pytest.approx(gap, abs=1e-12)
    assert found.normal[:, 2] == pytest.approx(-1.0 if below else 1.0)


@pytest.mark.parametrize("degrees", [0.0, 90.0, 180.0])
def test_flush_faces_touch_at_each_corner_once(degrees):
    """Edges lie upon each other: a corner is one of either box, and where edges cross."""
    centres = [(0.0, 0.0, 0.5), (0.0, 0.0, 1.5)]
    found = contacts(centres, [upright(), upright(degrees)], [CUBE, CUBE])
    assert len(found.feature) == 4
    expected = [(x, y, 1.0) for x in (-0.5, 0.5) for y in (-0.5, 0.5)]
    assert sorted(np.round(found.on_first, 9).tolist()) == sorted(map(list, expected))
    long = contacts(centres, [upright(), upright(degrees)], [CUBE, (0.5, 2.0, 0.5)])
    assert len(long.feature) == 4


@pytest.mark.parametrize("seed", range(12))
def test_the_least_gap_is_the_distance_of_the_boxes(seed):
    """Any attitudes, moved together until they are a tenth of a millimetre apart or overlap."""
    random = np.random.default_rng(seed)
    turns = list(Rotation.random(2, rng=random))
    halves = random.uniform(0.05, 0.4, (2, 3))
    way = random.normal(size=3)
    way /= np.linalg.norm(way)
    near, far = 0.0, 2.0
    while far - near > 1e-13:
        middle = 0.5 * (near + far)
        apart = distance(middle * way, turns[0], halves[0], np.zeros(3), turns[1], halves[1])
        near, far = (middle, far) if apart < 1e-4 else (near, middle)
    found = contacts([far * way, np.zeros(3)], turns, halves)
    assert found.gaps.min() == pytest.approx(1e-4, rel=1e-3)
    closest = int(found.gaps.argmin())
    for box, point in ((0, found.on_first[closest]), (1, found.on_second[closest])):
        centre = (far * way, np.zeros(3))[box]
        local = turns[box].inv().apply(point - centre)
        assert (np.abs(local) < halves[box] + 1e-7).all(), "a point is on its box"
    deeper = contacts(
        [(far - 2e-4 / abs(way @ found.normal[closest])) * way, np.zeros(3)], turns, halves
    )
    assert deeper.gaps.min() == pytest.approx(-1e-4, rel=0.02)


def test_pairs_are_the_same_seen_from_either_box():
    random = np.random.default_rng(7)
    count = 40
    centres = random.uniform(-0.3, 0.3, (count, 3))
    turns = list(Rotation.random(count, rng=random))
    halves = random.uniform(0.05, 0.2, (count, 3))
    first, second = np.triu_indices(count, 1)
    one = contacts(centres, turns, halves, first, second)
    other = contacts(centres, turns, halves, second, first)
    assert len(one.gaps) > 200
    for pair in {*zip(one.first.tolist(), one.second.tolist(), strict=True)}:
        here = (one.first == pair[0]) & (one.second == pair[1])
        there = (other.second == pair[0]) & (other.first == pair[1])
        assert np.sort(one.gaps[here]) == pytest.approx(np.sort(other.gaps[there]), abs=1e-12)
        assert one.normal[here][0] == pytest.approx(-other.normal[there][0], abs=1e-12)


def test_corners_touch_the_floor_where_they_are_near_it():
    turn = Rotation.from_euler("x", 45.0, degrees=True)
    height = 0.5 * math.sqrt(2.0) + 5e-4
    found = contacts([(0.0, 0.0, height)], [turn], [CUBE], (0,), (FLOOR,))
    assert found.gaps == pytest.approx([5e-4, 5e-4])
    assert sorted(found.on_second[:, 0]) == pytest.approx([-0.5, 0.5])
    assert (found.on_second[:, 2] == 0.0).all()
    assert not len(contacts([(0.0, 0.0, height + 1e-3)], [turn], [CUBE], (0,), (FLOOR,)).gaps)


@pytest.mark.parametrize("shift", [(1.1, 0.0, 0.0), (0.0, 0.0, -1.1), (0.9, 0.9, 1.1)])
def test_what_is_apart_has_no_contact(shift):
    found = contacts([(0.0, 0.0, 0.0), shift], [upright(), upright(30.0)], [CUBE, (0.3, 0.3, 0.3)])
    assert not len(found.gaps)
