"""What a layout needs of an engine: two dimensions or three, and which items."""

import numpy as np
import pytest
from tested_engines import TESTED

from steadyload.engines.registry import world_class
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods import Status, make_method
from steadyload.methods.contract.method import Effort
from steadyload.methods.simulation.scene import boxes, neighbourhood, planar_scene

PALLET = Pallet(100.0, 100.0, 100.0)
SPATIAL = [e for e in TESTED if world_class(e).capabilities.dimensions == 3]
SLOW_LAST = [
    *(e for e in SPATIAL if e != "reference"),
    "reference",
]
PLANAR = [e for e in TESTED if world_class(e).capabilities.dimensions == 2]


def layout(*items):
    """Items as (position, size[, mass offset])."""
    made = []
    for step, (position, size, *offset) in enumerate(items):
        made.append(Item(step, position, size, 1.0, *offset))
    return Layout("a", PALLET, tuple(made))


def wall(shifts, *, across="depth", offset=0.0):
    """A column of boxes 20 x 10 cm, 40 cm deep, shifted in the plane."""
    items = []
    for k, shift in enumerate(shifts):
        moved = offset if k == len(shifts) - 1 else 0.0
        if across == "depth":
            items.append(((30.0 + shift, 10.0 * k, 20.0), (20.0, 10.0, 40.0), (moved, 0.0, 0.0)))
        else:
            items.append(((20.0, 10.0 * k, 30.0 + shift), (40.0, 10.0, 20.0), (0.0, 0.0, moved)))
    return layout(*items)


def test_a_wall_of_full_depth_is_planar():
    assert planar_scene(wall([0.0, 5.0, 8.0])).across == "depth"
    assert planar_scene(wall([0.0, 5.0], across="width")).across == "width"
    assert planar_scene(wall([0.0, 5.0], offset=3.0)).across == "depth"


@pytest.mark.parametrize(
    ("lay", "reason"),
    [
        (layout(((0, 0, 0), (10, 10, 10)), ((20, 0, 20), (10, 10, 10))), "item 1 does not share"),
        (layout(((0, 0, 0), (9, 9, 9), (1, 0, 1))), "the centre of mass of item 0 is off"),
        (
            layout(((0, 0, 0), (9, 9, 9)), ((0, 9, 0), (9, 9, 8), (2, 0, 0))),
            "does not share its depth",
        ),
    ],
)
def test_a_layout_that_is_not_planar_says_why(lay, reason):
    scene = planar_scene(lay)
    assert scene.across is None
    assert reason in scene.reason


@pytest.mark.parametrize("engine", PLANAR)
def test_a_2d_engine_refuses_what_is_not_planar(engine):
    verdict = make_method(f"ps3@{engine}").judge(layout(((0, 0, 0), (9, 9, 9), (1, 0, 1))))
    assert (verdict.status, verdict.score) == (Status.REFUSED, None)
    assert "not planar" in verdict.reason


@pytest.mark.parametrize("across", ["depth", "width"])
@pytest.mark.parametrize(
    ("shifts", "offset", "step"),
    [
        ([0.0] * 5, 0.0, None),
        ([0.0, 8.0], 0.0, None),
        ([0.0, 12.0], 0.0, 1),
        ([0.0, -12.0], 0.0, 1),
        ([0.0, 8.0], 4.0, 1),
        ([0.0, 12.0], -4.0, None),
        ([0.0, 6.0, 12.0], 0.0, None),  # 1 and 2 together stand at 9 of 10 over box 0
        ([0.0, 8.0, 16.0], 0.0, 2),  # at 12 of 10: box 1 tips under box 2
    ],
)
def test_planar_layouts_get_the_same_verdict_in_2d_and_3d(across, shifts, offset, step):
    # A box falls when the centre of mass of what stands above an edge lies beyond it.
    lay = wall(shifts, across=across, offset=offset)
    found = {
        engine: make_method(f"simulation@{engine}:t_max=0.5,between_steps=reseat").judge(lay)
        for engine in TESTED
    }
    steps = {engine: verdict.failing_step for engine, verdict in found.items()}
    assert set(steps.values()) == {step}, steps


