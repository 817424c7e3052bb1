"""Which boxes are looked at for crushing, how long, and that the nearest forces are the nearest."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from piles import top_below, wall

from steadyload import time_limit
from steadyload.app.checking import Answer, check
from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.methods.contract import stopwatch
from steadyload.methods.contract.method import Status
from steadyload.methods.session.session import LoadingSession
from steadyload.statics.bearing import forces, looks
from steadyload.statics.bearing.crushing import first_crushed
from steadyload.statics.bearing.forces import Statics


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

    def noted(layout, among=None, *others):
        counts.append(len(layout) if among is None else len(among))
        return Statics(layout, among, *others)

    monkeypatch.setattr(looks, "Statics", noted)
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


@pytest.fixture
def slow_looks(monkeypatch):
    """A clock that stands still but for looks at what boxes bear: each takes a second."""
    now = 0.0

    class Slow(Statics):
        def __init__(self, *arguments):
            nonlocal now
            now += 1.0
            super().__init__(*arguments)

    clock = SimpleNamespace(
        process_time=lambda: now, thread_time=lambda: now, perf_counter=lambda: now
    )
    monkeypatch.setattr(looks, "Statics", Slow)
    for module in (stopwatch, time_limit):
        monkeypatch.setattr(module, "time", clock)


def test_a_check_does_not_look_for_crushed_boxes_longer_than_it_may(slow_looks):
    layout = columns(2, limited=1, most=0.5)
    late, crushed = (check(layout, "fbs", timeout=limit) for limit in (0.5, 1.5))
    assert (late.answer, late.verdict.status) == (Answer.NOT_JUDGED, Status.TIMEOUT)
    assert late.reason == "no verdict within 0.5 s of CPU time"
    assert (crushed.answer, crushed.crushed.item) == (Answer.FAILS, 1)


def test_a_load_that_falls_fails_however_long_a_look_takes(slow_looks):
    layout = columns(2, limited=1, most=0.5)
    over = Item(4, (5.0, 20.0, 0.0), (100.0, 10.0, 10.0), 1.0)
    wide = Pallet(200.0, 100.0, 100.0)
    load = Layout("over", wide, (*layout.items, over))
    assert check(load, "fbs", timeout=0.5).answer is Answer.FAILS


def test_nothing_is_looked_at_after_the_step_at_which_a_load_falls(solved):
    boxes = columns(2, limited=1, most=0.5).items
    hanging = replace(boxes[2], position=(0.0, 30.0, 0.0))
    load = Layout("hanging", Pallet(20.0, 100.0, 100.0), (*boxes[:2], hanging, boxes[3]))
    found = check(load, "fbs")
    assert (found.verdict.failing_step, found.crushed, solved) == (2, None, [])


@pytest.mark.parametrize("timed", [True, False])
def test_a_session_does_not_look_for_crushed_boxes_longer_than_it_may(slow_looks, timed):
    layout = columns(2, limited=1, most=0.5)
    for limit, status in ((0.5, Status.TIMEOUT), (1.5, Status.DONE)):
        session = LoadingSession(layout.pallet, "fbs", timeout=limit, timed=timed)
        verdicts = [session.try_place(item) for item in layout.items]
        assert [verdict.stable for verdict in verdicts] == [True, True, True, False]
        assert verdicts[-1].status is status
        assert len(session) == 3


class _OverError(Exception):
    """Time is up."""


@pytest.fixture
def unsolved(monkeypatch):
    """The solver of cones finds nothing."""
    monkeypatch.setattr(forces, "solve_cones", lambda *_: None)
    monkeypatch.setattr(forces, "is_solved", lambda _: False)


def test_a_search_for_forces_ends_when_time_is_up_where_the_solver_fails(unsolved):
    test_a_search_for_forces_ends_when_time_is_up(Statics.nearest)


@pytest.mark.parametrize("seek", [Statics.least_energy, Statics.nearest])
def test_a_search_for_forces_ends_when_time_is_up(seek):
    def is_up():
        raise _OverError

    with pytest.raises(_OverError):
        seek(Statics(wall(12, 8), check_time=is_up))


def test_looks_one_after_the_other_find_what_a_single_look_does():
    layout, most = wall(9, 6), 8.4
    limited = replace(layout, items=tuple(replace(item, max_load=most) for item in layout.items))
    borne = [
        Statics(first).tops() @ Statics(first).least_energy()
        for first in map(layout.first, range(1, len(layout) + 1))
    ]
    step = next(k for k, loads in enumerate(borne) if loads.max() > most)
    found = first_crushed(limited)
    assert (found.step, found.item) == (step, int(borne[step].argmax()))
    assert found.bears_kg == pytest.approx(borne[step].max(), rel=1e-9)


def test_five_thousand_interlocked_boxes_balance():
    layout = wall(50, 101)
    assert len(layout) == 5025
    statics = Statics(layout)
    found = statics.least_energy()
    assert np.abs(statics.matrix @ found - statics.right).max() <= 1e-7
    assert statics.matrix.nnz <= 24 * len(statics.pairs)
    # What all of the lowest bear is what stands on them.
    assert (statics.tops() @ found)[:101].sum() == pytest.approx(5025.0 - 101.0)


def heap(seed, fewest=12, most=21):
    """Boxes let down at random, some 3 mm above what is below, of which many tip."""
    draw = np.random.default_rng(seed)
    boxes = []
    for k in range(int(draw.integers(fewest, most + 1))):
        width, height, depth = draw.choice([10.0, 20.0, 25.0, 30.0], 3).tolist()
        x, z = (5.0 * float(draw.integers(0, (80 - side) // 5 + 1)) for side in (width, depth))
        top = top_below(boxes, x, z, width, depth)
        at = (x, top + float(draw.choice([0.0, 0.0, 0.0, 0.3])), z)
        weight = float(draw.choice([1.0, 5.0, 20.0, 47.3]))
        boxes.append(Item(k, at, (width, height, depth), weight, (0.2 * width * (k % 3), 0.0, 0.0)))
    return Layout(f"heap {seed}", Pallet(80.0, 2000.0, 80.0), tuple(boxes))


@pytest.mark.parametrize(
    "load",
    [
        *(heap(seed) for seed in (*range(20), 363, 488, 707, 922, 974, 1234, 1351)),
        *(heap(seed, 30, 45) for seed in range(6)),
    ],
    ids=lambda load: f"{load.name}, {len(load)} boxes",
)
def test_no_forces_come_nearer_to_balance_than_the_nearest(load):
    """The conditions of least squares: no force would rather grow, and none that presses change."""
    statics = Statics(load)
    rows = np.outer(1.0 / statics.weights, (1.0, 1e-2, 1e-2)).ravel()
    unit = statics.weights.mean()
    found = statics.nearest() / unit
    matrix = rows[:, None] * statics.matrix.toarray() * unit
    slope = matrix.T @ (rows * statics.right - matrix @ found)
    # The energy, which counts 1e-10 beside the squares of weights, is within this.
    least = 1e-6 * np.abs(matrix).sum(axis=0).max()
    assert slope.max() <= least
    assert np.abs(slope[found > 0.0]).max() <= least


@pytest.mark.parametrize(("fails", "nearness"), [(False, 1e-3), (True, 1e-4)])
@pytest.mark.parametrize("seed", range(6))
def test_forces_of_many_boxes_come_as_near_to_balance_as_those_of_few(
    seed, fails, nearness, request, monkeypatch
):
    """The two ways in which they are found, also where the solver fails."""
    if fails:
        request.getfixturevalue("unsolved")
    statics = Statics(heap(seed, 30, 45))
    one = statics.tops() @ statics.nearest()
    monkeypatch.setattr(forces, "_FEW", 0)
    other = statics.tops() @ statics.nearest()
    assert other == pytest.approx(one, abs=nearness * one.max())
    assert not np.array_equal(other, one)
