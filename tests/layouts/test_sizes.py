"""Bins of the number of boxes are named by their ends, whatever they hold."""

import pytest

from steadyload.layouts.sizes import FEWER, FINE_SIZES, MOST_SMALL, SIZES, binned


def test_a_bin_holds_what_its_name_says():
    boxes = [25, 37, 38, 61, 62, 99, 100, 101, 150, 151, 180]
    place, names = binned(boxes, (FEWER, *FINE_SIZES))
    assert [*names.values()] == ["25 to 37", "38 to 61", "62 to 100", "101 to 150", "151 to 180"]
    for count, bin_ in zip(boxes, place, strict=True):
        low, high = map(int, names[bin_].split(" to "))
        assert low <= count <= high


@pytest.mark.parametrize(
    ("boxes", "largest", "names"),
    [
        ([3, 6], (4,), ["1 to 4", "5 to 6"]),
        ([5], (4,), ["5"]),
        ([1], (1, 20), ["1"]),
        ([110], (FEWER, *SIZES), ["101 to 150"]),
    ],
)
def test_an_empty_bin_has_no_name(boxes, largest, names):
    assert [*binned(boxes, largest)[1].values()] == names


def test_answers_end_where_labels_begin_to_rest_on_simulations():
    assert MOST_SMALL in SIZES
    assert set(SIZES) <= set(FINE_SIZES)