def test_both_frames_are_rotations():
    lay = layout(((0, 0, 0), (10, 20, 30), (1, 2, 3)))
    for across in ("width", "depth"):
        unit = []
        for axis in range(3):
            position = [0.0, 0.0, 0.0]
            position[axis] = 10.0
            (box,) = boxes(layout((tuple(position), (10, 20, 30))), across=across)
            (base,) = boxes(layout(((0, 0, 0), (10, 20, 30))), across=across)
            unit.append(np.subtract(box.centre, base.centre) / 0.1)
        assert np.linalg.det(np.array(unit)) == pytest.approx(1.0)
        (box,) = boxes(lay, across=across)
        assert box.size[2] == pytest.approx(0.2)
        assert box.mass_offset[2] == pytest.approx(0.02)


def test_shrinking_leaves_tops_and_bases_alone():
    lay = layout(((0, 0, 0), (10, 20, 0.05)))
    (box,) = boxes(lay, shrink=1e-4)
    # World x is the layout's z (0.05 cm deep): at most a thousandth of a side on each side.
    assert box.size == pytest.approx((0.0005 * (1 - 2e-3), 0.1 - 2e-4, 0.2))
    assert box.centre == pytest.approx(boxes(lay)[0].centre)


def test_a_neighbourhood_is_the_stack_and_what_stands_beside_it():
    lay = layout(
        ((0, 0, 0), (10, 10, 10)),
        ((10, 0, 0), (10, 10, 10)),  # touches item 0 sideways
        ((60, 0, 60), (10, 10, 10)),  # far away
        ((0, 10, 0), (10, 10, 10)),  # on item 0
        ((0, 20, 0), (10, 10, 10)),  # on item 3
        ((60, 10, 60), (10, 10, 10)),
    )
    part = neighbourhood(lay, np.array([0, 3, 4]), reach=5.0)
    assert part.free.tolist() == [0, 3, 4]
    assert part.fixed.tolist() == [1]
    assert neighbourhood(lay, np.array([0, 3, 4]), reach=50.0).fixed.tolist() == [1, 2]
    assert neighbourhood(lay, np.array([0]), reach=5.0).fixed.tolist() == []


def test_items_are_joined_by_standing_on_each_other_and_by_bridges():
    lay = layout(
        ((0, 0, 0), (10, 10, 10)),
        ((10, 0, 0), (10, 10, 10)),  # touches item 0 sideways only
        ((30, 0, 0), (10, 10, 10)),
        ((30, 10, 0), (10, 10, 10)),  # on item 2
        ((15, 10, 0), (10, 10, 10)),  # on item 1
        ((40, 0, 0), (10, 10, 10)),
        ((20, 20, 0), (20, 5, 10)),  # a bridge over 3 and 4
        ((0, 10, 0), (10, 10, 10)),  # on item 0
        ((35, 25, 0), (5, 5, 5)),  # on the bridge
        ((15, 20, 0), (5, 5, 10)),  # on item 4, which the bridge joined to others
        ((15, 25, 0), (15, 5, 10)),  # on items 6 and 9, which are joined already
    )
    whole = [1, 2, 3, 4, 6, 8, 9, 10]
    groups = [lay.supports.joined(step) for step in range(len(lay))]
    assert groups == [
        [0], [1], [2], [2, 3], [1, 4], [5], [1, 2, 3, 4, 6], [0, 7], whole[:6], whole[:7], whole,
    ]  # fmt: skip


@pytest.mark.parametrize("engine", SLOW_LAST)
def test_local_scope_gives_the_verdicts_of_the_whole(engine):
    layouts = random_layouts(30, seed=5)
    base = f"simulation@{engine}:frequency=240,between_steps=reseat,samples=1"
    whole = make_method(base).judge_many(layouts)
    local = make_method(f"{base},scope=local").judge_many(layouts)
    same = [a.failing_step == b.failing_step for a, b in zip(whole, local, strict=True)]
    assert sum(same) >= 27, same
    assert sum(v.effort.substeps for v in local) == pytest.approx(
        sum(v.effort.substeps for v in whole), rel=0.15
    )


