"""Batches hold what layouts hold, refuse what layouts refuse, and their layouts are views."""

import math
import pickle
from dataclasses import replace
from itertools import combinations, pairwise

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings

import steadyload as sl
from steadyload.layouts import Item, Layout, LayoutError, Pallet
from steadyload.layouts.benchmark import BenchmarkError, load_benchmark
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.layout import ARRAYS, TOLERANCE
from steadyload.layouts.model.validity import first_fault
from steadyload.layouts.packing.packing import random_layouts
from steadyload.properties.strategies import layouts as any_layouts

PALLET = Pallet(100.0, 50.0, 100.0)


def box(k, x=0.0, y=0.0, z=0.0, **values):
    size = values.pop("size", (10.0, 10.0, 10.0))
    return Item(k, (x, y, z), size, values.pop("weight", 2.5), **values)


def layouts():
    """Some with ids and centres of mass, over an edge, on a deck, and of one box."""
    ids = Layout("ids", PALLET, (box(0, name="A", mass_offset=(1.0, -2.0, 0.3)), box(1, 20.0)))
    over = Layout("over", Pallet(100.0, 200.0, 80.0), (box(0, -5.0), box(1, -5.0, 10.0)))
    deck = Layout("deck", Pallet(100.0, 60.0, 90.0, floor="deck", deck_height=12.0), (box(0),))
    return [ids, *random_layouts(20, seed=4), over, deck]


def assert_equal_batches(found, expected):
    for key, values in vars(expected).items():
        others = getattr(found, key)
        if isinstance(values, np.ndarray):
            assert (others.dtype, others.shape) == (values.dtype, values.shape), key
            assert others.tobytes() == values.tobytes(), key
            assert not others.flags.writeable
        else:
            assert others == values, key


def spelled_out(lower, upper):
    """The two of some items that overlap most, and by how much, looked for pair by pair."""
    found = None
    for one, other in combinations(range(len(lower)), 2):
        depth = min(np.minimum(upper[one], upper[other]) - np.maximum(lower[one], lower[other]))
        if depth > (found[2] if found else TOLERANCE):
            found = one, other, depth
    return found


def test_the_two_items_that_overlap_most_are_named_whatever_stands_beside_the_layout():
    random = np.random.default_rng(5)
    counts = random.permutation([*range(1, 71), *[2, 3, 4, 9] * 50])
    starts = np.concatenate(([0], np.cumsum(counts)))
    room = np.repeat(random.choice([20.0, 60.0, 200.0], len(counts)), counts)[:, None]
    lower = random.uniform(0.0, 1.0, (starts[-1], 3)) * room
    sizes = random.uniform(2.0, 8.0, lower.shape)
    arrays = {"lower": lower, "upper": lower + sizes, "sizes": sizes}
    arrays |= {"weights": np.ones(len(lower)), "mass_offsets": np.zeros_like(lower)}
    contour = np.array([[0.0, 0.0, 0.0, 300.0, 300.0, 300.0]])
    overlaps = 0
    for a, b in pairwise(starts.tolist()):
        own = {key: array[a:b] for key, array in arrays.items()}
        fault = first_fault(np.array([0, b - a]), own, contour)
        expected = spelled_out(own["lower"], own["upper"])
        assert (fault and (fault.other, fault.item, fault.number)) == expected
        overlaps += expected is not None
        # Behind a valid one, and before one with a fault.
        among = {k: np.concatenate([arrays[k][:1], v, v + 400.0]) for k, v in own.items()}
        bounds = np.array([0, 1, 1 + b - a, 1 + 2 * (b - a)])
        later = first_fault(bounds, among, np.repeat(contour, 3, axis=0))
        assert later[:5] == ((1, *fault[1:]) if fault else (2, *later[1:]))
    assert 20 < overlaps < len(counts) - 20


def arrays_of(batch):
    """A batch as a user has it: arrays, names and ids."""
    return {
        "starts": batch.starts,
        "positions": batch.lower,
        "sizes": batch.sizes,
        "weights": batch.weights,
        "mass_offsets": batch.mass_offsets,
        "pallets": batch.pallets,
        "names": batch.names,
        "ids": batch.ids,
    }


def test_a_batch_of_arrays_is_that_of_the_layouts():
    expected = LayoutBatch.of(layouts())
    assert_equal_batches(LayoutBatch.from_arrays(**arrays_of(expected)), expected)


@settings(max_examples=40)
@given(any_layouts())
def test_a_batch_of_any_arrays_is_that_of_the_layouts(layout):
    expected = LayoutBatch.of([layout, layout])
    assert_equal_batches(LayoutBatch.from_arrays(**arrays_of(expected)), expected)


