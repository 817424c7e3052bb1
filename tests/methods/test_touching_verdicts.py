"""Boxes that are apart, overlap or stand out by exactly 0.01 cm are judged as if they touched.

That is a tenth of a millimetre, the usual resolution of exported plans. Verdicts depend neither on
the unit of the file nor on where on the pallet a pile stands, nor does it matter who judges: the
method on one layout, on a batch, or in a session.
"""

import csv
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import steadyload as sl
from steadyload.core.learned import support
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.layout import view_on
from steadyload.learners.features import SUPPORT
from steadyload.properties.transforms import mirrored, quarter_turned, translated
from steadyload.statics.rest_position import RestPositions

RULES = ("fbs", "pbs0.7", "sme", "equilibrium")

TENTHS = {"mm": 10, "cm": 100, "m": 10_000, "in": 254}
"""Tenths of a millimetre in a unit."""

HEADER = (
    "layout", "pallet_width", "pallet_height", "pallet_depth", "sequence", "x", "y", "z", "width",
    "height", "depth", "weight",
)  # fmt: skip


@cache
def method(spec):
    return sl.make_method(spec)


def in_file(path, units, piles):
    """Layouts as they are read from a CSV file.

    Args:
        path: of the file.
        units: of its lengths.
        piles: the sides of the pallet and the boxes (corner, then size) of every layout, whole
            tenths of a millimetre.
    """
    with path.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(HEADER)
        for number, (pallet, boxes) in enumerate(piles):
            for sequence, box in enumerate(boxes):
                lengths = [length / TENTHS[units] for length in (*pallet, *box)]
                rows.writerow([f"L{number}", *lengths[:3], sequence, *lengths[3:], 5])
    return list(sl.read(path, dialect=sl.Dialect(units=units)))


def in_memory(pallet, boxes, overhang=0.0, floor="auto"):
    """A layout of the same numbers."""
    width, height, depth = (side / 100 for side in pallet)
    items = tuple(
        Item(k, tuple(c / 100 for c in box[:3]), tuple(c / 100 for c in box[3:]), 5.0)
        for k, box in enumerate(boxes)
    )
    return Layout("pile", Pallet(width, height, depth, overhang=overhang, floor=floor), items)


def failing_steps(spec, layouts):
    """The failing steps that a method tells in all of its ways, which agree."""
    tested = method(spec)
    alone = [tested.judge(layout) for layout in layouts]
    assert {verdict.status for verdict in alone} == {"done"}
    found = [verdict.failing_step for verdict in alone]
    batch = tested.evaluate(LayoutBatch.of(layouts)).failing_step.tolist()
    assert [None if step < 0 else step for step in batch] == found
    return found


def session_steps(spec, layouts):
    """The failing steps that sessions tell."""
    found = []
    for layout in layouts:
        with sl.LoadingSession(layout.pallet, method(spec), timed=False) as session:
            placed = (session.try_place(item).stable for item in layout.items)
            found.append(next((k for k, stands in enumerate(placed) if not stands), None))
    return found


def pairs(gap):
    """A box over another one of so many heights, apart by some tenths of a millimetre."""
    pallet = (12_000, 16_000, 8_000)
    for k in range(100, 1100, 4):
        below, above = (0, 0, 0, 4_000, 10 * k, 4_000), (0, 10 * k + gap, 0, 4_000, 1_000, 4_000)
        yield pallet, (below, above)


@pytest.mark.parametrize("units", TENTHS)
def test_a_gap_of_exactly_the_tolerance_is_none_at_any_height(units, tmp_path):
    ties = in_file(tmp_path / "ties.csv", units, pairs(1))
    apart = in_file(tmp_path / "apart.csv", units, pairs(2))
    for spec in RULES:
        assert failing_steps(spec, ties) == session_steps(spec, ties) == [None] * 250
        assert failing_steps(spec, apart) == session_steps(spec, apart) == [1] * 250


def test_forces_at_sides_act_across_a_gap_of_exactly_the_tolerance():
    # The second box, whose centre of mass is 2 mm past the edge, leans against the third.
    leaning = method("equilibrium:sides=friction")
    for gap, failing in ((1, None), (2, 2)):
        for wide in range(3_000, 4_000, 20):
            boxes = (
                (0, 0, 0, wide, 1_000, 2_000),
                (wide + 2_020 + gap, 0, 0, 4_000, 5_000, 2_000),
                (wide - 1_980, 1_000, 0, 4_000, 3_000, 2_000),
            )
            layout = in_memory((12_000, 16_000, 2_000), boxes)
            assert leaning.judge(layout).failing_step == failing


