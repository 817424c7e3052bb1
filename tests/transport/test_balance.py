"""The exact limit: against closed forms, sums of forces, and its own dual."""

import math

import numpy as np
import pytest

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.methods.registry import make_method
from steadyload.statics.friction import Sides
from steadyload.transport.balance import BalanceProgramme, Mode

PALLET = Pallet(120.0, 200.0, 80.0)


def load(*boxes):
    """A layout of boxes (corner, size, weight[, shift of the centre of mass])."""
    items = tuple(Item(k, *box) for k, box in enumerate(boxes))
    return Layout("load", PALLET, items)


@pytest.mark.parametrize("friction", [0.2, 0.5, 0.8])
@pytest.mark.parametrize("size", [(20.0, 10.0, 30.0), (10.0, 40.0, 24.0), (15.0, 15.0, 15.0)])
@pytest.mark.parametrize("shift", [(0.0, 0.0, 0.0), (1.5, -3.0, 2.0)])
def test_a_single_box_slides_at_its_friction_or_tips_over_its_edge(friction, size, shift):
    programme = BalanceProgramme(load(((40.0, 0.0, 30.0), size, 7.0, shift)), friction)
    height = 0.5 * size[1] + shift[1]
    levers = {
        0.0: 0.5 * size[0] - shift[0],
        90.0: 0.5 * size[2] - shift[2],
        180.0: 0.5 * size[0] + shift[0],
        270.0: 0.5 * size[2] + shift[2],
    }
    for direction, lever in levers.items():
        found = programme.limit(direction)
        assert found.limit_g == pytest.approx(min(friction, lever / height), abs=1e-6)
        if abs(friction - lever / height) > 0.01:
            assert found.mode == (Mode.SLIDES if friction < lever / height else Mode.TIPS)


def test_along_the_diagonal_a_box_tips_over_the_nearer_edge():
    size = (10.0, 40.0, 16.0)
    programme = BalanceProgramme(load(((40.0, 0.0, 30.0), size, 7.0)), 0.9)
    for degrees in (20.0, 45.0, 70.0):
        angle = math.radians(degrees)
        edges = 5.0 / (20.0 * math.cos(angle)), 8.0 / (20.0 * math.sin(angle))
        assert programme.limit(degrees).limit_g == pytest.approx(min(edges), abs=1e-6)


@pytest.mark.parametrize("count", [1, 3, 6])
def test_a_column_of_equal_boxes_tips_as_one(count):
    boxes = [((40.0, 12.0 * k, 30.0), (20.0, 12.0, 20.0), 5.0) for k in range(count)]
    found = BalanceProgramme(load(*boxes), 1.5).limit(0.0)
    assert found.limit_g == pytest.approx(min(1.5, 10.0 / (6.0 * count)), abs=1e-6)


@pytest.mark.parametrize("heavy", [1.0, 1e3, 1e5, 1e7])
@pytest.mark.parametrize("place", [(80.0, 0.0, 30.0), (40.0, 30.0, 30.0)])
def test_a_heavy_box_hides_nothing_of_a_light_one_beside_or_on_it(heavy, place):
    block = ((30.0, 0.0, 20.0), (40.0, 30.0, 40.0), 0.01 * heavy)
    programme = BalanceProgramme(load(block, (place, (10.0, 40.0, 10.0), 0.01)), 0.5)
    for direction, limit in ((0.0, 0.25), (45.0, 0.25 * math.sqrt(2.0)), (90.0, 0.25)):
        found = programme.limit(direction)
        assert found.limit_g == pytest.approx(limit, abs=1e-5)
        assert (found.moved_item, found.mode) == (1, Mode.TIPS)


def test_a_light_box_on_a_heavy_one_slides_no_sooner():
    """The limit of sliding does not hang on masses."""
    found = []
    for low, up in ((1.0, 1.0), (30.0, 0.5), (2.0, 40.0)):
        below = (40.0, 0.0, 30.0), (30.0, 10.0, 30.0), low
        above = (45.0, 10.0, 35.0), (20.0, 4.0, 20.0), up
        found.append(BalanceProgramme(load(below, above), 0.4).limit(90.0))
    assert [one.limit_g for one in found] == pytest.approx([0.4] * 3, abs=1e-6)
    assert {one.mode for one in found} == {Mode.SLIDES}


def test_a_load_that_does_not_stand_holds_nothing():
    tips = load(
        ((0.0, 0.0, 0.0), (20.0, 10.0, 20.0), 5.0), ((14.0, 10.0, 0.0), (20.0, 10.0, 20.0), 5.0)
    )
    found = BalanceProgramme(tips, 0.5).limit(0.0)
    assert (found.limit_g, found.mode, found.moved_item) == (0.0, Mode.FALLS, 1)