def test_a_layout_of_a_batch_is_a_view_with_the_items_of_the_original():
    given_layouts = layouts()
    batch = LayoutBatch.of(given_layouts)
    for view, layout in zip(batch, given_layouts, strict=True):
        for key in ARRAYS:
            assert np.shares_memory(getattr(view, key), getattr(batch, key))
            assert not getattr(view, key).flags.writeable
        assert (view.name, view.pallet, view.floor) == (layout.name, layout.pallet, layout.floor)
        assert (len(view), view.ids) == (len(layout), layout.ids)
        assert view.content_hash() == layout.content_hash()
        assert "items" not in vars(view)
        assert view.items == layout.items
        assert view.items is view.items
        assert repr(view) == repr(layout)


def test_a_view_has_no_other_names_than_a_layout():
    view = LayoutBatch.of(layouts())[0]
    with pytest.raises(AttributeError, match="'Layout' object has no attribute 'item'"):
        _ = view.item


def test_a_view_travels_to_another_process_without_the_batch():
    batch = LayoutBatch.of(random_layouts(50, seed=1))
    sent = pickle.dumps(batch[7])
    received = pickle.loads(sent)
    assert len(sent) < len(pickle.dumps(batch)) / 10
    assert "items" not in vars(received)
    assert received.items == batch[7].items
    assert received.content_hash() == batch[7].content_hash()


@pytest.mark.parametrize("protocol", [4, 5])
def test_what_travels_stays_read_only(protocol):
    batch = LayoutBatch.of(layouts())
    assert_equal_batches(pickle.loads(pickle.dumps(batch, protocol)), batch)
    for layout in (batch[0], layouts()[0], layouts()[-1]):
        assert not layout.floor.corners.flags.writeable
        received = pickle.loads(pickle.dumps(layout, protocol))
        assert not any(getattr(received, key).flags.writeable for key in ARRAYS)
        assert not received.floor.corners.flags.writeable
        assert received.floor == layout.floor


def test_a_part_of_a_batch_is_a_batch_of_these_layouts():
    batch, given_layouts = LayoutBatch.of(layouts()), layouts()
    for part in (slice(3, 9), slice(None, 1), slice(-2, None), slice(5, 5), slice(9, 3)):
        assert_equal_batches(batch[part], LayoutBatch.of(given_layouts[part]))
    assert np.shares_memory(batch[3:9].lower, batch.lower)
    assert batch[-1].name == "deck"
    with pytest.raises(IndexError):
        _ = batch[len(batch)]
    with pytest.raises(ValueError, match="step of a slice is 2; allowed: 1"):
        _ = batch[::2]


def test_a_batch_keeps_its_numbers_when_the_arrays_change():
    arrays = arrays_of(LayoutBatch.of(layouts()))
    positions = np.array(arrays["positions"])
    batch = LayoutBatch.from_arrays(**arrays | {"positions": positions})
    before = batch.lower.copy()
    positions[:] = 0.0
    assert (batch.lower == before).all()


ONE = {"starts": [0, 1], "positions": [[0, 0, 0]], "sizes": [[1, 1, 1]], "weights": [1]}


def test_what_is_not_stated_has_a_default():
    batch = LayoutBatch.from_arrays(**ONE, pallets=PALLET)
    assert batch[0].items == (Item(0, (0, 0, 0), (1, 1, 1), 1),)
    assert (batch.names, batch[0].name, batch.ids) == (("0",), "0", ())
    nothing = {"starts": [0], "positions": np.empty((0, 3)), "sizes": np.empty((0, 3))}
    empty = LayoutBatch.from_arrays(**nothing, weights=[], pallets=PALLET)
    assert_equal_batches(empty, LayoutBatch.of([]))


