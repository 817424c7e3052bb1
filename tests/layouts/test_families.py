"""Families of generated layouts: valid, as their family says, and equal by seed alone."""

import dataclasses

import numpy as np
import pytest

from steadyload.layouts import formats
from steadyload.layouts.packing import families
from steadyload.layouts.packing.families import (
    DECK,
    FAMILIES,
    FEWEST,
    MOST,
    Family,
    Range,
    family_layouts,
)
from steadyload.layouts.packing.packing import PackingError

_HALF_A_CELL = 0.25
"""Sides along the floor are rounded to cells of half a centimetre [cm]."""


@pytest.fixture(params=[0, 7], ids="seed {}".format, scope="module")
def seed(request):
    return request.param


@pytest.fixture(params=FAMILIES, scope="module")
def drawn(request, seed):
    return FAMILIES[request.param], family_layouts(request.param, 3, seed)


def test_boxes_come_down_from_above_and_rest_on_something(drawn):
    for layout in drawn[1]:  # which refuses boxes that overlap, or stand out of the contour
        assert FEWEST <= len(layout) <= MOST
        assert layout.pallet == DECK
        assert not layout.floor.has_edges
        low, high = layout.lower, layout.upper
        for k in range(len(layout)):
            shared = np.minimum(high[:k], high[k]) - np.maximum(low[:k], low[k])
            below = (shared[:, [0, 2]] > 1e-9).all(axis=1)
            # As for a box that is lowered: its base is where the highest top below it is.
            assert low[k, 1] == pytest.approx(high[:k][below, 1].max(initial=0.0))


def test_boxes_are_as_their_family_says(drawn):
    family, layouts = drawn
    for layout in layouts:
        width, height, depth = layout.sizes.T
        sides = (family.width, family.height, family.depth)
        as_drawn, turned = (
            np.array([_within(own, side) for own, side in zip(order, layout.sizes.T, strict=True)])
            for order in (sides, sides[::-1])
        )
        assert (as_drawn.all(axis=0) | turned.all(axis=0)).all()
        density = layout.weights / (width * height * depth * 1e-6)
        # Weights are rounded to grams.
        assert (np.abs(np.clip(density, *family.density) - density) < 1.0).all()
        shares = layout.mass_offsets / layout.sizes
        for own, share in zip((family.aside_x, family.aside_y, family.aside_z), shares.T,
                              strict=True):  # fmt: skip
            assert (share >= own.low - 1e-3).all()
            assert (share <= own.high + 1e-3).all()


def _within(own, side):
    return (side >= own.low - _HALF_A_CELL) & (side <= own.high + _HALF_A_CELL)


def test_boxes_vary_over_the_whole_of_what_their_family_allows():
    layouts = family_layouts("off-centre", 20, 3)
    sizes = np.concatenate([layout.sizes for layout in layouts])
    shares = np.concatenate([layout.mass_offsets for layout in layouts]) / sizes
    assert np.median(sizes) == pytest.approx(np.sqrt(8.0 * 60.0), rel=0.1)
    assert shares.min(axis=0) == pytest.approx([-0.48] * 3, abs=0.02)
    assert shares.max(axis=0) == pytest.approx([0.48] * 3, abs=0.02)
    assert {len(layout) for layout in layouts} == set(range(FEWEST, MOST + 1))


def test_the_seed_alone_decides_and_more_layouts_begin_with_the_same(seed, tmp_path):
    for name in FAMILIES:
        few, many, others = (
            [layout.content_hash() for layout in family_layouts(name, count, own)]
            for count, own in ((2, seed), (4, seed), (4, seed + 1))
        )
        assert many[:2] == few
        assert len({*many, *others}) == 8
    layouts = family_layouts("slabs", 2, seed)
    formats.write_layouts(tmp_path / "slabs.layouts", layouts, formats.Format.NATIVE)
    read = formats.read_layouts(tmp_path / "slabs.layouts")
    assert [own.content_hash() for own in read] == [own.content_hash() for own in layouts]
    assert [own.name for own in read] == ["slabs-0000", "slabs-0001"]


def test_a_further_family_is_one_entry_and_changes_no_other(monkeypatch):
    before = {name: family_layouts(name, 1, 0)[0].content_hash() for name in FAMILIES}
    columns = Family("tall", Range(10, 15), Range(40, 60), Range(10, 15), Range(100, 200))
    monkeypatch.setattr(families, "FAMILIES", {"columns": columns, **FAMILIES})
    after = {name: family_layouts(name, 1, 0)[0].content_hash() for name in families.FAMILIES}
    assert {name: after[name] for name in before} == before
    (layout,) = family_layouts("columns", 1, 0)
    assert (layout.sizes[:, 1] >= 40.0).all()
    # Another name is another family, even with the same boxes.
    same = dataclasses.replace(columns)
    monkeypatch.setattr(families, "FAMILIES", {"columns": columns, "pillars": same})
    pillars = family_layouts("pillars", 1, 0)[0]
    assert pillars.content_hash() != layout.content_hash()


@pytest.mark.parametrize(
    ("name", "count", "seed", "told"),
    [
        ("spheres", 1, 0, "family is 'spheres'; allowed: mixed, off-centre"),
        ("slabs", 0, 0, "count is 0; allowed: 1 or more"),
        ("slabs", 1, -1, "seed is -1; allowed: 0 or more"),
    ],
)
def test_what_cannot_be_drawn_is_refused(name, count, seed, told):
    with pytest.raises(PackingError, match=told):
        family_layouts(name, count, seed)
