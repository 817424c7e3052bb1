"""The binding of loadings that are followed, and of many layouts: what it takes and refuses."""

import gc
from itertools import pairwise

import numpy as np
import pytest

from steadyload.core.constants import BALANCED, FAILS, STANDS, UNDECIDED
from steadyload.core.library import RefusedError, WrongArrayError, finding
from steadyload.core.timed import (
    Followed,
    Held,
    How,
    closest_to_balance,
    first_moved,
    first_moved_many,
)
from steadyload.core.whole import Given, GivenMany

HOW = How(0.5, 981.0, 0.3, 10.0, 10.0)
LOWER = np.array([[0.0, 0.0, 0.0], [8.0, 10.0, 0.0]])
"""Two boxes of 10 cm: the second one has its centre of mass past the edge of the first."""
PLANE = np.array([-np.inf, -np.inf, np.inf, np.inf, 0.0])
ARRAYS = LOWER, LOWER + 10.0, np.ones(2), np.zeros((2, 3))


@pytest.fixture
def leaning():
    return Given(*ARRAYS, PLANE)


def many(starts, layouts=2):
    twice = (np.concatenate((each, each)) for each in ARRAYS)
    return GivenMany(starts, *twice, np.tile(PLANE, (layouts, 1)))


def test_a_box_that_tips_is_followed(leaning):
    loading = Followed(leaning)
    assert loading.group(0).ended == STANDS
    ended, kept, items = loading.group(1)
    assert (ended, kept, items.tolist()) == (FAILS, False, [1])
    moved = loading.moved(1, items, HOW)
    assert (moved.ended, moved.item) == (FAILS, 1)
    assert moved.beyond > 1.0
    assert loading.beyond.tolist() == [0.0, moved.beyond]
    assert loading.counts.tolist() == [0, 1]
    assert first_moved(leaning, np.inf, HOW) == moved


def test_work_is_limited(leaning):
    assert first_moved(leaning, 0.0, HOW).ended == UNDECIDED
    assert Followed(leaning, limit=0.0).first(0, 2, HOW).ended == UNDECIDED


def test_arrays_can_be_seen_longer_than_the_loading_is_kept(leaning):
    loading = Followed(leaning, 0.5)
    loading.group(0)
    loading.group(1)
    seen, expected = loading.moves, loading.moves.copy()
    del loading
    gc.collect()
    [Followed(leaning) for _ in range(100)]
    assert seen.tolist() == expected.tolist() == [False, True]


def test_what_a_loading_keeps_can_be_written_to(leaning):
    loading = Followed(leaning)
    loading.answers[:] = 7, 8
    loading.solved[1], loading.farthest[1] = True, 100.0
    loading.group(1)
    assert loading.answers.tolist() == [7, 8]
    loading.solved[0], loading.farthest[0] = True, 100.0
    loading.group(1)  # comes where the first one was
    assert loading.answers.tolist() == [0, 8]


def test_no_box_beyond_the_last_is_placed(leaning):
    loading, held = Followed(leaning), Held(leaning)
    for step in (-1, 2):
        for call in (
            lambda step=step: loading.group(step), lambda step=step: held.place(step),
            lambda: loading.first(0, 3, HOW), lambda: loading.first(-1, 2, HOW),
            lambda step=step: loading.moved(step, np.array([0], np.int32), HOW),
            lambda step=step: held.group(step),
            lambda step=step: loading.moved(1, np.array([step], np.int32), HOW),
        ):  # fmt: skip
            with pytest.raises(RefusedError):
                call()


def test_held_boxes_are_balanced_whatever_came_before(leaning):
    held = Held(leaning)
    assert held.place(0) == (STANDS, -1)
    assert held.place(1) == (FAILS, 1)
    assert held.group(1).tolist() == [1]
    assert Held(leaning, 6.0).place(0) == (STANDS, -1)


def test_forces_come_closest_to_balance(leaning):
    items, used = np.array([1], np.int32), np.array([[0, 1, 0]], np.int32)
    found = closest_to_balance(leaning, items, used, np.array([[8.0, 0.0, 10.0, 10.0]]), 0.0)
    assert (found.ended, found.item, found.is_found) == (FAILS, 1, True)
    found = closest_to_balance(leaning, items, used, np.array([[8.0, 0.0, 18.0, 10.0]]), 0.0)
    assert (found.ended, found.item) == (STANDS, -1)
    assert found.forces.sum() == pytest.approx(1.0)
    with pytest.raises(RefusedError):
        closest_to_balance(leaning, items, used + 1, np.zeros((1, 4)), 0.0)
    with pytest.raises(WrongArrayError, match=r"items is .* required: int32 of shape \(1,\)"):
        closest_to_balance(leaning, items.astype(np.int64), used, np.zeros((1, 4)), 0.0)


def test_many_layouts_are_judged_as_one_by_one(leaning):
    for starts in ([0, 2, 4], [0, 1, 4], [1, 1, 3]):
        batch = many(np.array(starts))
        moved, found = first_moved_many(batch, np.inf, HOW), batch.judge(BALANCED, 0.0)
        for k, (first, end) in enumerate(pairwise(starts)):
            twice = (np.concatenate((each, each))[first:end] for each in ARRAYS)
            alone = Given(*twice, PLANE)
            one = first_moved(alone, np.inf, HOW)
            assert (one.ended, one.step, one.shift, one.turn) == tuple(
                moved[k][["ended", "step", "shift", "turn"]].item()
            )
            assert alone.judge(BALANCED, 0.0) == finding(found, k)


@pytest.mark.parametrize("starts", [[0, 2, 5], [-1, 2, 4], [0, 3, 2], [0]])
def test_starts_have_to_fit_the_boxes(starts):
    with pytest.raises((RefusedError, WrongArrayError)):
        many(np.array(starts))


def test_arrays_have_to_be_as_c_takes_them():
    lower, upper, weights, offsets = ARRAYS
    with pytest.raises(WrongArrayError, match="upper is"):
        Given(lower, upper[:1], weights, offsets, PLANE)
    with pytest.raises(WrongArrayError, match="lower has to be C-contiguous"):
        Given(np.asfortranarray(lower), upper, weights, offsets, PLANE)
    with pytest.raises(WrongArrayError, match="weights is"):
        Given(lower, upper, weights.astype(np.float32), offsets, PLANE)
