"""The margin of a load against closed forms, per-step margins, and judges that draw contacts in."""

import pytest
from hand_layouts import failing_step, layout

from steadyload.layouts.model.scenarios import Scenario
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods.contract.method import TimeoutExpiredError
from steadyload.methods.contract.stopwatch import Stopwatch
from steadyload.methods.equilibrium.margin import margin_of
from steadyload.statics.load_margin import MOST, LoadMargin, MarginKind, margin_as_planned
from steadyload.statics.margins import margins

BASE = (0.0, 0.0, 0.0, 60.0, 20.0, 60.0)
POLE = (20.0, 20.0, 20.0, 6.0, 150.0, 6.0)


@pytest.mark.parametrize("boxes", [(BASE, POLE), ((*POLE[:1], 0.0, *POLE[2:]),)])
@pytest.mark.parametrize("method", ["equilibrium", "settling"])
def test_a_contact_of_which_nothing_is_left_carries_nothing(boxes, method):
    pole = layout(*boxes)
    assert failing_step(f"{method}:margin=2.9", pole) is None
    assert failing_step(f"{method}:margin=3.1", pole) == len(boxes) - 1
    found = margin_of(pole)
    assert (found.kind, found.step, found.item) == (MarginKind.AS_PLANNED, *[len(boxes) - 1] * 2)
    assert found.cm == pytest.approx(3.0, abs=2e-3)
    assert margins(pole)[-1].patches == pytest.approx(3.0, abs=1e-5)


@pytest.mark.parametrize("out", [0.0, 2.0, 7.5, 9.9, 10.0])
def test_the_margin_of_an_overhanging_box_is_how_far_its_middle_lies_inside_the_edge(out):
    found = margin_of(layout((0, 0, 0, 20, 5, 40), (out, 5, 0, 20, 5, 40)))
    expected = 10.0 - out
    assert found.cm == pytest.approx(min(expected, MOST), abs=2e-3)
    assert found.kind is MarginKind.AS_PLANNED
    assert found.item == (None if expected >= MOST else 1)


def test_a_box_on_two_columns_needs_both():
    # Columns of 8 cm on either side of its middle: with nothing left of them it falls.
    found = margin_of(layout((0, 0, 0, 8, 9, 30), (22, 0, 0, 8, 9, 30), (0, 9, 0, 30, 5, 30)))
    assert (found.cm, found.step) == (pytest.approx(4.0, abs=2e-3), 0)  # the column itself, first


def test_a_load_without_a_narrow_place_has_the_largest_margin():
    assert margin_of(layout(BASE)) == LoadMargin(MOST, MarginKind.AS_PLANNED, None, None)


def tipping(gap):
    """A box of which the middle lies beyond its carrier, and a lower one by so much beside that."""
    return layout(
        (0, 0, 0, 28, 20, 40), (32, 0, 0, 28, 20.0 - gap, 40), (20, 20, 0, 20, 5, 40)
    )  # fmt: skip


@pytest.mark.parametrize("gap", [0.1, 0.5, 1.5])
def test_the_margin_at_rest_ends_where_nothing_is_left_of_what_it_rests_on(gap):
    # It rests on 8 cm of the one and 8 cm of the other.
    found = margin_of(tipping(gap))
    assert (found.kind, found.step, found.item) == (MarginKind.AT_REST, 2, 2)
    assert found.cm == pytest.approx(4.0, abs=0.06)
    assert failing_step(f"settling:margin={found.cm}", tipping(gap)) is None
    assert failing_step("settling:margin=4.1", tipping(gap)) == 2


def test_what_falls_without_being_drawn_in_has_no_margin():
    assert margin_of(tipping(12.0)) is None
    assert margin_as_planned(tipping(0.5)) is None


def test_a_margin_needs_the_narrow_contact_that_a_box_tips_over():
    # 1 cm of the box tips over a narrow post: with nothing left of that it would lie flat below.
    boxes = layout((0, 0, 0, 40, 20, 40), (30, 20, 0, 2, 2, 40), (27, 22, 0, 40, 4, 40))
    assert failing_step("settling:margin=0", boxes) == 2
    assert margin_of(boxes) is None


@pytest.mark.parametrize("scenario", list(Scenario))
def test_it_is_the_least_of_the_margins_of_all_steps(scenario):
    compared = 0
    for lay in random_layouts(60, seed=41, scenario=scenario):
        found, least = margin_as_planned(lay), min(m.patches for m in margins(lay, centres=False))
        if found is None:
            assert least < 1e-4
            continue
        assert found.cm == pytest.approx(min(least, MOST), abs=2e-3)
        if 0.1 < found.cm < MOST:
            compared += 1
            assert failing_step(f"equilibrium:margin={found.cm - 0.01}", lay) is None
            step = failing_step(f"equilibrium:margin={found.cm + 0.01}", lay)
            assert step is not None
            assert step <= found.step
    assert compared > 5


def test_the_time_limit_holds_at_rest():
    class Expired(Stopwatch):
        def check(self):
            raise TimeoutExpiredError("over")

    with pytest.raises(TimeoutExpiredError):
        margin_of(tipping(0.5), Expired())