def test_features_of_support_see_the_same_contacts():
    share, drop = SUPPORT.index("supported share"), SUPPORT.index("drop")
    for pallet, boxes in pairs(1):
        layout = in_memory(pallet, boxes)
        table, _ = support(layout.given)
        assert table[1, share] == 1.0
        assert table[1, drop] == 0.0


def test_features_of_support_see_the_edges_of_a_deck_alike():
    floor, share = SUPPORT.index("on the floor"), SUPPORT.index("supported share")
    for k in range(100, 1100):
        box = (-1, 1, 10 * k - 999, 4_000, 1_000, 1_000)
        layout = in_memory((8_000, 16_000, 10 * k), (box,), floor="deck")
        table, _ = support(layout.given)
        assert table[0, floor] == table[0, share] == 1.0


def test_rest_positions_know_who_stands_on_whom():
    for pallet, boxes in pairs(-2):
        # By twice the tolerance one box may be in another, as others push it there.
        lower, upper = (np.array(box) / 100 for box in boxes)
        found = RestPositions(_unchecked(pallet, lower, upper), 0.0, 10.0, 10.0)
        assert (0, 1) in zip(found.below.tolist(), found.above.tolist(), strict=True)


def _unchecked(pallet, *boxes):
    """A layout of two boxes that none would be made of."""
    lower, sizes = (np.array([box[part] for box in boxes]) for part in (slice(3), slice(3, 6)))
    arrays = {
        "lower": lower, "upper": lower + sizes, "sizes": sizes, "weights": np.full(2, 5.0),
        "mass_offsets": np.zeros((2, 3)),
    }  # fmt: skip
    return view_on(arrays, name="pile", pallet=Pallet(*(side / 100 for side in pallet)))


def test_a_base_that_is_bare_by_exactly_the_tolerance_is_supported():
    for k in range(100, 1100):
        below, above = (20, 0, 20, 10 * k, 1_000, 10 * k), (19, 1_000, 21, 10 * k, 1_000, 10 * k)
        layout = in_memory((16_000, 16_000, 16_000), (below, above))
        assert method("fbs").judge(layout).failing_step is None


# --- piles with ties everywhere -------------------------------------------------------------------

SIDE = st.integers(500, 4_000)


@st.composite
def piles(draw):
    """A tower, and beside it a low box that overlaps it by a tenth of a millimetre.

    Whatever is next to something else misses it, overlaps it or stands out by a tenth, or ends
    where the other one does. At most one box of the tower hangs in the air: by two tenths. The
    step at which a pile fails is that of the box, if there is one.
    """
    tie = st.sampled_from((1, 1, -1, 0))
    hanging = draw(st.none() | st.integers(1, 4))
    wide, deep = draw(SIDE), draw(SIDE)
    boxes = [(-1, draw(st.sampled_from((0, 1))), -1, wide, draw(SIDE), deep)]
    for level in range(1, draw(st.integers(2, 5))):
        below = boxes[-1]
        top = below[1] + below[4]
        gap = 2 if level == hanging else draw(tie)
        x, z = draw(st.sampled_from((-1, 0))), draw(st.sampled_from((-1, 0)))
        boxes.append((x, top + gap, z, wide, draw(SIDE), deep))
    low = draw(st.integers(100, boxes[0][4] - 50))
    boxes.append((wide - 2, 0, -1, draw(SIDE), low, deep))
    ends = [max(box[axis] + box[3 + axis] for box in boxes) for axis in range(3)]
    failing = hanging if hanging is not None and hanging < len(boxes) - 1 else None
    # Every end but those of the low corner and of the top is a tenth outside.
    return (ends[0] - 1, ends[1], ends[2] - 1), boxes, failing


@given(pile=piles(), at=st.tuples(st.integers(0, 90_000), st.integers(0, 90_000)))
@settings(max_examples=30, derandomize=True)
def test_verdicts_at_ties_hang_neither_on_place_nor_on_unit_nor_on_side(pile, at, tmp_path_factory):
    pallet, boxes, failing = pile
    here = in_memory(pallet, boxes)
    layouts = [here, mirrored(here), quarter_turned(here), translated(here, at[0] / 7, at[1] / 7)]
    layouts += [mirrored(layouts[-1]), here.on("deck")]
    wide = (pallet[0] + at[0], pallet[1], pallet[2] + at[1])
    moved = [(x + at[0], y, z + at[1], *size) for x, y, z, *size in boxes]
    layouts.append(in_memory(wide, moved))
    folder = tmp_path_factory.mktemp("units")
    for units in TENTHS:
        layouts += in_file(folder / f"{units}.csv", units, [(pallet, boxes), (wide, moved)])
    for spec in RULES:
        assert failing_steps(spec, layouts) == [failing] * len(layouts)
        assert session_steps(spec, layouts) == [failing] * len(layouts)
