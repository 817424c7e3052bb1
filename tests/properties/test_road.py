"""Laws of accelerated loads, on cases whose answer is known."""

import pytest

from steadyload.layouts import Item, Layout, Pallet
from steadyload.properties.property import Case, MethodUnderTest, Violation
from steadyload.properties.road import pile_holds_no_more_than_one_box


def pile(gap):
    """Two bricks with some cm between them, in a direction in which they are short."""
    size, weight = (4.0, 2.0, 2.0), 0.004
    boxes = [Item(at, (0.0, at * (2.0 + gap), 0.0), size, weight) for at in (0, 1)]
    return Case(Layout("pile", Pallet(4.0, 6.0, 2.0), boxes), {"direction [degrees]": 90.0})


@pytest.mark.parametrize("engine", ["bullet", "mujoco"])
def test_a_pile_with_a_gap_below_a_box_is_not_asked(engine):
    tested = MethodUnderTest(f"label@{engine}")
    tested.method.prepare()
    assert not pile_holds_no_more_than_one_box(tested, pile(2.0))
    assert pile_holds_no_more_than_one_box(tested, pile(0.0))


def test_a_pile_that_holds_more_than_one_box_is_a_violation(monkeypatch):
    tested = MethodUnderTest("label@mujoco")
    tested.method.prepare()
    # By its b / h it tips at 0.5 g.
    monkeypatch.setattr("steadyload.properties.road.whole_load_limit", lambda *_: 0.3)
    with pytest.raises(Violation, match=r"holds 0\.\d+ g; expected: up to 0.3 g"):
        pile_holds_no_more_than_one_box(tested, pile(0.0))
