"""Reasons: where a plan loses its balance, by closed forms, and what a method adds to that."""

import pickle
from dataclasses import replace

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from plans import random_plan

from steadyload import check
from steadyload.app import faults
from steadyload.app.faults import fault_of
from steadyload.app.remedies import remedy_of
from steadyload.core.whole import Given
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.model.footing import Side
from steadyload.layouts.model.frame import Frame
from steadyload.methods import make_method
from steadyload.methods.contract.verdict import Verdict
from steadyload.repairing.remedy import remedy
from steadyload.statics.balance_lost import balance_lost
from steadyload.statics.resolution import UnresolvedError

PALLET = Pallet(120.0, 150.0, 80.0)


def plan(*boxes):
    """A plan of boxes (position, size, weight), with ids A, B, C, ..."""
    items = (
        Item(step, position, size, weight, name=chr(ord("A") + step))
        for step, (position, size, weight) in enumerate(boxes)
    )
    return Layout("plan", PALLET, tuple(items))


def block(x=40.0, y=0.0, z=20.0):
    return ((x, y, z), (20.0, 20.0, 20.0), 10.0)


def saw(layout, step, moved, method="label@mujoco", **movement):
    """The reason where a method says that a step fails, and which box moved."""
    movement = movement or {"displacement": 3.0, "rotation": 11.0}
    verdict = Verdict(len(layout), failing_step=step, moved_item=moved, **movement)
    return fault_of(layout, verdict, method).sentence(layout)


@pytest.mark.parametrize("beyond", [0.004, 0.2, 3.0, 9.0])
@pytest.mark.parametrize(("axis", "sign", "side"), [
    (0, 1, Side.RIGHT), (0, -1, Side.LEFT), (2, 1, Side.FRONT), (2, -1, Side.BACK),
])  # fmt: skip
def test_a_box_past_an_edge_gives_way_there(beyond, axis, sign, side):
    place = [40.0, 20.0, 20.0]
    place[axis] += sign * (10.0 + beyond)
    lost = balance_lost(plan(block(), block(*place)))
    assert (lost.step, lost.item, lost.loaded) == (1, 1, False)
    assert (lost.edge.side, lost.edge.box) == (side, 0)
    assert lost.edge.beyond == pytest.approx(beyond, abs=2e-5)
    assert lost.beyond == pytest.approx(beyond, abs=2e-5)


@pytest.mark.parametrize("weight", [2.0, 5.0, 50.0])
def test_a_box_gives_way_under_what_stands_on_its_end(weight):
    """A plank of 1 kg reaches 18 cm beyond the block; a load stands on the last 10 cm of it."""
    plank = ((41.0, 20.0, 20.0), (37.0, 2.0, 20.0), 1.0)
    load = ((68.0, 22.0, 20.0), (10.0, 20.0, 20.0), weight)
    layout = plan(block(), plank, load)
    lost = balance_lost(layout)
    common = (1.0 * 59.5 + weight * 73.0) / (1.0 + weight)
    assert (lost.step, lost.item, lost.loaded) == (2, 1, True)
    assert lost.edge.beyond == pytest.approx(common - 60.0, abs=1e-4)
    said = lost.sentence(layout)
    assert said.startswith("the weight of box B (2nd of 3) and of what stands on it acts ")
    assert said.endswith(
        f"{common - 60.0:.1f} cm past the edge of box A (1st of 3) (+x); 51 % of its base is "
        "supported; it gives way when box C (3rd of 3) is placed"
    )


def test_a_box_that_lies_outside_a_notch_gives_way_without_an_edge():
    """Two posts below opposite corners: its middle is in their rectangle, and on their diagonal."""
    posts = [((x, 0.0, z), (10.0, 30.0, 10.0), 5.0) for x, z in ((20.0, 20.0), (50.0, 50.0))]
    board = Item(2, (20.0, 30.0, 20.0), (40.0, 5.0, 40.0), 4.0, (9.0, 0.0, -9.0), "C")
    layout = plan(*posts)
    layout = Layout("plan", PALLET, (*layout.items, board))
    lost = balance_lost(layout)
    assert (lost.step, lost.item, lost.edge) == (2, 2, None)
    # x - z is 18 cm; the supports reach to 10 cm, and by t on each side to 10 + 2 t.
    assert lost.beyond == pytest.approx(4.0, abs=1e-4)
    assert lost.sentence(layout) == (
        "the weight of box C (3rd of 3) acts 4.0 cm outside its support; "
        "12 % of its base is supported"
    )


