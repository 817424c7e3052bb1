"""What lies outside the range that a network was trained on, quantity by quantity."""

import math

import pytest

from steadyload.layouts import Item, Layout, Pallet
from steadyload.learners.features import FeatureKind
from steadyload.learners.ranges import QUANTITIES, SLACK, TrainedRanges, extents_of, quantities_of

WIDE = {name: [0.0, 1e6] for name in QUANTITIES}

LAYOUT = Layout(
    "five",
    Pallet(120.0, 100.0, 80.0),
    tuple(
        Item(k, (20.0 * k, 0.0, 0.0), (20.0, 16.0, 40.0), 2.0 if k < 3 else 8.0, (1.6, 0.0, 0.0))
        for k in range(5)
    ),
)
FOUND = {
    "longest pallet side": 120.0,
    "shortest side": 16.0,
    "longest side": 40.0,
    "weight": 2.0,
    "shift of the centre of mass": 0.08,
    "heaviest over lightest": 1.0,
    "overhang": 0.0,
}
"""Of the first item, or of the layout, by hand."""


def outside(**ranges):
    return TrainedRanges(WIDE | ranges, FeatureKind.PLAIN)


def test_every_quantity_is_counted_from_its_least_to_its_greatest():
    assert list(FOUND) == list(QUANTITIES)
    assert outside().outside(LAYOUT) == ""
    assert outside().steps_inside(LAYOUT) == 5


@pytest.mark.parametrize("name", [name for name in QUANTITIES if FOUND[name] > 0.0])
def test_a_quantity_outside_is_named_at_either_end(name):
    value = FOUND[name]
    of = "the layout" if name == "longest pallet side" else "item 0"
    for ends in ([value * 1.2, 1e6], [0.0, value / 1.2]):
        said = outside(**{name: ends}).outside(LAYOUT)
        assert said.startswith(f"{of}: {name} is {value:g}"), said
    for ends in ([value * (1.0 + 0.9 * SLACK), 1e6], [0.0, value / (1.0 + 0.9 * SLACK)]):
        said = outside(**{name: ends}).outside(LAYOUT)
        assert not said.startswith(f"{of}: {name}"), "within the slack"


def test_quantities_beyond_a_range_are_those_that_a_sentence_names():
    extents = extents_of([LAYOUT])
    assert not outside().beyond(extents).any()
    low, high = extents[0]
    for k, name in enumerate(QUANTITIES):
        for ends in ([low[k] * 1.2 + 1.0, 1e7], [-2.0, high[k] / 1.2 - 0.1]):
            found = outside(**{name: ends}).beyond(extents)
            assert found.tolist() == [[other == k for other in range(len(QUANTITIES))]]


def test_the_first_steps_inside_end_before_what_is_outside():
    assert outside(**{"longest pallet side": [1.0, 60.0]}).steps_inside(LAYOUT) == 0
    assert outside(weight=[0.0, 4.0]).steps_inside(LAYOUT) == 3
    assert outside(**{"heaviest over lightest": [1.0, 2.0]}).steps_inside(LAYOUT) == 3


def test_no_number_of_items_lies_outside():
    """Weights of earlier versions state one; it limits nothing."""
    ranges = outside(items=[1.0, 2.0])
    assert ranges.outside(LAYOUT) == ""
    assert ranges.steps_inside(LAYOUT) == 5
    assert "items" not in ranges.ranges


def test_features_that_do_not_depend_on_a_quantity_have_no_range_of_it():
    known = quantities_of(FeatureKind.SUPPORT)
    kept = {name: ends for name, ends in WIDE.items() if name in known}
    ranges = TrainedRanges(kept, FeatureKind.SUPPORT).ranges
    assert {n for n, ends in ranges.items() if ends == (0.0, math.inf)} == {*QUANTITIES} - {*known}
