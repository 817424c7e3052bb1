"""Loads of an exact number of boxes that stand until one of the last is placed.

Where they fail is a balance of moments about the edge of one support, and no simulation.
"""

import itertools
import math
import random
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from steadyload.layouts import Item, Layout, Pallet

GRAVITY = 9.8
_MIDDLE = 150.0
"""Middle of the floor along both of its axes [cm]; nothing comes near its edges."""


class Build(StrEnum):
    """How the boxes lie that the last few stand on."""

    COLUMNS = "columns"
    BRICKS = "bricks"
    MIXED = "mixed sizes"


class Fall(StrEnum):
    """The event at the planted box.

    ``overhang``: it lies too far out. ``seesaw``: a box that it is put on tips with it. ``slow``
    and ``slow seesaw``: the same, by millimetres, so that it takes most of a second or more.
    ``none`` and ``held seesaw``: 5 mm on the safe side of the edge.
    """

    OVERHANG = "overhang"
    SEESAW = "seesaw"
    SLOW = "slow"
    SLOW_SEESAW = "slow seesaw"
    NONE = "none"
    HELD_SEESAW = "held seesaw"


SLOW = (Fall.SLOW, Fall.SLOW_SEESAW)
STANDING = (Fall.NONE, Fall.HELD_SEESAW)
_SEESAWS = (Fall.SEESAW, Fall.SLOW_SEESAW, Fall.HELD_SEESAW)


@dataclass(frozen=True)
class Planted:
    """A load and what mechanics say about it.

    Attributes:
        layout: the load.
        failing_step: at which it falls; None where it stands.
        past: how far the common centre of mass of what tips lies past the edge of its support then
            [cm]; negative where it does not tip.
        times, angles: of what tips, as a pendulum about the edge [s, degrees].
    """

    layout: Layout
    failing_step: int | None
    past: float
    times: np.ndarray
    angles: np.ndarray

    @property
    def seconds(self) -> float:
        """From the placement until it has turned by 10 degrees; infinite where it stays."""
        return float(np.interp(10.0, self.angles, self.times)) if self.past > 0.0 else math.inf

    def turned(self, seconds: float) -> float:
        """How far it has turned by then [degrees]."""
        return float(np.interp(seconds, self.times, self.angles))


def late_faller(
    boxes: int, build: Build, fall: Fall, *, from_last: int = 0, past: float = 0.2, turns: int = 0
) -> Planted:
    """A load of so many boxes that stands until one of the last.

    Args:
        boxes: their number, 20 or more.
        build: of all but the last few.
        fall: at the planted box.
        from_last: so many boxes are placed after it, on the floor.
        past: how far the slow ones lie past the edge [cm].
        turns: quarter turns of the load about the vertical axis: the direction that it tips in.
    """
    tail = 2 if fall in _SEESAWS else 1
    beneath = boxes - tail - from_last
    placed, edge, top = _BUILDS[build](beneath, random.Random(f"{boxes} {build} {fall} {turns}"))
    by = {Fall.OVERHANG: 5.0, Fall.SEESAW: 2.0}.get(fall, past if fall in SLOW else -0.5)
    # What is low falls at once, and what is tall slowly.
    height = 20.0 if fall in (Fall.OVERHANG, Fall.SEESAW) else 60.0
    tipping = _seesaw(by, height / 2.0) if tail == 2 else [((40.0, height, 20.0), 8.0, by)]
    for size, weight, middle in tipping:
        placed.append((edge + middle - size[0] / 2.0, top, -size[2] / 2.0, *size, weight))
        top += size[1]
    placed += [(-130.0 + 12.0 * k, 0.0, 120.0, 10.0, 10.0, 10.0, 1.0) for k in range(from_last)]
    items = tuple(_item(step, box, turns) for step, box in enumerate(placed))
    assert len(items) == boxes
    centre, times, angles = _pendulum(tipping)
    assert math.isclose(centre, by, abs_tol=1e-9)
    name = f"{boxes} boxes, {build}, {fall}, {from_last} after it, turned {turns}"
    return Planted(
        Layout(name, Pallet(2.0 * _MIDDLE, 400.0, 2.0 * _MIDDLE), items),
        None if fall in STANDING else boxes - 1 - from_last,
        centre,
        times,
        angles,
    )


def _seesaw(by, height):
    """A box whose centre is 6 cm before the edge, and one 12 cm past it on its end: size, weight
    and middle of each, so that both together are past the edge by so much.
    """
    below, inside, outside = 9.0, 6.0, 12.0
    above = below * (inside + by) / (outside - by)
    return [((40.0, height, 20.0), below, -inside), ((12.0, height, 12.0), above, outside)]


