"""The binding of the C library for learned methods: sizes, errors, and copies."""

import copy
import pickle

import numpy as np
import pytest

from steadyload.core import learned
from steadyload.core.library import WrongArrayError
from steadyload.core.whole import Given
from steadyload.layouts.packing.packing import random_layouts
from steadyload.learners.features import FeatureKind, names
from steadyload.learners.ranges import QUANTITIES

LAYOUTS = random_layouts(12, seed=3)
RANDOM = np.random.default_rng(4)


def drawn(*shape):
    return RANDOM.normal(0.0, 1.0, shape).astype(np.float32)


def network(columns=5, width=3):
    """Of two layers."""
    layers = [
        learned.Layer(drawn(count, 4 * width), drawn(width, 4 * width), drawn(4 * width))
        for count in (columns, width)
    ]
    return learned.Lstm(layers, drawn(width), 0.5)


def test_every_column_has_a_name():
    assert len(names(FeatureKind.SUPPORT)) == learned.SUPPORT
    assert len(names(FeatureKind.PLAIN)) == learned.PLAIN
    # That of the pallet is of no item.
    assert len(QUANTITIES) - 1 == learned.QUANTITIES


def test_features_are_the_table_with_logarithms_of_lengths_and_weights():
    """In shares of the threshold of a label, 10 cm or degrees; less than 0.01 of it is none."""
    lengths = ("angle", "way", "load", "box height", "shorter side")
    as_log = [name.endswith(lengths) or name == "weight" for name in names(FeatureKind.SUPPORT)]
    for layout in LAYOUTS:
        table, found = learned.support(layout.given)
        expected = np.where(as_log, np.log(np.maximum(table / 10.0, 0.01)), np.arcsinh(table))
        np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-7)


def test_quantities_are_counted_up_to_the_first_outside():
    for layout in LAYOUTS:
        found = learned.quantities(layout.given)
        assert found[:, 2].tolist() == layout.weights.tolist()
        ends = found.min(axis=0), found.max(axis=0)
        assert learned.count_inside(found, *ends) == len(layout)
        heaviest = int(layout.weights.argmax())
        lighter = np.nextafter(ends[1], -np.inf)
        lighter[[0, 1, 3, 4, 5]] = np.inf
        assert learned.count_inside(found, ends[0], lighter) == heaviest


def test_a_network_goes_on_from_its_state_and_leaves_that_as_it_is():
    of, rows = network(), drawn(7, 5)
    start = of.start()
    whole, after = of.run(rows, start)
    assert not start.any()
    first, between = of.run(rows[:4], start)
    second, end = of.run(rows[4:], between)
    assert np.concatenate((first, second)).tobytes() == whole.tobytes()
    assert end.tobytes() == after.tobytes()
    assert after[-1, 0].tobytes() == whole[-1].tobytes()
    none, unchanged = of.run(rows[:0], between)
    assert (none.shape, unchanged.tobytes()) == ((0, 3), between.tobytes())
    logits = whole @ of.head + of.last
    np.testing.assert_allclose(of.decide(whole), 1.0 / (1.0 + np.exp(-logits)), rtol=1e-5)


@pytest.mark.parametrize("width", [3, 8])
def test_a_layer_follows_its_formula_however_large_its_inputs_are(width):
    layer = learned.Layer(drawn(5, 4 * width), drawn(width, 4 * width), drawn(4 * width))
    of, last, cells = learned.Lstm([layer], drawn(width), 0.5), np.zeros(width), np.zeros(width)
    rows = drawn(9, 5) * np.float32([[1e-3], [1.0], [1e20]]).repeat(3, axis=0)
    found, _ = of.run(rows, of.start())
    inward, recurrent, bias = (array.astype(float) for array in layer)
    for row, outputs in zip(rows, found, strict=True):
        gates = row @ inward + last @ recurrent + bias
        into, kept, out = 0.5 + 0.5 * np.tanh(0.5 * gates[: 3 * width]).reshape(3, width)
        cells = kept * cells + into * np.tanh(gates[3 * width :])
        last = out * np.tanh(cells)
        np.testing.assert_allclose(outputs, last, rtol=1e-6, atol=1e-6)
    rows[4, 2] = np.nan
    others, _ = of.run(rows, of.start())
    assert others[:4].tobytes() == found[:4].tobytes()
    assert np.isnan(others[4:]).all()


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
def test_a_copy_has_arrays_of_its_own(copied):
    of, rows = network(), drawn(7, 5)
    other, start = copied(of), of.start()
    for own, one in zip(other._at, of._at, strict=True):
        assert not set(own[1:]) & set(one[1:])
    assert other.run(rows, start)[0].tobytes() == of.run(rows, start)[0].tobytes()
    given = LAYOUTS[0].given
    other = copied(given)
    assert not set(other.addresses[1:]) & set(given.addresses[1:])
    assert learned.support(other)[0].tobytes() == learned.support(given)[0].tobytes()


def test_arrays_of_another_kind_are_refused_by_name():
    of, rows = network(), drawn(7, 5)
    layout, start, wrong = LAYOUTS[0], of.start(), pytest.raises
    boxes = layout.lower, layout.upper, layout.weights, layout.mass_offsets
    with wrong(WrongArrayError, match=r"floor is .*required: float64 of shape \(5,\)"):
        Given(*boxes, layout.floor.corners[:4])
    with wrong(WrongArrayError, match=r"pallet is .*required: float64 of shape \(3,\)"):
        learned.plain_features(layout.given, np.ones(2))
    with wrong(WrongArrayError, match=r"rows is .*required: float32 of shape \(7, 5\)"):
        of.run(rows.astype(float), start)
    with wrong(WrongArrayError, match="rows has to be C-contiguous"):
        of.run(np.asfortranarray(rows), start)
    with wrong(WrongArrayError, match=r"state is .*required: float32 of shape \(2, 2, 3\)"):
        of.run(rows, start[:1])
    with wrong(WrongArrayError, match=r"recurrent is .*required: float32 of shape \(3, 12\)"):
        learned.Lstm([learned.Layer(drawn(5, 12), drawn(3, 8), drawn(12))], drawn(3), 0.0)
    with wrong(WrongArrayError, match=r"outputs is .*required: float32 of shape \(7, 3\)"):
        of.decide(drawn(7, 2))
    with wrong(WrongArrayError, match=r"least is .*required: float64 of shape \(6,\)"):
        learned.count_inside(np.ones((4, 6)), np.ones(5), np.ones(6))
