"""The checks in C against NumPy, SciPy, other code paths, and themselves in many threads."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from piles import top_below
from scipy.optimize import nnls
from scipy.spatial import ConvexHull
from vertical_balance import VerticalBalance, equations, solve

from steadyload.core import forces
from steadyload.core.constants import CARRIED, FAILS, STANDS
from steadyload.core.timed import Followed, closest_to_balance
from steadyload.core.whole import Given
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.contacts import FLOOR, Patch
from steadyload.layouts.model.layout import TOLERANCE
from steadyload.methods import make_method
from steadyload.methods.contract.method import Finding, NotBatchedError, Seconds
from steadyload.methods.contract.spec import parse_spec
from steadyload.methods.rules.base_support import FullBaseSupport
from steadyload.methods.threads import evaluate_in_threads
from steadyload.numbers import NumberError
from steadyload.statics import balance
from steadyload.statics.resolution import fastest

PLANE = np.array([-np.inf, -np.inf, np.inf, np.inf, 0.0])
BATCHED = ("fbs", "pbs0.7", "sme", "equilibrium", "equilibrium:time=0.3")


@pytest.fixture(scope="module")
def layouts():
    """Labelled cases, and pallets of many boxes whose decks have edges."""
    labelled = load_benchmark()
    cases = labelled.select("validation", limit=200)
    small = [labelled.layout(*case) for case in cases[["layout", "scenario"]].to_numpy()]
    return [*small, *(heap(seed, floor) for seed in range(6) for floor in ("infinite", "deck"))]


def heap(seed, floor, count=60):
    """Boxes of few sizes, let down one after the other somewhere over the pallet and its edges."""
    draw = np.random.default_rng(seed)
    boxes = []
    for k in range(count):
        width, height, depth = draw.choice([20.0, 30.0, 40.0], 3)
        x, z = draw.integers(-1, 10, 2) * 10.0
        at = (x, top_below(boxes, x, z, width, depth), z)
        boxes.append(Item(k, at, (width, height, depth), float(draw.uniform(1.0, 20.0))))
    pallet = Pallet(100.0, 5000.0, 100.0, overhang=50.0, floor=floor)
    return Layout(f"heap {seed}", pallet, tuple(boxes))


def test_contacts_are_those_of_all_pairs(layouts):
    for layout in layouts:
        found, count, floor = layout.given.contacts(), len(layout), layout.floor
        patches = np.split(found.patches, found.starts[1:-1])
        below = np.split(found.below, found.starts[1:-1])
        above = np.split(found.above, found.above_starts[1:-1])
        carries = np.zeros((count, count), dtype=bool)
        for j in range(count):
            base = Rectangle(*layout.lower[j, ::2], *layout.upper[j, ::2])
            edges = Rectangle(*floor.low, *floor.high)
            low = layout.lower[j, 1] <= TOLERANCE
            inside = base.outside(edges) <= TOLERANCE
            assert found.on_floor[j] == (low and inside)
            expected = [(FLOOR, base.shared(edges))] if low and not inside else []
            expected += [
                (i, base.shared(Rectangle(*layout.lower[i, ::2], *layout.upper[i, ::2])))
                for i in range(count) if abs(layout.upper[i, 1] - layout.lower[j, 1]) <= TOLERANCE
            ]  # fmt: skip
            expected = [(i, shared) for i, shared in expected if shared.narrower > TOLERANCE]
            assert below[j].tolist() == [i for i, _ in expected]
            assert patches[j].tolist() == [list(shared) for _, shared in expected]
            carries[[i for i, _ in expected if i != FLOOR], j] = True
        assert [each.tolist() for each in above] == [
            np.flatnonzero(row).tolist() for row in carries
        ]


class Rectangle(NamedTuple):
    """Seen from above."""

    x0: float
    z0: float
    x1: float
    z1: float

    @property
    def narrower(self):
        return min(self.x1 - self.x0, self.z1 - self.z0)

    def shared(self, other):
        low = max(self.x0, other.x0), max(self.z0, other.z0)
        return Rectangle(*low, min(self.x1, other.x1), min(self.z1, other.z1))

    def outside(self, other):
        """How far it stands out over the edges of another."""
        before = max(other.x0 - self.x0, other.z0 - self.z0)
        return max(before, self.x1 - other.x1, self.z1 - other.z1)


@pytest.mark.parametrize("name", BATCHED)
def test_a_batch_is_judged_as_one_by_one(name, layouts):
    method = make_method(name)
    found = method.evaluate(LayoutBatch.of(layouts))
    arrays = found.status, found.failing_step, found.displacement, found.rotation
    for layout, status, step, shift, turn in zip(layouts, *arrays, strict=True):
        verdict = method.judge(layout)
        assert (status, step) == (verdict.status, _step(verdict))
        assert (None if np.isnan(shift) else shift) == verdict.displacement
        assert (None if np.isnan(turn) else turn) == verdict.rotation
    assert 0.1 < (found.failing_step >= 0).mean() < 0.9


def _step(verdict):
    return -1 if verdict.failing_step is None else verdict.failing_step


@pytest.mark.parametrize("name", BATCHED)
def test_threads_that_judge_one_batch_get_equal_answers(name, layouts):
    batch, method = LayoutBatch.of(layouts * 20), make_method(name)
    alone = method.evaluate(batch).failing_step
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(method.evaluate, [batch] * 8))
    assert all((each.failing_step == alone).all() for each in found)


@pytest.mark.parametrize("name", BATCHED)
@pytest.mark.parametrize("threads", [1, 2, 7, 1000])
def test_a_batch_in_threads_is_judged_as_in_one(name, threads, layouts):
    batch, method = LayoutBatch.of(layouts), make_method(name)
    alone, found = method.evaluate(batch), evaluate_in_threads(method, batch, threads)
    for key in ("status", "failing_step", "displacement", "rotation"):
        np.testing.assert_array_equal(getattr(found, key), getattr(alone, key))
    assert (found.finding is None) == (alone.finding is None)
    if alone.finding is not None:
        for k in np.flatnonzero(alone.failing_step >= 0).tolist():
            assert found.finding(k) == alone.finding(k) == method._judge(batch[k], None)
    with pytest.raises(NumberError, match=r"threads is 0; allowed"):
        evaluate_in_threads(method, batch, 0)
    assert len(evaluate_in_threads(method, batch[:0], threads).status) == 0


def _judged(verdicts):
    return [replace(verdict, cpu=Seconds(), wall=Seconds()) for verdict in verdicts]


@pytest.mark.parametrize("name", BATCHED)
def test_many_are_judged_at_once_as_one_by_one(name, layouts, monkeypatch):
    method = make_method(name)
    expected = _judged(map(method.judge, layouts))
    batch = LayoutBatch.of(layouts)
    assert _judged(method.judge_many(batch)) == expected
    assert all(verdict.cpu.total > 0.0 for verdict in method.judge_many(batch))
    looked_at, judge = [], method._judge
    monkeypatch.setattr(method, "_judge", lambda *of: looked_at.append(of[0]) or judge(*of))
    assert _judged(method.judge_many(iter(layouts))) == expected
    failing = [x.content_hash() for x, v in zip(layouts, expected, strict=True) if not v.stable]
    again = [] if method.evaluate(batch).finding else failing
    assert [layout.content_hash() for layout in looked_at] == again
    assert method.judge_many([]) == []


@pytest.mark.parametrize("name", BATCHED)
def test_threads_that_judge_parts_of_one_batch_get_the_verdicts_of_the_whole(name, layouts):
    batch, method = LayoutBatch.of(layouts * 8), make_method(name)
    bounds = np.linspace(0, len(batch), 9).astype(int)
    parts = [batch[i:j] for i, j in pairwise(bounds.tolist())]
    expected = _judged(method.judge_many(layouts)) * 8
    with ThreadPoolExecutor(8) as pool:
        verdicts = pool.map(method.judge_many, parts)
        steps = pool.map(method.evaluate, parts)
        assert [v for part in verdicts for v in _judged(part)] == expected
        found = np.concatenate([part.failing_step for part in steps])
    assert found.tolist() == list(map(_step, expected))


def test_what_judges_one_at_a_time_judges_a_batch_one_by_one(layouts):
    method = make_method("equilibrium:time=0.3")
    expected = _judged(map(method.judge, layouts[:9]))
    assert _judged(method.judge_many(LayoutBatch.of(layouts[:9]))) == expected


class StandsAlone(FullBaseSupport):
    """Judges layouts in another way than the class that judges batches."""

    def _judge(self, layout, watch):
        return Finding(failing_step=0)


def test_a_class_that_judges_in_its_own_way_does_not_judge_batches_as_its_base(layouts):
    method = StandsAlone(parse_spec("fbs"), FullBaseSupport.Parameters())
    assert [v.failing_step for v in method.judge_many(layouts)] == [0] * len(layouts)
    with pytest.raises(NotBatchedError):
        method.evaluate(LayoutBatch.of(layouts))


def test_a_batch_of_nothing_has_no_verdicts():
    for name in BATCHED:
        assert len(make_method(name).evaluate(LayoutBatch.of([])).status) == 0


def test_what_judges_one_at_a_time_says_so(layouts):
    for name in ("equilibrium:time=0.3,sides=frictionless", "equilibrium:sides=frictionless"):
        with pytest.raises(NotBatchedError, match="judges one layout at a time"):
            make_method(name).evaluate(LayoutBatch.of(layouts))


def test_weights_that_hide_balance_have_no_verdict_in_a_batch():
    pallet = Pallet(100.0, 100.0, 100.0)
    boxes = ((0, 0, 0, 1.0), (20, 0, 0, 1.0), (5, 10, 0, 1e-9), (5, 20, 0, 1e6))
    light = Layout("light", pallet, tuple(
        Item(k, (x, y, z), (10.0 if k < 2 else 20.0, 10.0, 10.0), weight)
        for k, (x, y, z, weight) in enumerate(boxes)
    ))  # fmt: skip
    verdict = make_method("equilibrium").judge(light)
    found = make_method("equilibrium").evaluate(LayoutBatch.of([light]))
    assert (found.status[0], found.failing_step[0]) == (verdict.status, _step(verdict))


def test_balance_is_that_of_the_forces_kept_from_step_to_step(layouts):
    method, solved = make_method("equilibrium"), 0
    for layout in layouts:
        verdict, numpy = method.judge(layout), VerticalBalance(layout)
        items = (numpy.place(step) for step in range(len(layout)))
        found = next(((k, item) for k, item in enumerate(items) if item is not None), (None, None))
        assert found == (verdict.failing_step, verdict.moved_item)
        solved += numpy.solved
    assert solved > 3


def test_steps_behind_one_that_fails_are_balanced_as_in_numpy(layouts):
    failing = behind = 0
    for layout in layouts:
        compiled, numpy = balance.VerticalBalance(layout), VerticalBalance(layout)
        found = [compiled.place(step) for step in range(len(layout))]
        assert found == [numpy.place(step) for step in range(len(layout))]
        fails = [step for step, item in enumerate(found) if item is not None]
        failing += bool(fails)
        behind += len(fails[1:])
        assert compiled.group(len(layout) - 1) == numpy.group(len(layout) - 1)
    assert failing > 50
    assert behind > 100


@pytest.mark.parametrize("grow", [1e-5, 0.0, -0.5, -6.0, 10.0])
def test_a_group_is_solved_as_in_numpy(layouts, grow):
    ends = set()
    for layout in layouts:
        supports, last = layout.supports, len(layout) - 1
        group = supports.joined(last, floor=False)
        patches = [patch for item in group for patch in supports.below[item]]
        found = balance.solve(layout, group, patches, grow)
        centres = 0.5 * (layout.lower + layout.upper) + layout.mass_offsets
        sizes = layout.upper - layout.lower
        expected = solve(group, patches, layout.weights, centres, sizes, grow)
        ends.add(found.ended)
        assert expected.balanced == {STANDS: True, FAILS: False}.get(found.ended)
        if found.ended == FAILS:
            assert found.item == group[fastest(expected.motion)]
        else:
            firm = [patch.below not in group for patch in patches]
            assert found.forces[firm].sum() == pytest.approx(layout.weights[group].sum())
    assert ends >= {STANDS, FAILS} or grow < -1.0


def test_of_items_that_fail_alike_the_first_is_named():
    assert fastest(np.array([0.3, 1.0, 1.0 + 1e-12, 0.9])) == 1
    assert fastest(np.array([0.3, 1.0, 1.0 + 1e-6, 0.9])) == 2


def test_least_squares_are_those_of_scipy():
    draw = np.random.default_rng(1)
    for trial in range(500):
        rows, count = draw.integers(1, 25), draw.integers(1, 60)
        matrix = draw.normal(size=(rows, count)) * (draw.random((rows, count)) < 0.4)
        matrix = np.concatenate((matrix, matrix[:, :3]), axis=1)  # some stand there twice
        within = np.abs(draw.normal(size=count + min(3, count)))
        target = matrix @ within if trial % 2 else draw.normal(size=rows)
        found, rest, ended = forces.least_squares(np.ascontiguousarray(matrix.T), target)
        expected, _ = nnls(matrix, target, maxiter=50 * count)
        assert ended
        assert (found >= 0.0).all()
        assert rest == pytest.approx(target - matrix @ found, abs=1e-10)
        assert rest == pytest.approx(target - matrix @ expected, abs=1e-10)


@settings(max_examples=200, deadline=None)
@given(seed=st.integers(0, 10**6), boxes=st.integers(1, 12), count=st.integers(1, 30))
def test_forces_at_any_patches_are_those_of_scipy(seed, boxes, count):
    """Also between boxes that are not near them, at patches that are there twice."""
    draw = np.random.default_rng(seed)
    lower, sizes = draw.uniform(0.0, 30.0, (boxes, 3)), draw.uniform(5.0, 20.0, (boxes, 3))
    weights, offsets = draw.uniform(1.0, 20.0, boxes), draw.uniform(-2.0, 2.0, (boxes, 3))
    items = draw.permutation(boxes)[: int(draw.integers(1, boxes + 1))].astype(np.int32)
    low = draw.uniform(0.0, 30.0, (count, 2))
    corners = np.column_stack([low, low + draw.uniform(1.0, 20.0, (count, 2))])
    above = draw.choice(items, count)
    below = draw.integers(-1, boxes, count)
    used = np.column_stack([np.arange(count), above, np.where(below == above, FLOOR, below)])
    used[count // 2] = used[0]
    layout = Given(lower, lower + sizes, weights, offsets, PLANE)
    found = closest_to_balance(layout, items, used.astype(np.int32), corners, 0.0)
    patches = [Patch(under, over, *corners[place]) for place, over, under in used.tolist()]
    centres = lower + 0.5 * sizes + offsets
    matrix, target, _ = equations(items.tolist(), patches, weights, centres, sizes, 0.0)
    x = found.forces.ravel() / weights[items].mean()
    rest = target - matrix @ x
    assert found.is_found
    assert (x >= 0.0).all()
    assert is_least(matrix, x, rest)
    expected, _ = nnls(matrix, target, maxiter=200 * count)
    of_scipy = target - matrix @ expected
    if is_least(matrix, expected, of_scipy):  # rarely SciPy ends where it is not
        assert rest == pytest.approx(of_scipy, abs=1e-9)


def test_balance_does_not_depend_on_the_corners_that_are_expected_to_press(layouts):
    draw, solved = np.random.default_rng(5), 0
    for layout in layouts:
        own = Given(
            layout.lower, layout.upper, layout.weights, layout.mass_offsets, layout.floor.corners
        )
        plain, other = Followed(own), Followed(own)
        for step in range(len(layout)):
            other.pressing[:] = draw.random(other.pressing.shape) < 0.5
            first, second = plain.group(step), other.group(step)
            assert first.ended == second.ended
            assert first.items.tolist() == second.items.tolist()
            assert plain.moves.tolist() == other.moves.tolist()
            solved += first.ended == FAILS
    assert solved > 100


def is_least(matrix, found, rest):
    """Whether a solution meets the conditions of Karush, Kuhn and Tucker, which no other does."""
    slope = matrix.T @ rest
    return slope.max() < 1e-9 and np.abs(slope[found > 0.0]).max(initial=0.0) < 1e-9


def test_a_point_is_inside_the_hull_that_qhull_finds():
    """By the rule that asks for it: a plate on posts, whose centre of mass is that point."""
    draw = np.random.default_rng(2)
    inside = 0
    for _ in range(600):
        posts = draw.permutation(36)[: int(draw.integers(1, 12))]
        at, wide = np.column_stack(np.divmod(posts, 6)), float(draw.choice([0.02, 0.5, 1.0]))
        x, z = draw.uniform(0.0, 5.0 + wide, 2)
        lower, sizes = np.zeros((len(posts) + 1, 3)), np.ones((len(posts) + 1, 3))
        lower[:-1, ::2], sizes[:-1, ::2] = at, wide
        lower[-1], sizes[-1] = (-1.0, 1.0, -1.0), (8.0, 1.0, 8.0)
        offsets = np.zeros_like(lower)
        offsets[-1, ::2] = x - 3.0, z - 3.0
        corners = np.concatenate([at + wide * np.array(way) for way in np.ndindex(2, 2)])
        expected = (ConvexHull(corners).equations @ [x, z, 1.0] < 0.0).all()
        load = Given(lower, lower + sizes, np.ones(len(lower)), offsets, PLANE)
        found = load.judge(CARRIED, 0.0)
        assert (found.ended == STANDS) == expected
        inside += expected
    assert 150 < inside < 450
