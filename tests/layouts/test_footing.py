"""Footing of boxes: what carries them, where their centres of mass lie, and how far they drop."""

import math
from dataclasses import replace

import pytest

from steadyload.layouts.files.dialect import Dialect
from steadyload.layouts.model.footing import Edge, Gap, Side, footing, gaps, largest
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import Item, Layout, Pallet

PALLET = Pallet(120, 150, 80)


def stack(shift=(0.0, 0.0), offset=(0.0, 0.0, 0.0), rise=0.0):
    """A box on another one, shifted along x or z and raised [cm]."""
    lower = Item(0, (40, 0, 30), (30, 20, 20), 10.0, name="A")
    upper = Item(1, (40 + shift[0], 20 + rise, 30 + shift[1]), (30, 20, 20), 8.0, offset, "B")
    return Layout("stack", PALLET, (lower, upper))


@pytest.mark.parametrize(
    ("shift", "offset", "side", "beyond"),
    [
        ((22.0, 0.0), (0.0, 0.0, 0.0), "right", 7.0),
        ((-22.0, 0.0), (0.0, 0.0, 0.0), "left", 7.0),
        ((0.0, 15.0), (0.0, 0.0, 0.0), "front", 5.0),
        ((0.0, -15.0), (0.0, 0.0, 0.0), "back", 5.0),
        ((5.0, 0.0), (0.0, 0.0, 0.0), None, 0.0),
        ((14.0, 0.0), (2.0, 0.0, 0.0), "right", 1.0),
        ((14.0, 0.0), (0.0, 0.0, 0.0), None, 0.0),
        ((15.0, 0.0), (0.0, 0.0, 0.0), "right", 0.0),
        ((14.0, 0.0), (1.0, 0.0, 0.0), "right", 0.0),
    ],
)
def test_a_centre_of_mass_lies_beyond_a_side_of_the_support(shift, offset, side, beyond):
    """Back is low z: a layout begins in its left-bottom-back corner."""
    found = footing(stack(shift, offset), 1)
    expected = None if side is None else Edge(Side(side), pytest.approx(beyond), 0)
    assert found.edge == expected
    assert footing(stack(shift, offset), 0).edge is None  # on the floor


def test_a_footing_is_said_in_numbers_of_the_load():
    said = footing(stack((22.0, 0.0)), 1).sentence(stack((22.0, 0.0)))
    assert said == (
        "the centre of mass of box B (2nd of 2) lies 7.0 cm past the edge of box A (1st of 2) "
        "(+x); 27 % of its base is supported"
    )
    within = stack((5.0, 0.0))
    assert footing(within, 1).sentence(within) == (
        "83 % of the base of box B (2nd of 2) is supported"
    )
    out = Item(0, (-8.0, 0.0, 30.0), (20.0, 20.0, 20.0), 5.0, (-5.0, 0.0, 0.0))
    over = Layout("over", PALLET, (out,))
    assert footing(over, 0).sentence(over) == (
        "the centre of mass of box 1 of 1 lies 3.0 cm past the edge of the deck (-x); "
        "60 % of its base is supported"
    )


def test_sentences_have_the_axes_and_the_unit_of_the_file():
    frame = Frame.of(Dialect(units="mm", up="z"))
    along_x, along_z = stack((22.0, 0.0)), stack((0.0, 15.0))
    assert "lies 70 mm past the edge of box A (1st of 2) (+y);" in footing(along_x, 1).sentence(
        along_x, frame
    )
    assert "lies 50 mm past the edge of box A (1st of 2) (+x);" in footing(along_z, 1).sentence(
        along_z, frame
    )
    assert Frame.of(None) == Frame.of(Dialect()) == Frame()
    assert [Frame(unit=unit).length(0.02) for unit in ("mm", "cm", "m", "in")] == [
        "0.2 mm", "0.02 cm", "0.0002 m", "0.01 in",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("height", "said"),
    [
        (2.01, {"mm": "20.1 mm", "cm": "2.01 cm", "m": "0.0201 m", "in": "0.791 in"}),
        (0.05, {"mm": "0.5 mm", "cm": "0.05 cm", "m": "0.0005 m"}),
        (4.0, {"mm": "40 mm", "cm": "4.0 cm", "m": "0.040 m", "in": "1.575 in"}),
        (2.5400000000000063, {"mm": "25.4 mm", "cm": "2.54 cm", "m": "0.0254 m", "in": "1.00 in"}),
        (3.0000000000000027, {"mm": "30 mm", "cm": "3.0 cm", "m": "0.030 m"}),
        (2.999999, {"mm": "30 mm", "cm": "3.0 cm"}),
    ],
)
def test_a_gap_is_told_to_a_tenth_of_a_millimetre(height, said):
    """With the decimals of other lengths where it has no finer ones."""
    assert {unit: Frame(unit=unit).length(height, finely=True) for unit in said} == said
    assert f"drops {said['cm']} onto" in Gap(1, height, 0).sentence(stack())