def test_the_balance_of_a_plan_is_that_of_exact_equilibrium():
    @settings(max_examples=80, derandomize=True)
    @given(seed=st.integers(0, 10**6), boxes=st.integers(2, 12))
    def holds(seed, boxes):
        layout = random_plan(seed, boxes)
        verdict, lost = make_method("equilibrium").judge(layout), balance_lost(layout)
        if verdict.stable:
            assert lost is None
            return
        assert (lost.step, lost.item) == (verdict.failing_step, verdict.moved_item)
        assume(lost.beyond is not None and not lost.footing.gap)
        assert lost.beyond > 0.0
        assert lost.sentence(layout)

    holds()


def test_a_reason_begins_with_the_balance_that_is_lost():
    """A box leans at the second step; a simulation sees another fall at the third."""
    layout = plan(block(), block(52.0, 20.0), block(0.0))
    assert saw(layout, 1, 1) == (
        "the centre of mass of box B (2nd of 3) lies 2.0 cm past the edge of box A (1st of 3) "
        "(+x); 40 % of its base is supported"
    )
    assert saw(layout, 1, 0).endswith(
        "is supported; in the simulation of label@mujoco box A (1st of 3) moves too far first"
    )
    assert saw(layout, 2, 2) == (
        "the centre of mass of box B (2nd of 3) lies 2.0 cm past the edge of box A (1st of 3) "
        "(+x); 40 % of its base is supported; the method sees the load fail only when "
        "box C (3rd of 3) is placed"
    )
    assert saw(layout, 2, 1).endswith(
        "only when box C (3rd of 3) is placed, and then box B (2nd of 3) moves too far"
    )


def test_boxes_are_said_to_balance_only_as_far_as_they_do():
    """The second box stands; the third hangs in the air."""
    layout = plan(block(), block(45.0, 20.0), block(80.0, 50.0))
    said = saw(layout, 1, 1)
    assert said == (
        "75 % of the base of box B (2nd of 3) is supported; contact forces balance the first 2 "
        "boxes, up to box C (3rd of 3), and only in the simulation of label@mujoco does it move "
        "too far"
    )
    assert "contact forces balance the first 2 boxes, and only" in saw(layout.first(2), 1, 1)
    assert saw(layout, 1, 0).endswith("does it move too far when box B (2nd of 3) is placed")


def test_a_gap_that_the_reason_names_is_said_once():
    """The first box in the air settles, and the load fails at the second one."""
    layout = plan(block(), block(40.0, 21.0), block(0.0, 30.0))
    found = check(layout, "settling")
    assert found.sentence == "fails at box 3 of 3: C has nothing under it"
    assert str(found).count("box C (3rd of 3) has nothing under it; it drops 30.0 cm") == 1


def test_no_simulation_is_named_where_none_ran():
    standing = plan(block(), block(45.0, 20.0))
    assert saw(standing, 1, None, "fbs", displacement=None).endswith(
        "contact forces balance the first 2 boxes, and the method alone calls the load unstable"
    )
    for stage in ("settling", "lstm_e:question=stands"):
        verdict = Verdict(
            2, failing_step=1, moved_item=1, displacement=3.0, rotation=15.0, stage=stage
        )
        fault = fault_of(standing, verdict, "cascade@rapier:question=stands")
        assert not fault.simulation
        assert "simulation" not in fault.sentence(standing)
    simulated = replace(verdict, stage="ps_opt@rapier:question=stands")
    fault = fault_of(standing, simulated, "cascade@rapier:question=stands")
    assert "the simulation of ps_opt@rapier does" in fault.sentence(standing)


def test_a_centre_of_mass_on_an_edge_is_said_to_lie_on_it():
    layout = plan(block(), block(50.0, 20.0))
    assert balance_lost(layout) is None
    assert saw(layout, 1, 1).startswith(
        "the centre of mass of box B (2nd of 2) lies on the edge of box A (1st of 2) (+x); 50 %"
    )