def _pendulum(boxes):
    """Centre of mass past the edge [cm], and times [s] and angles [degrees] of the fall. The boxes
    stand on each other, given as size, weight and middle past the edge [cm, kg, cm].
    """
    heights = itertools.accumulate((size[1] for size, _, _ in boxes), initial=0.0)
    whole = sum(weight for _, weight, _ in boxes)
    centre = sum(weight * middle for _, weight, middle in boxes) / whole
    height = inertia = 0.0
    for (size, weight, middle), low in zip(boxes, heights, strict=False):
        up = low + size[1] / 2.0
        height += weight * up / whole
        inertia += weight * ((size[0] ** 2 + size[1] ** 2) / 12.0 + middle**2 + up**2) / whole
    angles = np.concatenate(([0.0], np.geomspace(1e-9, math.radians(12.0), 2000)))
    if centre <= 0.0:
        return centre, np.array([0.0, 1.0]), np.zeros(2)
    lever, start = math.hypot(centre, height), math.atan2(centre, height)
    pull = 100.0 * GRAVITY * lever / inertia
    # By energy: from the speed at every angle. The first bit goes with a steady acceleration.
    speeds = np.sqrt(2.0 * pull * (math.cos(start) - np.cos(start + angles)))
    times = 2.0 * np.diff(angles) / (speeds[1:] + speeds[:-1])
    return centre, np.concatenate(([0.0], np.cumsum(times))), np.degrees(angles)


def _item(step, box, turns):
    """A box as x, y, z, width, height, depth and weight, turned about the middle of the floor."""
    x, y, z, width, height, depth, weight = box
    for _ in range(turns % 4):
        x, z, width, depth = z, -x - width, depth, width
    return Item(step, (x + _MIDDLE, y, z + _MIDDLE), (width, height, depth), weight)


def _columns(count, _):
    """Columns of equal boxes side by side; what is left over stands beside them on the floor."""
    layers, left = divmod(count, 12)
    placed = [
        (30.0 * x - 60.0, 20.0 * y, 25.0 * z - 37.5, 30.0, 20.0, 25.0, 10.0)
        for y in range(layers)
        for x in range(4)
        for z in range(3)
    ]
    return placed + _beside(left), 60.0, 20.0 * layers


def _bricks(count, _):
    """Layers of bricks, each laid across the one below."""
    layers, left = divmod(count, 12)
    placed = []
    for y in range(layers):
        along, across = ((40.0, 20.0), (20.0, 40.0))[y % 2]
        placed += [
            (along * x - 60.0, 12.0 * y, across * z - 40.0, along, 12.0, across, 6.0)
            for x in range(round(120.0 / along))
            for z in range(round(80.0 / across))
        ]
    return placed + _beside(left), 60.0, 12.0 * layers


def _mixed(count, random):
    """Columns of boxes of all sizes and weights, each a little out of the middle of the one below;
    the planted box comes on a column of its own.
    """
    layers, left = divmod(count, 12)
    placed, tops = [], {}
    for _, x, z in itertools.product(range(layers), range(4), range(3)):
        planted = (x, z) == (3, 1)
        width, depth = (27.0, 27.0) if planted else random.choices(range(18, 28), k=2)
        off = [0.0, 0.0] if planted else [random.uniform(-1.0, 1.0) for _ in range(2)]
        middle = 30.0 * x - 45.0 + off[0], 30.0 * z - 30.0 + off[1]
        height, low = random.choice((10.0, 14.0, 18.0, 22.5)), tops.get((x, z), 0.0)
        tops[x, z] = low + height
        corner = middle[0] - width / 2.0, low, middle[1] - depth / 2.0
        placed.append((*corner, width, height, depth, random.uniform(2.0, 20.0)))
    # It tips outwards over the edge of its column, above all others.
    tall = max(tops.values()) - tops[3, 1] + 10.0
    x, y, z, width, height, *rest = placed[-2]
    placed[-2] = (x, y, z, width, height + tall, *rest)
    return placed + _beside(left), 45.0 + 13.5, tops[3, 1] + tall


_BUILDS = {Build.COLUMNS: _columns, Build.BRICKS: _bricks, Build.MIXED: _mixed}


def _beside(count):
    """Boxes on the floor, side by side and away from all others."""
    return [(-130.0 + 14.0 * k, 0.0, -130.0, 14.0, 14.0, 14.0, 3.0) for k in range(count)]