@pytest.mark.parametrize("which", ["0", "010", "0011", "0110", "01120"])
def test_pallets_may_be_given_by_their_sizes(which):
    kinds = np.array([[100.0, 50.0, 80.0], [90.0, 60.0, 100.0], [100.0, 60.0, 80.0]])
    sizes, count = kinds[list(map(int, which))], len(which)
    arrays = {"starts": range(count + 1), "weights": np.ones(count)}
    arrays |= {"positions": np.zeros((count, 3)), "sizes": np.ones((count, 3))}
    batch = LayoutBatch.from_arrays(**arrays, pallets=sizes)
    assert batch.pallets == tuple(Pallet(*size) for size in sizes.tolist())
    assert len(set(map(id, batch.pallets))) == len(set(which))
    sizes[-1] = 0.0
    with pytest.raises(LayoutError, match=f'layout "{count - 1}": pallet width is 0 cm'):
        LayoutBatch.from_arrays(**arrays, pallets=sizes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"starts": [1, 2]}, "starts is an array of int64 and shape (2,); allowed: whole numbers"),
        ({"starts": [0.0, 1.0]}, "starts is an array of float64"),
        ({"starts": []}, "starts is an array of float64 and shape (0,)"),
        ({"starts": [0, 2, 1]}, 'layout "1": starts falls from 2 to 1'),
        ({"starts": [0, 0, 1]}, 'layout "0": has no items; allowed: one or more'),
        ({"starts": [0, 2]}, "positions is an array of int64 and shape (1, 3); allowed: numbers of "
                             "shape (2, 3)"),
        ({"sizes": [[1, 1]]}, "sizes is an array of int64 and shape (1, 2)"),
        ({"sizes": [[1, 1, 1], [1]]}, "sizes is of rows of different lengths"),
        ({"weights": ["7"]}, "weights is an array of <U1 and shape (1,)"),
        ({"weights": [True]}, "weights is an array of bool"),
        ({"mass_offsets": [0, 0, 0]}, "mass_offsets is an array of int64 and shape (3,)"),
        ({"names": ["a", "b"]}, "names has 2 entries; allowed: 1 texts"),
        ({"names": [7]}, "names has 1 entries; allowed: 1 texts"),
        ({"names": [""]}, 'layout "0": name is \'\'; allowed: one or more printable characters'),
        ({"ids": ["a", "b"]}, "ids has 2 entries; allowed: 1 texts"),
        ({"pallets": [PALLET, PALLET]}, "pallets has 2 entries; allowed: one pallet, 1 of them"),
        ({"pallets": [7]}, "pallets has 1 entries; allowed: one pallet, 1 of them, or an array"),
        ({"pallets": np.ones(3)}, "pallets is an array of float64 and shape (3,)"),
        ({"pallets": np.zeros((1, 3))}, 'layout "0": pallet width is 0 cm; allowed'),
    ],
)  # fmt: skip
def test_arrays_that_do_not_fit_are_refused(changes, message):
    with pytest.raises(LayoutError, match="allowed") as caught:
        LayoutBatch.from_arrays(**{**ONE, "pallets": PALLET} | changes)
    assert message in str(caught.value)


CHANGES = [
    ("lower", (2, 0), math.nan),
    ("lower", (2, 1), -math.inf),
    ("lower", (2, 1), 1e308),
    ("lower", (2, 1), 41.0),
    ("lower", (2, 0), -11.0),
    ("lower", (2, 0), 15.0),
    ("sizes", (2, 0), 0.0),
    ("sizes", (2, 0), math.nan),
    ("sizes", (2, 2), -10.0),
    ("sizes", (2, 2), 1e308),
    ("weights", 2, 0.0),
    ("weights", 2, math.nan),
    ("weights", 2, 1e7),
    ("mass_offsets", (2, 0), 5.1),
    ("mass_offsets", (2, 1), math.nan),
]


def made_of_items(name, arrays, ids):
    """A layout of items with these values."""
    values = (arrays[key].tolist() for key in ("lower", "sizes", "weights", "mass_offsets"))
    try:
        items = tuple(
            Item(k, tuple(at), tuple(size), weight, tuple(offset), own)
            for k, (at, size, weight, offset, own) in enumerate(zip(*values, ids, strict=True))
        )
        return Layout(name, PALLET, items)
    except LayoutError as error:
        raise error.located(layout=name) from None


@pytest.mark.parametrize(("key", "where", "value"), CHANGES)
@pytest.mark.parametrize("named", [False, True])
def test_an_invalid_layout_of_a_batch_is_refused_as_by_itself(key, where, value, named):
    positions = [[0, 0, 0], [20, 0, 0], [0, 0, 0], [20, 0, 30], [20, 0, 0]]
    valid = {
        "lower": np.array(positions, dtype=float),
        "sizes": np.full((5, 3), 10.0),
        "weights": np.full(5, 2.0),
        "mass_offsets": np.zeros((5, 3)),
    }
    ids = tuple("abcde") if named else ("",) * 5
    wrong = {k: array.copy() for k, array in valid.items()}
    wrong[key][where] = value
    with pytest.raises(LayoutError) as alone:
        made_of_items("second", {k: array[2:] for k, array in wrong.items()}, ids[2:])
    # A third one is not valid either, and not named.
    several = {k: np.concatenate([array, array[2:]]) for k, array in wrong.items()}
    with pytest.raises(LayoutError) as together:
        LayoutBatch.from_arrays(
            [0, 2, 5, 8],
            *several.values(),
            pallets=PALLET,
            names=["first", "second", "third"],
            ids=ids + ids[2:] if named else (),
        )
    assert str(together.value) == str(alone.value)
    assert str(alone.value).startswith('layout "second": ')


