"""The packer keeps items apart and inside, and the embedded layouts are what their script makes."""

from importlib import resources

import numpy as np
import pytest

from harness.layouts.formats import read_layouts
from harness.layouts.model import Pallet
from harness.layouts.packing import DENSITY, ITEM_CLASSES, SPACE_RULES, pack, random_item_list
from harness.studies.embedded.make_layouts import embedded_layouts


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


def test_the_shipped_layouts_are_those_of_their_script():
    path = str(resources.files("harness.studies.embedded") / "layouts.json")
    shipped = read_layouts(path)
    assert [lay.name for lay in shipped] == [lay.name for lay in embedded_layouts()]
    assert [lay.items for lay in shipped] == [lay.items for lay in embedded_layouts()]
    assert len({lay.content_hash() for lay in shipped}) == len(shipped) == 36
