"""Whole layouts as the C library takes them."""

import pickle

import numpy as np
import pytest

from steadyload.core.constants import CARRIED, FAILS
from steadyload.core.library import Finding, RefusedError, WrongArrayError, finding
from steadyload.core.whole import GivenMany
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.model.batch import LayoutBatch

SIZE = (10.0, 10.0, 10.0)
LEANS = Layout(
    "leans", Pallet(100.0, 100.0, 100.0),
    (Item(0, (0.0, 0.0, 0.0), SIZE, 1.0), Item(1, (6.0, 10.0, 0.0), SIZE, 1.0)),
)  # fmt: skip
FAILING = Finding(FAILS, 1, 1, 1.0)


def test_a_layout_that_was_judged_has_addresses_of_its_own_in_another_process():
    assert LEANS.given.judge(CARRIED, 0.0) == FAILING
    again = pickle.loads(pickle.dumps(LEANS))
    assert again.given.addresses[1:] != LEANS.given.addresses[1:]
    assert again.given._arrays[0] is again.lower
    assert again.given.judge(CARRIED, 0.0) == FAILING


def judged(batch, **changed):
    names = ("starts", "lower", "upper", "weights", "mass_offsets", "floors")
    arrays = {name: getattr(batch, name) for name in names} | changed
    return GivenMany(*arrays.values()).judge(CARRIED, 0.0)


@pytest.mark.parametrize("kind", [np.int32, np.int64])
def test_layouts_of_a_batch_have_the_findings_that_each_has_alone(kind):
    batch = LayoutBatch.of([LEANS, LEANS.first(1), LEANS])
    found = judged(batch, starts=batch.starts.astype(kind))
    assert [finding(found, k) for k in range(3)] == [one.given.judge(CARRIED, 0.0) for one in batch]


@pytest.mark.parametrize("kind", [np.int64, np.uint64])
@pytest.mark.parametrize("starts", [[0, 2, 1, 3], [-1, 2, 3, 3], [0, 1, 2, 2**40], [0, 1, 2, 6]])
def test_starts_that_are_none_are_refused(starts, kind):
    """Differences of unsigned numbers are never below 0."""
    batch = LayoutBatch.of([LEANS, LEANS.first(1), LEANS])
    with pytest.raises(RefusedError):
        judged(batch, starts=np.array(starts).astype(kind))


def test_an_array_of_another_order_is_refused():
    batch = LayoutBatch.of([LEANS, LEANS])
    with pytest.raises(WrongArrayError, match="lower has to be C-contiguous"):
        judged(batch, lower=np.asfortranarray(batch.lower))