def test_a_neighbour_stops_a_box_that_would_tip():
    """A tall box before a heavy one holds more towards it than away from it."""
    two = load(
        ((40.0, 0.0, 30.0), (10.0, 60.0, 20.0), 2.0), ((50.0, 0.0, 20.0), (40.0, 60.0, 40.0), 80.0)
    )
    programme = BalanceProgramme(two, 0.6)
    towards, away = programme.limit(0.0), programme.limit(180.0)
    assert away.limit_g == pytest.approx(5.0 / 30.0, abs=1e-6)
    assert (away.moved_item, away.mode) == (0, Mode.TIPS)
    assert towards.limit_g > 2.0 * away.limit_g
    alone = BalanceProgramme(two, 0.6, Sides.NONE).limit(0.0)
    assert alone.limit_g == pytest.approx(5.0 / 30.0, abs=1e-6)


@pytest.fixture(scope="module")
def loads():
    """Real pallets and packed layouts, some of which stand."""
    found = []
    for name, limit in (("real", 25), ("lists", 25)):
        benchmark = load_benchmark(name)
        cases = benchmark.select("test", limit=limit, scenarios=("S1",))
        found += [benchmark.layout(layout, "S1") for layout in cases["layout"]]
    return found


def test_forces_balance_every_box_and_lie_within_their_cones(loads):
    """Summed box by box, not by the solver."""
    friction, checked = 0.5, 0
    for layout in loads:
        programme = BalanceProgramme(layout, friction)
        for direction in (0.0, 130.0):
            held = programme.limit(direction)
            if held.mode is Mode.FALLS:
                continue
            points, mean = programme.points, layout.weights.mean()
            normal = np.take_along_axis(held.forces, points.axes[:, None], axis=1)[:, 0]
            along = np.sqrt(np.maximum((held.forces**2).sum(axis=1) - normal**2, 0.0))
            rough = points.axes == 1
            assert normal.min() > -1e-6
            assert (along - np.where(rough, friction, 0.0) * normal).max() < 1e-6
            angle = math.radians(direction)
            push = held.limit_g * np.array([math.cos(angle), 0.0, math.sin(angle)])
            centres = 0.5 * (layout.lower + layout.upper) + layout.mass_offsets
            for item, weight in enumerate(layout.weights / mean):
                force = weight * (push - (0.0, 1.0, 0.0))
                moment = np.zeros(3)
                for body, sign in ((points.second, 1.0), (points.first, -1.0)):
                    mine = body == item
                    own = sign * held.forces[mine]
                    force = force + own.sum(axis=0)
                    arms = points.positions[mine] - centres[item]
                    moment += np.cross(arms, own).sum(axis=0)
                assert np.abs(force).max() < 1e-6 * max(1.0, layout.weights.max() / mean)
                assert np.abs(moment).max() < 1e-5 * max(1.0, layout.weights.max() / mean)
            checked += 1
    assert checked > 30


def test_beyond_the_limit_no_force_stops_the_motion_of_the_dual(loads):
    """The motion gains power from gravity just beyond the limit, and no contact can brake it."""
    friction, checked = 0.5, 0
    for layout in loads:
        programme = BalanceProgramme(layout, friction)
        held = programme.limit(45.0)
        motion = held.motion / max(1e-12, np.abs(held.motion).max())
        centres = 0.5 * (layout.lower + layout.upper) + layout.mass_offsets
        points = programme.points

        def speed(body, points=points, motion=motion, centres=centres):
            found = np.zeros((len(points), 3))
            free = body >= 0
            arms = points.positions[free] - centres[body[free]]
            found[free] = motion[body[free], :3] + np.cross(motion[body[free], 3:], arms)
            return found

        parts = speed(points.second) - speed(points.first)
        apart = np.take_along_axis(parts, points.axes[:, None], axis=1)[:, 0]
        slides = np.sqrt(np.maximum((parts**2).sum(axis=1) - apart**2, 0.0))
        rough = np.where(points.axes == 1, friction, 0.0)
        # The most that a force in its cone could take: a normal part opens, its friction brakes.
        assert (apart - rough * slides).min() > -1e-4
        angle = math.radians(45.0)
        level = held.limit_g * (1.0 + 1e-3) + 1e-3
        gravity = np.array([level * math.cos(angle), -1.0, level * math.sin(angle)])
        power = (layout.weights[:, None] * motion[:, :3] * gravity).sum()
        assert power > 0.0
        checked += 1
    assert checked == len(loads)


def test_a_load_that_stands_by_the_method_stands_by_the_programme():
    method = make_method("equilibrium:sides=frictionless")
    benchmark = load_benchmark("lists")
    cases = benchmark.select("test", limit=20)
    for name, scenario in zip(cases["layout"], cases["scenario"], strict=True):
        layout = benchmark.layout(name, scenario)
        if method.judge(layout).score == 1.0:
            assert BalanceProgramme(layout, 0.5).limit(0.0).mode is not Mode.FALLS, name