def test_what_carries_a_box_is_the_floor_or_a_box_loaded_before():
    assert gaps(stack((5.0, 0.0))) == ()
    [beside] = gaps(stack((31.0, 0.0)))
    assert (beside.item, beside.height, beside.onto) == (1, 20.0, None)
    lower, upper = stack((5.0, 0.0)).items
    early = Layout("early", PALLET, (replace(upper, sequence=0), replace(lower, sequence=1)))
    [first] = gaps(early)
    assert (first.item, first.height, first.onto) == (0, 20.0, None)
    over = Item(0, position=(-5, 0, 30), size=(30, 20, 20), weight=10)
    assert gaps(Layout("over the edge", PALLET, (over,))) == ()


@pytest.mark.parametrize("rise", [0.03, 0.4, 4.0, 60.0])
def test_a_gap_is_as_high_as_the_box_hovers(rise):
    layout = stack((10.0, 0.0), rise=rise)
    gap = largest(gaps(layout))
    assert (gap.item, gap.height, gap.onto) == (1, pytest.approx(rise), 0)
    assert footing(layout, 1).gap == gap
    if rise == 4.0:
        assert gap.sentence(layout) == (
            "box B (2nd of 2) has nothing under it; it drops 4.0 cm onto box A (1st of 2)"
        )
    assert gaps(stack((10.0, 0.0), rise=0.005)) == ()


def test_a_gap_ends_at_the_highest_top_below_and_beyond_a_deck_at_the_ground():
    low = Item(0, (40, 0, 30), (30, 10, 20), 10.0)
    high = Item(1, (75, 0, 30), (30, 25, 20), 10.0)
    top = Item(2, (60, 30, 30), (30, 10, 20), 5.0)
    [gap] = gaps(Layout("two", PALLET, (low, high, top)))
    assert (gap.height, gap.onto) == (5.0, 1)
    outside = Layout(
        "outside", Pallet(120, 150, 80, overhang=40.0), (Item(0, (-35, 5, 30), (30, 20, 20), 9.0),)
    )
    [gap] = gaps(outside)
    assert (gap.height, gap.onto) == (5.0 + outside.pallet.deck_height, None)
    assert gap.sentence(outside).endswith("it drops 19.4 cm onto the ground")


@pytest.mark.parametrize(("limit", "finest"), [(2.0, 0.1), (0.3, 0.1), (1.2, 0.01), (5.0, 0.5)])
def test_rounding_does_not_decide_whether_a_gap_exceeds_a_limit(limit, finest):
    """Whatever the height at which it is, and whether its file is in mm or in cm."""
    for tenth in range(50, 150):
        base, rise = round(finest * tenth, 2), round(finest * tenth + limit, 2)
        for top in (rise, round(10 * rise, 1) * 0.1):
            lower = Item(0, (40.0, 0.0, 30.0), (30.0, base, 20.0), 10.0)
            [gap] = gaps(
                Layout("equal", PALLET, (lower, Item(1, (40.0, top, 30.0), (30.0, 2, 20.0), 8.0)))
            )
            assert not gap.exceeds(limit)
            assert gap.exceeds(limit - 0.02)
            assert not gap.exceeds(math.inf)