def test_local_scope_reaches_as_far_as_what_may_move_and_not_as_what_comes_later():
    # Cubes 20 cm apart, out of reach of each other; a beam as long as its reach is 16 cm more.
    cubes = [Item(k, (30.0 * k, 0.0, 0.0), (10.0, 10.0, 10.0), 1.0) for k in range(2)]
    beam = Item(2, (0.0, 0.0, 90.0), (90.0, 10.0, 10.0), 1.0)
    method = make_method("simulation@mujoco:between_steps=reseat,scope=local")
    few = method.judge(Layout("cubes", PALLET, tuple(cubes))).effort.boxes
    many = method.judge(Layout("cubes", PALLET, (*cubes, beam))).effort.boxes
    assert (few, many) == (2, 3)


@pytest.mark.parametrize("scope", ["local", "widening", "moving"])
def test_a_scope_needs_reseating(scope):
    with pytest.raises(ValueError, match=f"scope={scope} needs between_steps=reseat"):
        make_method(f"simulation@mujoco:rest_speed=0.01,scope={scope}")


def test_widening_scope_needs_a_speed_of_rest():
    with pytest.raises(ValueError, match="scope=widening needs a rest_speed above 0"):
        make_method("simulation@mujoco:between_steps=reseat,scope=widening")


@pytest.mark.parametrize("engine", SLOW_LAST)
def test_widening_scope_gives_the_verdicts_of_the_whole_for_less(engine):
    layouts = random_layouts(30, seed=5)
    base = f"simulation@{engine}:frequency=120,between_steps=reseat,rest_speed=0.01"
    whole = make_method(base).judge_many(layouts)
    widening = make_method(f"{base},scope=widening").judge_many(layouts)
    same = [a.failing_step == b.failing_step for a, b in zip(whole, widening, strict=True)]
    assert sum(same) >= 28, same
    spent = [sum(v.effort.body_substeps for v in verdicts) for verdicts in (whole, widening)]
    assert spent[1] < 0.7 * spent[0]


@pytest.mark.parametrize("engine", SPATIAL)
@pytest.mark.parametrize("held", [True, False])
def test_widening_scope_asks_the_whole_what_holds_up_an_item(engine, held):
    # Half a bar and more hangs over its post; a heavy lid on its short end would hold it, and so
    # does a neighbour that stands right under the other end without touching it by 1 mm.
    post = Item(0, (0.0, 0.0, 0.0), (20.0, 20.0, 20.0), 50.0)
    under = Item(1, (40.0, 0.0, 0.0), (20.0, 19.9 if held else 10.0, 20.0), 50.0)
    bar = Item(2, (8.0, 20.0, 0.0), (48.0, 10.0, 20.0), 10.0)
    lay = Layout("hangs", PALLET, (post, under, bar))
    assert lay.supports.joined(2) == [0, 2]
    base = f"simulation@{engine}:t_max=0.6,between_steps=reseat,rest_speed=0.01"
    verdicts = [make_method(f"{base},scope={scope}").judge(lay) for scope in ("all", "widening")]
    assert [v.failing_step for v in verdicts] == [None if held else 2] * 2


@pytest.mark.parametrize("engine", SPATIAL)
def test_widening_scope_takes_an_item_alone_on_the_floor_for_stable(engine):
    method = make_method(f"label@{engine}:frequency=120,rest_speed=0.01,scope=widening")
    verdict = method.judge(layout(((0, 0, 0), (9, 9, 9)), ((9, 0, 0), (9, 9, 9))))
    assert (verdict.status, verdict.failing_step) == (Status.DONE, None)
    assert verdict.effort == Effort()