def test_an_id_that_cannot_be_shown_is_refused():
    with pytest.raises(LayoutError, match=r'layout "0": item 0: name is .a.nb'):
        LayoutBatch.from_arrays(**ONE, pallets=PALLET, ids=["a\nb"])


@pytest.mark.parametrize("count", [2, 20, 70, 300])
def test_overlaps_are_found_in_layouts_of_any_size_beyond_the_tolerance_only(count):
    positions = np.zeros((2 * count, 3))
    positions[:, 0] = np.tile(np.arange(count) * 10.0, 2)
    arrays = {"starts": [0, count, 2 * count], "sizes": np.full((2 * count, 3), 10.0)}
    given = arrays | {"weights": np.ones(2 * count), "pallets": Pallet(10.0 * count, 50.0, 50.0)}
    positions[-1, 0] -= 0.9 * TOLERANCE
    LayoutBatch.from_arrays(positions=positions, **given)
    positions[-1, 0] -= 0.2 * TOLERANCE
    last, other = count - 1, count - 2
    with pytest.raises(LayoutError, match=f'layout "1": item {last}: overlaps item {other} by'):
        LayoutBatch.from_arrays(positions=positions, **given)


def rows_of(benchmark, cases):
    """Layouts of cases, made of items, as the tables state them."""
    offsets = benchmark.cases.set_index(["layout", "scenario"])["offsets"]
    for name, scenario in cases[["layout", "scenario"]].to_numpy():
        row, shifts = benchmark.layouts.loc[name], offsets[name, scenario]
        positions, sizes = np.reshape(row["positions"], (-1, 3)), np.reshape(row["sizes"], (-1, 3))
        shifts = np.zeros_like(sizes) if shifts is None else np.reshape(shifts, (-1, 3))
        values = [array.tolist() for array in (positions, sizes, row["weights"], shifts)]
        items = (
            Item(k, tuple(at), tuple(size), weight, tuple(shift))
            for k, (at, size, weight, shift) in enumerate(zip(*values, strict=True))
        )
        yield Layout(name, Pallet(*row["pallet"].tolist()), tuple(items))


@pytest.mark.parametrize("which", [None, "planar"])
def test_labelled_cases_are_a_batch_without_an_object_an_item(which):
    benchmark = load_benchmark(which)
    cases = benchmark.select("validation", limit=100)
    expected = LayoutBatch.of(rows_of(benchmark, cases))
    assert_equal_batches(benchmark.batch(cases), expected)
    one_by_one = (benchmark.layout(*case) for case in cases[["layout", "scenario"]].to_numpy())
    assert_equal_batches(LayoutBatch.of(one_by_one), expected)


UNFIT = "its lists of numbers do not fit together, the labelled set is damaged"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"weights": [1.0] * 99}, UNFIT),
        ({"weights": None}, UNFIT),
        ({"pallet": [1.0, 2.0]}, UNFIT),
        ({"sizes": [1.0]}, UNFIT),
        ({"pallet": [1.0, 0.0, 1.0]}, "pallet height is 0 cm"),
        ({"sizes": [1.0] * 3, "weights": [1.0], "positions": [math.nan] * 3}, "position x is nan"),
        ({"sizes": [], "weights": [], "positions": []}, "has no items; allowed: one or more"),
    ],
)
def test_a_damaged_row_is_named_in_a_batch_as_by_itself(changes, message):
    benchmark = load_benchmark("planar")
    cases = benchmark.select("validation", scenarios=("S1",), limit=4)
    name, table = cases["layout"][2], benchmark.layouts
    for key, values in changes.items():
        cells = table[key].to_list()
        cells[table.index.get_loc(name)] = values
        table = table.assign(**{key: pd.Series(cells, table.index)})
    damaged = replace(benchmark, layouts=table)
    with pytest.raises((BenchmarkError, LayoutError), match=message) as alone:
        damaged.layout(name, "S1")
    assert name in str(alone.value)
    with pytest.raises(type(alone.value)) as together:
        damaged.batch(cases)
    assert str(together.value) == str(alone.value)


def test_a_case_that_is_not_there_is_refused():
    benchmark = load_benchmark("planar")
    cases = pd.DataFrame({"layout": ["nobody"], "scenario": ["S1"]})
    with pytest.raises(BenchmarkError, match="no case of layout 'nobody' in scenario 'S1'"):
        benchmark.batch(cases)


def test_it_is_public():
    assert sl.LayoutBatch is LayoutBatch
