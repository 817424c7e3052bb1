"""The packers keep items apart and inside, and published layouts are what their scripts make."""

import hashlib

import numpy as np
import pytest

from steadyload.layouts.model.layout import Pallet
from steadyload.layouts.packing.heuristics import HEURISTICS, BinRule
from steadyload.layouts.packing.packing import (
    DENSITY,
    ITEM_CLASSES,
    MOST_ITEMS,
    SPACE_RULES,
    PackingError,
    WeightRule,
    generate,
    make_instance,
    pack,
    pack_instance,
    random_item_list,
    random_layouts,
    weigh,
)


@pytest.mark.parametrize("rule", SPACE_RULES)
@pytest.mark.parametrize("number", ITEM_CLASSES)
def test_packed_items_lie_inside_and_apart(rule, number):
    item_class = ITEM_CLASSES[number]
    random = np.random.default_rng(7)
    for _ in range(5):
        sizes = random_item_list(item_class, 40, random)
        layout = pack("a", item_class.pallet, sizes, rule)
        assert layout is not None  # Layout itself refuses overlaps and a broken contour
        volumes = (layout.upper - layout.lower).prod(axis=1)
        assert layout.weights == pytest.approx(DENSITY * volumes * 1e-6)
        assert len(layout) <= 20


def test_a_pallet_can_be_filled_to_the_brim():
    # Eight cubes of 15 fill 30^3 exactly: the spaces must not lose a corner.
    layout = pack("a", Pallet(30.0, 30.0, 30.0), [(15.0, 15.0, 15.0)] * 9, "bottom-back-left")
    assert layout is not None
    assert len(layout) == 8


def test_an_item_that_fits_nowhere_is_left_out():
    sizes = [(31.0, 1.0, 1.0), (1.0, 30.0, 1.0)]
    layout = pack("a", Pallet(30.0, 30.0, 30.0), sizes, "bottom-back-left")
    assert layout is not None
    assert len(layout) == 1
    assert pack("a", Pallet(30.0, 30.0, 30.0), sizes[:1], "bottom-back-left") is None


def test_random_layouts_are_those_of_published_results():
    digest = hashlib.sha256()
    for layout in random_layouts(60, 11):
        digest.update((layout.name + layout.content_hash()).encode())
    assert digest.hexdigest().startswith("e175339b2d040400")


@pytest.fixture(scope="module")
def packed():
    """Every heuristic on a short instance of each class."""
    instances = [make_instance(c, 0, seed=4, item_count=n) for c, n in ((1, 30), (2, 30), (3, 25))]
    return {(i, h): pack_instance(i, h) for i in instances for h in HEURISTICS}


def test_bins_hold_every_item_once_and_are_cut_at_twenty(packed):
    for (instance, _), layouts in packed.items():
        sizes = [tuple(sorted(item.size)) for layout in layouts for item in layout.items]
        if max(map(len, layouts)) < MOST_ITEMS:
            assert sorted(sizes) == sorted(tuple(sorted(size)) for size in instance.sizes)
        assert all(layout.pallet == instance.pallet for layout in layouts)
        assert all(1 <= len(layout) <= MOST_ITEMS for layout in layouts)
    assert max(len(layout) for layouts in packed.values() for layout in layouts) == MOST_ITEMS
    assert max(map(len, packed.values())) > 4


def test_no_item_stands_on_a_later_one(packed):
    # Layout itself refuses overlaps and a broken contour.
    for layout in [layout for layouts in packed.values() for layout in layouts]:
        low, high = layout.lower, layout.upper
        on = high[None, :, 1] == low[:, None, 1]
        for axis in (0, 2):
            on &= low[:, None, axis] < high[None, :, axis]
            on &= high[:, None, axis] > low[None, :, axis]
        assert not np.triu(on).any(), layout.name


def test_items_keep_their_order(packed):
    instance, first = next((i, h) for i, h in packed if i.class_number == 2)
    (layout,) = packed[instance, first]
    for item, size in zip(layout.items, instance.sizes, strict=False):
        assert sorted(item.size) == sorted(size)


