"""The front of cost and loss: what nothing cheaper is as good as."""

import numpy as np
import pytest

from steadyload.statistics.front import undominated


@pytest.mark.parametrize(
    ("entries", "front"),
    [
        ([(1, 5), (2, 5), (3, 4)], [(1, 5), (3, 4)]),  # as good, and dearer
        ([(1, 5), (1, 4)], [(1, 4)]),  # as cheap, and better
        ([(2, 1), (1, 2)], [(1, 2), (2, 1)]),
        ([(1, 1), (1, 1)], [(1, 1)]),
        ([], []),
    ],
)
def test_of_two_alike_in_one_the_better_in_the_other_stays(entries, front):
    assert undominated(entries, lambda e: e[0], lambda e: e[1]) == front


def test_of_equals_the_first_stays():
    one, other = [1.0, 1.0], [1.0, 1.0]
    (kept,) = undominated([one, other], lambda e: e[0], lambda e: e[1])
    assert kept is one


@pytest.mark.parametrize("seed", range(5))
def test_it_is_what_comparing_all_pairs_finds(seed):
    entries = [tuple(e) for e in np.random.default_rng(seed).integers(0, 6, (30, 2)).tolist()]
    kept = undominated(entries, lambda e: e[0], lambda e: e[1])
    free = {
        e for e in entries
        if not any(o != e and o[0] <= e[0] and o[1] <= e[1] for o in entries)
    }  # fmt: skip
    assert set(kept) == free
    assert len(kept) == len(free)