def test_a_check_states_both_steps_and_no_movement_that_none_saw():
    layout = plan(block(), block(54.0, 20.0), block(90.0))
    found = check(layout, "settling")
    assert found.sentence == "fails at box 2 of 3: B leans to +x"
    told = found.to_dict()
    assert (told["failing_step"], told["balance_lost_step"], told["balance_lost_item"]) == (1, 1, 1)
    assert told["balance_lost_box"] == "B"
    assert (told["displacement_cm"], told["rotation_deg"]) == (None, None)
    assert found.verdict.displacement is not None
    simulated = check(layout, "ps_opt@mujoco:question=stands")
    assert simulated.to_dict()["displacement_cm"] > 0.0
    assert check(plan(block()), "settling").to_dict()["balance_lost_step"] is None


def test_a_remedy_tries_the_step_at_which_balance_is_lost():
    """A plank that needs a counterweight on its left before its right end is loaded.

    Nothing helps the heavy box that a simulation sees fall: there is no other room on the pallet.
    """
    boxes = (
        ((0.0, 0.0, 0.0), (20.0, 20.0, 20.0), 10.0),
        ((20.0, 0.0, 0.0), (20.0, 15.0, 20.0), 10.0),
        ((1.0, 20.0, 0.0), (37.0, 2.0, 20.0), 1.0),
        ((28.0, 22.0, 0.0), (10.0, 20.0, 20.0), 5.0),
        ((1.0, 22.0, 0.0), (10.0, 128.0, 20.0), 50.0),
        ((11.0, 22.0, 0.0), (17.0, 128.0, 20.0), 1.0),
        ((28.0, 42.0, 0.0), (10.0, 20.0, 20.0), 500.0),
    )
    items = plan(*boxes).items
    layout = Layout("plan", Pallet(40.0, 150.0, 20.0, overhang=0.0), items)
    verdict = Verdict(7, failing_step=6, moved_item=6, displacement=3.0, rotation=11.0)
    fault = fault_of(layout, verdict, "label@mujoco")
    assert (fault.step, fault.lost.step) == (6, 3)
    assert not remedy(layout, 6).helps
    assert remedy_of(layout, fault, Frame()) == (
        "box D (4th of 7) would stand if it were loaded after box E (5th of 7); "
        "box C (3rd of 7) gives way below it"
    )


def test_where_rounding_hides_whether_forces_balance_nothing_is_said_of_them(monkeypatch):
    layout = plan(block(), block(y=20.0))

    def hidden(_):
        raise UnresolvedError("too light")

    assert fault_of(layout, tipped(layout), "label@mujoco").resolved
    monkeypatch.setattr(faults, "balance_lost", hidden)
    found = fault_of(layout, tipped(layout), "label@mujoco")
    assert (found.resolved, found.lost) == (False, None)
    assert found.sentence(layout).endswith(
        "; rounding hides whether contact forces balance the plan"
    )


def tipped(layout):
    """What is said of a load whose last box tips."""
    last = len(layout) - 1
    return Verdict(len(layout), failing_step=last, moved_item=last, displacement=3.0, rotation=11.0)


@pytest.mark.parametrize("method", [None, "sme", "equilibrium:time=0.3", "ps_opt@mujoco"])
def test_a_check_finds_the_contacts_of_a_load_once(monkeypatch, method):
    seen, found = [], Given.contacts

    def counted(given):
        seen.append((len(given), given))  # kept, so that no address is used twice
        return found(given)

    monkeypatch.setattr(Given, "contacts", counted)
    corners = ((0.0, 0.0, 0.0), (40.0, 0.0, 0.0), (0.0, 30.0, 0.0), (25.0, 60.0, 30.0))
    load = plan(*((corner, (40.0, 30.0, 40.0), 10.0) for corner in corners))
    assert not check(load, method).verdict.stable
    of_all = [given for count, given in seen if count == len(load)]
    assert len(of_all) <= 1
    assert all(given is load.given for given in of_all)
    assert len(seen) <= 2  # and those of the load up to the failing step


def test_contacts_do_not_travel_to_another_process():
    load = plan(block(), block(y=20.0))
    assert len(load.given) == 2
    before = pickle.dumps(load)
    assert load.supports.carriers(1) == load.contacts.below.tolist() == [0]
    assert pickle.dumps(load) == before
    assert pickle.loads(before).supports == load.supports