def test_names_are_those_of_the_published_files(packed):
    names = [layout.name for layouts in packed.values() for layout in layouts]
    assert len(set(names)) == len(names)
    assert names[0] == "H1_Class_1_Instance_0_ULD_0"
    assert any(name.startswith("H160_Class_3_Instance_0_ULD_3") for name in names)


def test_heuristics_are_deterministic_and_differ(packed):
    for (instance, heuristic), layouts in packed.items():
        if heuristic.number % 9 == 0:
            again = pack_instance(instance, heuristic)
            assert [a.content_hash() for a in again] == [b.content_hash() for b in layouts]
    third = {h: layouts for (i, h), layouts in packed.items() if i.class_number == 3}
    outcomes = {h: tuple(x.geometry_hash() for x in layouts) for h, layouts in third.items()}
    for kind in ("bins", "space", "placement"):
        # Each kind of rule alone makes a difference.
        others = [k for k in ("bins", "space", "placement") if k != kind]
        groups = {}
        for h, outcome in outcomes.items():
            groups.setdefault(tuple(getattr(h, k) for k in others), set()).add(outcome)
        assert max(map(len, groups.values())) > 1, kind


def test_distinct_layouts_are_those_of_single_packing(packed):
    instances = list(dict.fromkeys(i for i, _ in packed))
    distinct = generate(instances)
    singly = {layout.name: layout for layouts in packed.values() for layout in layouts}
    assert sorted(s for d in distinct for s in d.sources) == sorted(singly)
    hashes = [d.layout.geometry_hash() for d in distinct]
    assert len(set(hashes)) == len(hashes) < len(singly)
    for found in distinct:
        assert found.layout.name == found.sources[0]
        for source in found.sources:
            assert singly[source].content_hash() == found.layout.content_hash()
    some = [h for h in HEURISTICS if h.bins is BinRule.WORST]
    again = generate(instances, heuristics=some)
    assert {d.layout.geometry_hash() for d in again} < set(hashes)


def test_weights_follow_their_rule():
    assert weigh((30.0, 40.0, 50.0), WeightRule.PAPER) == pytest.approx(15.0)  # 0.06 m3
    assert weigh((30.0, 40.0, 50.0), WeightRule.AUTHORS) == 250.0  # sqrt(60000) = 244.95
    assert weigh((1.0, 1.0, 1.0), WeightRule.AUTHORS) == 10.0
    assert weigh((10.0, 10.0, 1.0), WeightRule.AUTHORS) == 10.0
    # sqrt(27 x 61 x 85 = 139995) = 374.16; sqrt(73 x 137) = 100.005, which the authors round first.
    assert weigh((27.0, 61.0, 85.0), WeightRule.AUTHORS) == 380.0
    assert weigh((73.0, 137.0, 1.0), WeightRule.AUTHORS) == 100.0
    instance = make_instance(3, 0, seed=4, item_count=8)
    for rule in WeightRule:
        for layout in pack_instance(instance, HEURISTICS[0], weights=rule):
            assert [item.weight for item in layout.items] == [
                weigh(item.size, rule) for item in layout.items
            ]


def test_an_instance_depends_on_nothing_but_its_own_number():
    instance = make_instance(2, 7, seed=4)
    assert len(instance.sizes) == ITEM_CLASSES[2].item_count
    make_instance(2, 6, seed=4, item_count=999)
    assert make_instance(2, 7, seed=4) == instance
    assert (
        make_instance(2, 7, seed=4, item_count=130).sizes[: len(instance.sizes)] == instance.sizes
    )
    others = [make_instance(2, 8, seed=4), make_instance(2, 7, seed=5), make_instance(3, 7, seed=4)]
    assert all(other.sizes[:20] != instance.sizes[:20] for other in others)
    sides = np.array(make_instance(1, 0, seed=4).sizes)
    assert sides.min() == 1
    assert sides.max() == 10


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        ({"class_number": 4}, "item class is 4; allowed: 1, 2, 3"),
        ({"number": -1}, "number is -1"),
        ({"seed": -1}, "seed is -1"),
        ({"item_count": 0}, "item count is 0"),
    ],
)
def test_bad_instances_are_refused(arguments, match):
    with pytest.raises(PackingError, match=match):
        make_instance(**({"class_number": 1, "number": 0, "seed": 0} | arguments))
