"""Repeated names are found as a set finds them, whatever their number."""

import tracemalloc

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from steadyload.layouts.model import distinct_names
from steadyload.layouts.model.distinct_names import DistinctNames

NAMES = st.lists(st.lists(st.sampled_from([f"n{k}" for k in range(60)]), max_size=12), max_size=12)


@pytest.mark.parametrize("recent", [1, 3, 1000])
@settings(deadline=None)
@given(groups=NAMES)
def test_the_first_repeated_name_is_told(recent, groups):
    seen, names = set(), DistinctNames()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(distinct_names, "_RECENT", recent)
        for group in groups:
            expected, own = None, set(seen)
            for name in group:
                if name in own:
                    expected = name
                    break
                own.add(name)
            assert names.add(group) == expected
            seen.update(group)
            assert bool(names) == bool(seen)
            if expected is not None:
                return


@pytest.mark.parametrize("step", [1, 700, 20_000])
def test_a_repeated_name_is_found_among_many(step):
    names, every = DistinctNames(), [f"layout {k}" for k in range(60_000)]
    for start in range(0, len(every), step):
        assert names.add(every[start : start + step]) is None
    for known in (every[0], every[31_415], every[-1]):
        assert names.add(["another one", known]) == known
        names = DistinctNames()
        names.add(every)


def test_a_name_costs_few_bytes():
    names = DistinctNames()
    tracemalloc.start()
    try:
        for start in range(0, 400_000, 10_000):
            names.add([f"layout {k}" for k in range(start, start + 10_000)])
        held, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert held < 20 * 400_000
