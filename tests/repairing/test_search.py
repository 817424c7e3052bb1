"""The search for the nearest plan that stands: is it the nearest, and is all else kept?"""

from collections import Counter
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from exhaustive import best_worth
from hypothesis import given, settings
from hypothesis import strategies as st
from plans import (
    DEPTH,
    GRID,
    WIDTH,
    failing_plan,
    random_plan,
    reordered,
    standing_plan,
    with_first,
)

from steadyload.layouts.model.layout import TOLERANCE, Item, Layout, Pallet
from steadyload.methods import make_method
from steadyload.properties.transforms import quarter_turned
from steadyload.repairing.confirmed import (
    Confirmation,
    ConfirmedSearch,
    Stopped,
    _is_better,
    changed_plan,
)
from steadyload.repairing.places import Places
from steadyload.repairing.plan import Boxes, Kind, Worth, kept_in_order
from steadyload.statics.bearing.crushing import first_crushed

MARGIN = 0.5
ALL = frozenset(Kind)
KEEPING = ALL - {Kind.LEAVE}
FEW = settings(max_examples=6, derandomize=True)


def balanced(plan):
    """A judge that asks for the margin that the search has for moved boxes."""
    verdict = make_method(f"equilibrium:margin={MARGIN}").judge(plan)
    at_fault = () if verdict.stable else (verdict.failing_step, verdict.item_at_fault)
    return Confirmation(verdict.stable, at_fault)


def search(plan, allowed=ALL, *, judge=balanced, seed=0, seconds=60.0, shift=30.0):
    return ConfirmedSearch(Boxes(plan), allowed, shift, seed, judge, seconds).run()


def found(plan, allowed=ALL, **how):
    """The changed plan, and the steps that its boxes had."""
    attempt = search(plan, allowed, **how).attempt
    assert attempt is not None
    return changed_plan(Boxes(plan), attempt), attempt


# --- the best -------------------------------------------------------------------------------------


def assert_none_is_better(plan, most_moved, **how):
    """No plan on a grid leaves out fewer boxes or moves fewer; none is much nearer."""
    least = best_worth(plan, margin=MARGIN, grid=GRID, most_moved=most_moved, **how)
    attempt = search(plan).attempt
    assert attempt is not None
    if least is None:
        assert attempt.worth.left > 0 or attempt.worth.moved > most_moved
        return None
    own, other = attempt.worth, least
    assert (own.left, own.volume, own.moved) <= (other.left, other.volume, other.moved)
    if own.moved == other.moved:
        assert own.distance <= 1.25 * other.distance + MARGIN
    return other


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("boxes", [3, 4])
def test_no_plan_with_one_moved_box_is_missed(boxes, seed):
    assert_none_is_better(failing_plan(seed, boxes), 1, most_left=0)


@pytest.mark.parametrize("seed", range(8))
def test_no_plan_with_one_moved_box_of_six_is_missed(seed):
    assert_none_is_better(failing_plan(seed, 6), 1, most_left=0)


@pytest.mark.parametrize("seed", range(6))
def test_no_plan_with_two_moved_boxes_is_missed(seed):
    assert_none_is_better(failing_plan(seed, 4), 2, most_left=1)


def test_plans_that_one_moved_box_repairs_are_among_those_that_are_tried():
    least = [
        best_worth(failing_plan(seed, 4), margin=MARGIN, grid=GRID, most_moved=1, most_left=0)
        for seed in range(8)
    ]
    assert sum(worth is not None and worth.moved == 1 for worth in least) >= 3


def test_a_plan_is_better_with_fewer_moved_boxes_or_with_as_many_that_are_clearly_nearer():
    now = Worth(left=0, volume=0.0, moved=2, distance=10.0, reordered=0)
    for more, better in (
        ({"moved": 1, "distance": 50.0}, True),
        ({"moved": 3, "distance": 1.0}, False),
        ({"left": 1, "volume": 5.0, "moved": 0, "distance": 0.0}, False),
        ({"distance": 5.0}, True),
        ({"distance": 9.999}, False),
        ({"reordered": 1}, False),
    ):
        assert _is_better(replace(now, **more), now) == better


# --- what is kept ---------------------------------------------------------------------------------


def let_down_from_above(plan, origins, order):
    """Whether no box has to pass another one, unless both are where and when they were."""
    for turn, other in ((b, a) for a, b in combinations(range(len(order)), 2)):
        low, high = order.lower[turn], order.upper[turn]
        shared = np.minimum(order.upper[other], high) - np.maximum(order.lower[other], low)
        is_over = order.lower[other, 1] >= high[1] - TOLERANCE
        if min(shared[0], shared[2]) > TOLERANCE and is_over:
            both = [
                order.items[k].position == plan.items[origins[k]].position for k in (turn, other)
            ]
            if not all(both) or origins[other] > origins[turn]:
                return False
    return True


