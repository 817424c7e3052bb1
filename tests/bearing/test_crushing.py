"""Which boxes are looked at for crushing, and that forces nearest to balance are the nearest."""

import numpy as np
import pytest

from steadyload.bearing import crushing, first_crushed
from steadyload.bearing.forces import Statics
from steadyload.layouts.model import Item, Layout, Pallet
from steadyload.methods.session import LoadingSession


def columns(count, *, limited, most):
    """Columns of two boxes of 1 kg side by side, laid in two layers; one box below has a limit."""
    items = tuple(
        Item(k, (10.0 * (k % count), 10.0 * (k // count), 0.0), (10.0, 10.0, 10.0), 1.0,
             max_load=most if k == limited else None)
        for k in range(2 * count)
    )  # fmt: skip
    return Layout("columns", Pallet(10.0 * count, 100.0, 100.0), items)


@pytest.fixture
def solved(monkeypatch):
    """How many boxes each look solves for."""
    counts = []

    def noted(layout, among=None, supports=None):
        counts.append(len(layout) if among is None else len(among))
        return Statics(layout, among, supports)

    monkeypatch.setattr(crushing, "Statics", noted)
    return counts


def test_a_look_solves_for_what_is_joined_to_the_new_box(solved):
    found = first_crushed(columns(250, limited=7, most=0.5))
    assert (found.step, found.item, found.bears_kg) == (257, 7, pytest.approx(1.0))
    assert solved == [2]


def test_nothing_is_solved_where_too_little_stands_on_a_box(solved):
    assert first_crushed(columns(250, limited=7, most=1.0)) is None
    assert solved == []


def test_a_session_solves_for_what_is_joined_to_the_new_box(solved):
    layout = columns(20, limited=7, most=0.5)
    session = LoadingSession(layout.pallet, "fbs")
    stable = [session.try_place(item).stable for item in layout.items]
    assert stable.index(False) == 27
    assert solved == [2]


def heap(seed):
    """Up to 21 boxes let down at random, some 3 mm above what is below, of which many tip."""
    draw = np.random.default_rng(seed)
    boxes = []
    for k in range(int(draw.integers(12, 22))):
        width, height, depth = draw.choice([10.0, 20.0, 25.0, 30.0], 3).tolist()
        x, z = (5.0 * float(draw.integers(0, (80 - side) // 5 + 1)) for side in (width, depth))
        tops = [
            b.position[1] + b.size[1] for b in boxes
            if b.position[0] < x + width and x < b.position[0] + b.size[0]
            and b.position[2] < z + depth and z < b.position[2] + b.size[2]
        ]  # fmt: skip
        at = (x, max(tops, default=0.0) + float(draw.choice([0.0, 0.0, 0.0, 0.3])), z)
        weight = float(draw.choice([1.0, 5.0, 20.0, 47.3]))
        boxes.append(Item(k, at, (width, height, depth), weight, (0.2 * width * (k % 3), 0.0, 0.0)))
    return Layout(f"heap {seed}", Pallet(80.0, 900.0, 80.0), tuple(boxes))


@pytest.mark.parametrize("seed", [*range(20), 363, 488, 707, 922, 974, 1234, 1351])
def test_no_forces_come_nearer_to_balance_than_the_nearest(seed):
    """The conditions of least squares: no force would rather grow, and none that presses change."""
    statics = Statics(heap(seed))
    rows = np.tile([1.0, 1e-2, 1e-2], len(statics.weights))
    unit = statics.weights.mean()
    forces = statics.nearest() / unit
    matrix = rows[:, None] * statics.matrix * unit
    slope = matrix.T @ (rows * statics.right - matrix @ forces)
    # The energy, which counts 1e-10 beside the squares of weights, is within this.
    least = 1e-6 * np.abs(matrix).sum(axis=0).max()
    assert slope.max() <= least
    assert np.abs(slope[forces > 0.0]).max() <= least