@pytest.mark.parametrize("engine", SPATIAL)
def test_widening_scope_leaves_nothing_below_an_item_that_hangs(engine):
    # A cube over a plank that it does not touch: with the plank it tips over its edge, without it
    # falls by 4 cm and stands on the floor.
    plank = Item(0, (40.0, 0.0, 20.0), (30.0, 4.0, 30.0), 20.0)
    cube = Item(1, (58.0, 4.05, 20.0), (30.0, 30.0, 30.0), 10.0)
    method = f"simulation@{engine}:t_max=0.4,frequency=120,samples=3,between_steps=reseat"
    stated = f"{method},criterion=adams,eps_t=5,eps_r=3,rest_speed=0.05"
    lay = Layout("hangs", PALLET, (plank, cube))
    verdicts = [make_method(f"{stated},scope={scope}").judge(lay) for scope in ("all", "widening")]
    assert [v.failing_step for v in verdicts] == [1, 1]


def test_effort_counts_boxes_looks_and_substeps():
    # 0.3 s in 3 parts of 12 substeps at 120 Hz. Nothing is looked at before 3 x 0.01 / 9.8 s, that
    # is 1 substep; calm at looks 1 and 2 of a placement, then its poses are looked at.
    stands = wall([0.0, 0.0])
    base = "simulation@mujoco:frequency=120,between_steps=reseat,criterion=adams,samples=3"
    whole = make_method(base).judge(stands).effort
    # One box, then one more; all 36 substeps with 1 box, then with 2; one look at the end of each.
    assert whole == Effort(worlds=1, boxes=2, looks=2, substeps=72, body_substeps=36 + 72)
    rested = make_method(f"{base},rest_speed=0.01").judge(stands).effort
    assert rested == Effort(worlds=1, boxes=2, looks=6, substeps=48, body_substeps=24 + 48)
    # Two stacks side by side. Item 0 and 1 are alone on the floor. 2 comes to stand on 0 and 3 on
    # 1: two boxes each, in a world of their own.
    pair = layout(
        ((0, 0, 0), (10, 10, 10)),
        ((50, 0, 0), (10, 10, 10)),
        ((0, 10, 0), (10, 10, 10)),
        ((50, 10, 0), (10, 10, 10)),
    )
    widening = make_method(f"{base},rest_speed=0.01,scope=widening").judge(pair).effort
    assert widening == Effort(worlds=2, boxes=4, looks=6, substeps=48, body_substeps=96)


@pytest.mark.parametrize("engine", TESTED)
def test_stopping_at_rest_saves_substeps_and_keeps_clear_verdicts(engine):
    stands, falls = wall([0.0] * 4), wall([0.0, 12.0])
    base = f"simulation@{engine}:frequency=240,between_steps=reseat,samples=10"
    plain, rested = make_method(base), make_method(f"{base},rest_speed=0.01")
    assert rested.judge(stands).failing_step is None
    assert rested.judge(stands).effort.substeps < 0.6 * plain.judge(stands).effort.substeps
    assert rested.judge(falls).failing_step == plain.judge(falls).failing_step == 1


@pytest.mark.parametrize(
    "values",
    [
        "frequency=30,rest_speed=0.01",
        "frequency=90,samples=100,rest_speed=0.001",
        "frequency=1000,samples=300,rest_speed=0.01",
        "frequency=480,samples=144,rest_speed=0.03",
    ],
)
def test_nothing_is_at_rest_before_it_could_move(values):
    method = make_method(f"simulation@mujoco:between_steps=reseat,{values}")
    assert method.judge(wall([0.0, 15.0])).failing_step == 1


@pytest.mark.parametrize("engine", SPATIAL)
@pytest.mark.parametrize("gap", [2.5, 4.0])
def test_local_scope_keeps_what_stops_a_fall(engine, gap):
    # A tall item leans over and is caught by a heavy one across a gap wider than the threshold.
    items = (
        Item(0, (0.0, 0.0, 0.0), (20.0, 20.0, 40.0), 50.0),
        Item(1, (30.0 + gap, 0.0, 0.0), (80.0, 120.0, 40.0), 900.0),
        Item(2, (14.0, 20.0, 0.0), (16.0, 80.0, 40.0), 10.0),
    )
    lay = Layout("caught", Pallet(200.0, 200.0, 200.0), items)
    verdicts = [
        make_method(f"ps3@{engine}:restitution=0,scope={scope}").judge(lay).failing_step
        for scope in ("all", "local")
    ]
    assert verdicts == [None, None]