@FEW
@given(seed=st.integers(0, 10**6), boxes=st.integers(1, 9), limits=st.booleans())
def test_a_changed_plan_keeps_all_that_is_to_be_kept(seed, boxes, limits):
    plan = random_plan(seed, boxes, limits=limits)
    changed, attempt = found(plan)  # a layout cannot overlap, or stand out of the contour
    assert balanced(changed).stands
    assert first_crushed(changed) is None
    assert len(set(attempt.order)) == len(attempt.order) == len(plan) - attempt.worth.left
    assert let_down_from_above(plan, attempt.order, changed)
    for item, step in zip(changed.items, attempt.order, strict=True):
        was = plan.items[step]
        assert (item.name, item.weight, item.max_load) == (was.name, was.weight, was.max_load)
        assert item.size[1] == was.size[1]
        assert item.size in (was.size, was.size[::-1])


def test_a_changed_plan_crushes_no_box():
    plan = random_plan(1, 5, limits=True)
    assert any(item.max_load is not None for item in plan.items)
    changed, _ = found(plan)
    assert first_crushed(changed) is None


@pytest.mark.parametrize("seed", range(4))
def test_no_box_stands_out_over_the_deck_further_than_in_the_plan(seed):
    plan = failing_plan(seed, 7, overhang=10.0)
    widest = replace(plan.items[0], position=(-4.0, 0.0, 0.0), size=(5.0, 5.0, 5.0), name="out")
    for tried, low in ((plan, 0.0), (with_first(plan, widest), -4.0)):
        if tried is None:
            continue
        changed, _ = found(tried)
        assert changed.lower[:, 0].min() >= low - TOLERANCE
        assert changed.lower[:, 2].min() >= -TOLERANCE
        assert (changed.upper[:, ::2].max(axis=0) <= (WIDTH + TOLERANCE, DEPTH + TOLERANCE)).all()


@FEW
@given(seed=st.integers(0, 10**6), boxes=st.integers(2, 7))
def test_a_fixed_order_stays(seed, boxes):
    plan = random_plan(seed, boxes)
    _, attempt = found(plan, ALL - {Kind.ORDER})
    assert list(attempt.order) == sorted(attempt.order)


@FEW
@given(
    seed=st.integers(0, 10**6),
    allowed=st.sets(st.sampled_from(sorted(KEEPING)), min_size=1).map(frozenset),
)
def test_nothing_changes_that_may_not(seed, allowed):
    plan = random_plan(seed, 5)
    changed, attempt = found(plan, allowed | {Kind.LEAVE}, shift=6.0)
    for item, step in zip(changed.items, attempt.order, strict=True):
        was = plan.items[step]
        middle = [0.5 * size for size in was.size]
        way = np.array(item.position) + 0.5 * np.array(item.size) - was.position - middle
        if Kind.TURN not in allowed:
            assert item.size == was.size
        if Kind.MOVE not in allowed:
            assert np.hypot(way[0], way[2]) <= (6.0 if Kind.SHIFT in allowed else 0.0) + 1e-6
            assert way[1] <= TOLERANCE
            assert way[1] == 0.0 or Kind.DROP in allowed


@pytest.mark.parametrize("seed", range(4))
def test_a_plan_that_another_order_repairs_moves_no_box(seed):
    plan = standing_plan(seed, 8)
    upside_down = reordered(plan, range(7, -1, -1))
    assert not balanced(upside_down).stands
    changed, attempt = found(upside_down)
    assert attempt.worth.moved == attempt.worth.left == 0
    assert attempt.worth.reordered > 0
    places = {item.name: item.position for item in plan.items}
    assert {item.name: item.position for item in changed.items} == places


# --- the judge ------------------------------------------------------------------------------------


def test_a_box_that_the_judge_finds_at_fault_is_moved():
    plan = standing_plan(1, 6)

    def judge(changed):
        still = [i.sequence for i in changed.items if i.name == "box-2" and
                 i.position == plan.items[2].position and i.size == plan.items[2].size]  # fmt: skip
        return Confirmation(not still, tuple(still))

    changed, attempt = found(plan, KEEPING, judge=judge)
    assert judge(changed).stands
    assert attempt.worth.moved >= 1


def test_where_the_judge_confirms_nothing_there_is_no_plan():
    asked = []

    def judge(changed):
        asked.append(changed)
        return Confirmation(False, (0,))

    result = search(random_plan(1, 5), KEEPING, judge=judge)
    assert result.attempt is None
    assert result.judged == len(asked) > 5


def test_an_interrupt_leaves_the_best_plan_so_far():
    plan, answers = failing_plan(2, 10), iter((True,))

    def judge(changed):
        if (answer := next(answers, None)) is None:
            raise KeyboardInterrupt
        return Confirmation(answer)

    result = search(plan, judge=judge)
    if result.stopped is Stopped.INTERRUPTED:
        assert result.attempt is not None

    def at_once(changed):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        search(plan, judge=at_once)