def test_a_timeout_keeps_what_was_ignored(stack):
    verdict = make_method("ps3@mujoco").judge(stack(0.0, 0.0), timeout=1e-9)
    assert (verdict.status, verdict.ignored) == (Status.TIMEOUT, ("restitution",))
    assert verdict.effort.substeps > 0


def test_contacts_that_dart_would_drop_are_an_error():
    # 17 x 17 cubes rest on the floor: 1156 contacts.
    items = tuple(
        Item(k, (5.0 * (k % 17), 0.0, 5.0 * (k // 17)), (4.0, 4.0, 4.0), 0.1) for k in range(289)
    )
    lay = Layout("many", PALLET, items)
    verdict = make_method("simulation@dart:frequency=60,t_max=0.02,samples=1").judge(lay)
    assert verdict.status is Status.ERROR
    assert "keeps 1000 contacts" in verdict.reason


@pytest.mark.parametrize("engine", TESTED)
def test_an_early_exit_keeps_clear_verdicts(engine):
    base = f"simulation@{engine}:t_max=1,between_steps=reseat,criterion=adams,samples=20"
    plain, early = make_method(base), make_method(f"{base},early_exit=2")
    for lay, step in ((wall([0.0] * 4), None), (wall([0.0, 14.0]), 1)):
        assert plain.judge(lay).failing_step == early.judge(lay).failing_step == step
    assert early.judge(lay).effort.substeps < plain.judge(lay).effort.substeps


@pytest.mark.parametrize("engine", TESTED)
def test_a_timeout_is_a_status_and_changes_no_verdict(engine):
    lay = wall([0.0] * 6)
    method = make_method(f"simulation@{engine}:frequency=240")
    calm = method.judge(lay)
    assert method.judge(lay, timeout=1000.0).failing_step == calm.failing_step
    assert method.judge(lay, timeout=1000.0).effort.substeps == calm.effort.substeps
    falls = wall([0.0, 12.0])
    timed = method.judge(falls, timeout=1000.0)
    assert timed.displacement == method.judge(falls).displacement
    late = method.judge(lay, timeout=1e-9)
    assert (late.status, late.score) == (Status.TIMEOUT, None)
    assert "no verdict within" in late.reason


@pytest.mark.parametrize("engine", SPATIAL)
def test_extreme_sizes_run_to_a_verdict(engine):
    # Sides from 0.1 cm to 500 cm in one layout.
    items = (
        Item(0, (0.0, 0.0, 0.0), (500.0, 10.0, 500.0), 500.0),
        Item(1, (10.0, 10.0, 10.0), (0.1, 0.1, 0.1), 1e-6),
        Item(2, (20.0, 10.0, 20.0), (0.1, 500.0, 100.0), 10.0),
        Item(3, (60.0, 10.0, 20.0), (100.0, 0.1, 100.0), 1.0),
        Item(4, (60.0, 10.1, 20.0), (100.0, 100.0, 100.0), 250.0),
    )
    lay = Layout("extreme", Pallet(500.0, 600.0, 500.0), items)
    verdict = make_method(f"ps_opt-paper@{engine}").judge(lay, timeout=60.0)
    assert verdict.status in (Status.DONE, Status.DIVERGED, Status.TIMEOUT)


def test_jitter_displaces_every_item_a_little_and_always_the_same_way():
    layout = random_layouts(3, seed=1)[2]
    plain = np.array([b.centre for b in boxes(layout)])
    moved = [np.array([b.centre for b in boxes(layout, jitter=1e-4, seed=s)]) for s in (0, 0, 1)]
    shift = moved[0] - plain
    assert (moved[0] == moved[1]).all()
    assert (moved[0] != moved[2]).all()
    assert np.abs(shift).min() > 0.0
    assert 5e-5 < np.abs(shift).max() <= 1e-4
    other = boxes(layout.renamed("another"), jitter=1e-4)
    assert (np.array([b.centre for b in other]) != moved[0]).all()