def test_no_time_is_no_plan():
    result = search(failing_plan(2, 10), seconds=1e-6)
    assert (result.attempt, result.stopped) == (None, Stopped.TIME)


@pytest.mark.parametrize("seed", [0, 7])
def test_the_same_seed_finds_the_same_plan(seed):
    plan = failing_plan(11, 12)
    one, other = (search(plan, seed=seed) for _ in range(2))
    assert one == other
    assert (one.attempt.places == other.attempt.places).all()


def test_where_no_box_may_be_elsewhere_each_plan_that_is_tried_is_judged():
    plan = failing_plan(2, 10)
    result = search(plan, {Kind.ORDER, Kind.LEAVE})
    assert result.attempt.worth.left > 0
    assert result.tried == result.judged


def test_the_answer_on_the_plan_that_is_found_is_handed_on():
    answers = []

    def judge(changed):
        answers.append((changed, balanced(changed)))
        return answers[-1][1]

    plan = failing_plan(11, 12)
    result = search(plan, judge=judge)
    changed = changed_plan(Boxes(plan), result.attempt)
    assert [
        said
        for asked, said in answers
        if said is result.confirmation and asked.items == changed.items
    ]


# --- parts ----------------------------------------------------------------------------------------


@given(st.permutations(range(7)))
def test_boxes_that_keep_their_turn_are_a_longest_ascending_part(order):
    kept = kept_in_order(order)
    assert kept == sorted(kept)
    assert Counter(kept) <= Counter(order)
    places = [order.index(box) for box in kept]
    assert places == sorted(places)
    longer = (part for part in combinations(order, len(kept) + 1))
    assert not any(list(part) == sorted(part) for part in longer)


@FEW
@given(seed=st.integers(0, 10**6), boxes=st.integers(2, 9))
def test_free_places_are_free_and_carried(seed, boxes):
    plan = random_plan(seed, boxes, floating=0.0, shuffled=0.0)
    box, others = plan.items[-1], slice(0, boxes - 1)
    lower, upper = plan.lower[others], plan.upper[others]
    size, own = np.array(box.size), Boxes(plan)
    found, far = own.given.places_among(
        own.planned, np.zeros(boxes, dtype=bool), boxes - 1, MARGIN, own.limits,
        np.array([np.inf, -np.inf, np.inf]), 1, 4000,
    )  # fmt: skip
    none, _ = own.given.places_among(
        own.planned, np.zeros(boxes, dtype=bool), boxes - 1, MARGIN, own.limits,
        np.array([np.inf, -np.inf, np.inf]), 1, 0,
    )  # fmt: skip
    assert len(none) == 0
    made = found[:, :3]
    assert far == pytest.approx(np.linalg.norm(made - box.position, axis=1))
    assert (made == box.position).all(axis=1).any()
    for place in made:
        shared = np.minimum(upper, place + size) - np.maximum(lower, place)
        assert not (shared > TOLERANCE).all(axis=1).any()
        below = (shared[:, ::2] > TOLERANCE).all(axis=1) & (
            np.abs(upper[:, 1] - place[1]) <= TOLERANCE
        )
        assert place[1] <= TOLERANCE or below.any()
        least, most = (np.array(corner) for corner in plan.pallet.contour)
        assert (place >= least - TOLERANCE).all()
        assert (place + size <= most + TOLERANCE).all()


@pytest.mark.parametrize(("depth", "turns"), [(10.0, {0.0, 1.0}), (20.0, {0.0})])
def test_a_box_is_turned_where_its_sides_differ(depth, turns):
    items = (Item(0, (0.0, 0.0, 0.0), (20.0, 10.0, depth), 4.0),)
    boxes = Boxes(Layout("one", Pallet(60.0, 60.0, 60.0), items))
    found, far = Places(boxes, ALL, 30.0).of(0, boxes.planned, MARGIN)
    assert {*found[:, 3].tolist()} == turns
    assert far.tolist() == sorted(far.tolist())
    assert {*Places(boxes, ALL - {Kind.TURN}, 30.0).of(0, boxes.planned, MARGIN)[0][:, 3]} == {0.0}


@pytest.mark.parametrize("offset", [(1.0, 2.0, 3.0), (0.0, 0.0, 0.5)])
def test_a_turned_box_is_turned_with_its_centre_of_mass(offset):
    item = Item(0, (4.0, 0.0, 6.0), (20.0, 10.0, 12.0), 4.0, offset)
    plan = Layout("one", Pallet(60.0, 60.0, 60.0), (item,))
    found = Boxes(plan).item(0, [7.0, 0.0, 9.0, 1.0])
    [turned] = quarter_turned(plan).items
    assert (found.size, found.mass_offset) == (turned.size, turned.mass_offset)
    assert found.position == (7.0, 0.0, 9.0)
