"""Exact equilibrium against closed forms, an independent linear programme, and symmetries."""

import dataclasses

import numpy as np
import pytest
from hand_layouts import failing_step, layout
from scipy.optimize import linprog

from steadyload.core.constants import STANDS
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.model.scenarios import Scenario
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods import make_method
from steadyload.methods.contract.spec import SpecError
from steadyload.methods.contract.stopwatch import Stopwatch
from steadyload.methods.session.session import LoadingSession
from steadyload.statics.balance import solve
from steadyload.statics.margins import margins

PALLET = Pallet(200.0, 200.0, 200.0)
SIDES = ("none", "frictionless", "friction")


# --- closed forms ---------------------------------------------------------------------------------


def overhangs(steps):
    """A stack of blocks of 20 cm, each standing out by this much over the one below, bottom up."""
    x = 20.0 + np.concatenate(([0.0], np.cumsum(steps)))
    return layout(*((float(v), 5.0 * k, 0.0, 20.0, 5.0, 8.0) for k, v in enumerate(x)))


def test_harmonic_stack_stands_at_the_limit_and_falls_beyond_it():
    # L/2, L/4, ... from the top down: every upper part has its centre of mass above the edge that
    # carries it, which is balanced.
    limit = [20.0 / (2.0 * k) for k in range(6, 0, -1)]
    assert failing_step("equilibrium", overhangs(limit)) is None
    for k in range(6):
        further = list(limit)
        further[k] += 1e-3
        assert failing_step("equilibrium", overhangs(further)) == 6
    # SME looks one item up only and accepts it.
    assert failing_step("sme", overhangs([*limit[:3], limit[3] + 0.5, *limit[4:]])) is None


def test_an_edge_is_included():
    assert failing_step("equilibrium", layout(
        (0.0, 0.0, 0.0, 10.0, 10.0, 10.0), (5.0, 10.0, 0.0, 10.0, 10.0, 10.0))) is None  # fmt: skip
    verdict = make_method("equilibrium").judge(layout(
        (0.0, 0.0, 0.0, 10.0, 10.0, 10.0), (5.001, 10.0, 0.0, 10.0, 10.0, 10.0)))  # fmt: skip
    assert (verdict.failing_step, verdict.moved_item) == (1, 1)
    assert "item 1" in verdict.reason


BLOCK = (50.0, 0.0, 0.0, 30.0, 10.0, 10.0)
PLANK = (60.0, 10.0, 0.0, 30.0, 2.0, 10.0, 1.0)


@pytest.mark.parametrize(("load", "fails"), [(0.599, None), (0.601, 2)])
def test_a_load_on_the_end_of_a_plank_that_stands_out_by_a_third(load, fails):
    # The plank's weight acts 5 cm inside the edge, the load 10 - 1 = 9 cm outside, less 2/3 cm:
    # width 10/3 puts its centre 25/3 cm out, so it tips beyond 5 / (25/3) = 0.6 of the plank.
    width = 10.0 / 3.0
    lay = layout(BLOCK, PLANK, (90.0 - width, 12.0, 0.0, width, 2.0, 10.0, load))
    verdict = make_method("equilibrium").judge(lay)
    assert verdict.failing_step == fails
    if fails:
        assert verdict.moved_item in (1, 2)


def test_a_counterweight_holds_down_a_cantilever():
    load = (80.0, 12.0, 0.0, 10.0, 10.0, 10.0, 1.5)
    weight = (60.0, 12.0, 0.0, 10.0, 10.0, 10.0, 0.3)
    # 1.5 kg 5 cm out against 1 kg 5 cm in and 0.3 kg 15 cm in: 7.5 < 5 + 4.5.
    assert failing_step("equilibrium", layout(BLOCK, PLANK, weight, load)) is None
    assert failing_step("equilibrium", layout(BLOCK, PLANK, load, weight)) == 2
    # Each step is judged afresh: with the counterweight the loaded plank has a margin again.
    before, after = margins(layout(BLOCK, PLANK, load, weight))[2:]
    assert before.patches < 0.0 < after.patches


def test_a_bridge_needs_both_supports_and_its_load_between_them():
    posts = ((0.0, 0.0, 0.0, 4.0, 10.0, 10.0), (26.0, 0.0, 0.0, 4.0, 10.0, 10.0))
    plank = (0.0, 10.0, 0.0, 30.0, 2.0, 10.0)
    middle = (13.0, 12.0, 0.0, 4.0, 50.0, 10.0, 100.0)
    assert failing_step("equilibrium", layout(*posts, plank, middle)) is None
    assert failing_step("equilibrium", layout(posts[0], plank, posts[1])) == 1
    # Posts further in, and 100 kg on the end that stands out.
    inside = ((10.0, 0.0, 0.0, 4.0, 10.0, 10.0), (16.0, 0.0, 0.0, 4.0, 10.0, 10.0))
    end = (0.0, 12.0, 0.0, 4.0, 50.0, 10.0, 100.0)
    assert failing_step("equilibrium", layout(*inside, plank, end)) == 3


def test_a_load_may_be_shared_where_one_way_of_passing_it_down_fails():
    # A wide box stands on the outer ends of two cantilevers and on a post between them. Carried by
    # the post alone it stands; pressed on the cantilevers as well, it would tip them.
    lay = layout(
        (0.0, 0.0, 0.0, 10.0, 10.0, 10.0),
        (50.0, 0.0, 0.0, 10.0, 10.0, 10.0),
        (28.0, 0.0, 0.0, 4.0, 12.0, 10.0),
        (2.0, 10.0, 0.0, 14.0, 2.0, 10.0, 0.01),
        (44.0, 10.0, 0.0, 14.0, 2.0, 10.0, 0.01),
        (12.0, 12.0, 0.0, 36.0, 5.0, 10.0, 5.0),
    )
    assert failing_step("equilibrium", lay) is None
    # A little to the side of the post, one cantilever has to help and tips.
    shifted = dataclasses.replace(lay.items[5], mass_offset=(-5.0, 0.0, 0.0))
    assert failing_step("equilibrium", Layout("s", PALLET, (*lay.items[:5], shifted))) == 5


def test_a_supporter_that_carries_nothing_yet_may_be_loaded():
    # The plank's weight passes through its left supporter alone; then the right one gets a load.
    lay = layout(
        (0.0, 0.0, 0.0, 20.0, 10.0, 10.0),
        (0.0, 10.0, 0.0, 10.0, 5.0, 10.0),
        (10.0, 10.0, 0.0, 10.0, 5.0, 10.0),
        (0.0, 15.0, 0.0, 13.0, 2.0, 10.0),
        (14.0, 15.0, 0.0, 5.0, 5.0, 10.0),
    )
    assert failing_step("equilibrium", lay) is None


def test_forces_add_up_to_the_weight():
    lay = layout(
        BLOCK, (60.0, 10.0, 0.0, 30.0, 2.0, 10.0, 7.0), (60.0, 12.0, 0.0, 9.0, 9.0, 9.0, 5.0)
    )
    below = lay.supports.below
    found = solve(lay, [1, 2], [*below[1], *below[2]])
    assert found.ended == STANDS
    plank, box = found.forces.sum(axis=1)
    assert (plank, box) == pytest.approx((12.0, 5.0))


def test_a_plate_on_two_opposite_corners(plate):
    # The points of the posts nearest to the centre of mass do not carry it.
    assert failing_step("equilibrium", plate(0.499)) is None
    assert failing_step("equilibrium", plate(0.5)) is None  # on the edge; SME's hull is strict
    assert failing_step("equilibrium", plate(0.501)) == 2


def test_only_items_placed_before_support():
    late = layout((0.0, 10.0, 0.0, 10.0, 10.0, 10.0), (0.0, 0.0, 0.0, 10.0, 10.0, 10.0))
    assert failing_step("equilibrium", late) == 0
    # The post under the end of the plank comes after the load that tips it.
    load = (80.0, 12.0, 0.0, 10.0, 10.0, 10.0, 1.5)
    post = (85.0, 0.0, 0.0, 5.0, 10.0, 10.0)
    assert failing_step("equilibrium", layout(BLOCK, PLANK, load, post)) == 2
    assert failing_step("equilibrium", layout(BLOCK, PLANK, post, load)) is None


# --- against independent answers ------------------------------------------------------------------


def dense_failing_step(lay, grow=1e-6):
    """The first step at which one linear programme over all items is infeasible."""
    contacts, centres = lay.contacts, 0.5 * (lay.lower + lay.upper) + lay.mass_offsets
    for step in range(len(lay)):
        count, columns = step + 1, []
        pairs = [
            (-1, j, lay.lower[j, ::2], lay.upper[j, ::2])
            for j in np.flatnonzero(contacts.on_floor[:count])
        ]
        pairs += [
            (i, j, corners[:2], corners[2:])
            for i, j, corners in zip(contacts.below, contacts.above, contacts.corners, strict=True)
            if max(i, j) < count
        ]
        for i, j, low, high in pairs:
            for x in (low[0] - grow, high[0] + grow):
                for z in (low[1] - grow, high[1] + grow):
                    column = np.zeros((count, 3))
                    for k, sign in ((i, -1.0), (j, 1.0)):
                        if k >= 0:
                            arm = (1.0, x - centres[k, 0], z - centres[k, 2])
                            column[k] += sign * np.array(arm)
                    columns.append(column.ravel())
        weight = np.zeros((count, 3))
        weight[:, 0] = lay.weights[:count] / lay.weights[:count].mean()
        if not columns:
            return step
        matrix = np.array(columns).T
        if linprog(np.zeros(len(columns)), A_eq=matrix, b_eq=weight.ravel()).status:
            return step
    return None


def test_the_verdict_is_that_of_a_dense_linear_programme():
    layouts = random_layouts(45, seed=31)
    said = [failing_step("equilibrium", lay) for lay in layouts]
    assert said == [dense_failing_step(lay) for lay in layouts]
    assert 5 < sum(step is not None for step in said) < 40


def test_sides_accept_no_less_and_time_fails_no_earlier():
    for lay in random_layouts(18, seed=32):
        plain, smooth, rough, timed = (
            len(lay) if step is None else step
            for step in (failing_step(f"equilibrium{o}", lay)
                         for o in ("", ":sides=frictionless", ":sides=friction", ":time=0.3"))
        )  # fmt: skip
        assert plain <= smooth <= rough
        assert plain <= timed


@pytest.mark.parametrize("seed", range(40))
def test_two_boxes_on_each_other_are_judged_as_by_sme(seed):
    random = np.random.default_rng(seed)
    shift = random.uniform(-9.0, 9.0, 2)
    offset = random.uniform(-4.0, 4.0, 3)
    below = Item(0, (20.0, 0.0, 20.0), (10.0, 10.0, 10.0), 1.0)
    above = Item(1, (20.0 + shift[0], 10.0, 20.0 + shift[1]), (10.0, 10.0, 10.0), 3.0, (*offset,))
    lay = Layout("two", PALLET, (below, above))
    assert failing_step("equilibrium", lay) == failing_step("sme", lay)


# --- symmetries -----------------------------------------------------------------------------------


def translated(item):
    x, y, z = item.position
    return dataclasses.replace(item, position=(x + 31.7, y, z + 12.3))


def quarter_turn(item):
    (x, y, z), (w, h, d), (a, b, c) = item.position, item.size, item.mass_offset
    return dataclasses.replace(
        item, position=(z, y, 150.0 - x - w), size=(d, h, w), mass_offset=(c, b, -a)
    )


def mirrored(item):
    (x, y, z), (w, _, _), (a, b, c) = item.position, item.size, item.mass_offset
    return dataclasses.replace(item, position=(150.0 - x - w, y, z), mass_offset=(-a, b, c))


def lighter(item):
    return dataclasses.replace(item, weight=item.weight * 1e-3)


def heavier(item):
    return dataclasses.replace(item, weight=item.weight * 700.0)


def longer(item):
    scaled = {k: tuple(30.0 * v for v in getattr(item, k))
              for k in ("position", "size", "mass_offset")}  # fmt: skip
    return dataclasses.replace(item, **scaled)


@pytest.mark.parametrize("sides", SIDES)
@pytest.mark.parametrize(
    "change",
    [translated, quarter_turn, mirrored, lighter, heavier, longer],
    ids=lambda f: f.__name__,
)
def test_the_verdict_does_not_depend_on_place_attitude_or_units(change, sides):
    contour = Pallet(6000.0, 6000.0, 6000.0)
    method = make_method(f"equilibrium:sides={sides}")
    for lay in random_layouts(12 if sides == "none" else 6, seed=33):
        other = Layout(lay.name, contour, tuple(change(item) for item in lay.items))
        assert method.judge(other).failing_step == method.judge(lay).failing_step


@pytest.mark.parametrize("change", [translated, lighter, heavier], ids=lambda f: f.__name__)
def test_the_time_model_depends_on_neither_place_nor_unit_of_mass(change):
    contour, method = Pallet(6000.0, 6000.0, 6000.0), make_method("equilibrium:time=0.3")
    for lay in random_layouts(12, seed=34):
        other = Layout(lay.name, contour, tuple(change(item) for item in lay.items))
        one, two = method.judge(lay), method.judge(other)
        assert (one.failing_step, one.moved_item) == (two.failing_step, two.moved_item)
        if one.failing_step is not None:
            assert one.rotation == pytest.approx(two.rotation, rel=1e-6, abs=1e-6)


# --- margins --------------------------------------------------------------------------------------


def test_the_margin_of_a_block_is_its_distance_from_the_edge():
    lay = layout((10.0, 0.0, 0.0, 10.0, 10.0, 10.0), (13.0, 10.0, 0.0, 10.0, 10.0, 10.0))
    first, second = margins(lay)
    # Alone it stands on a patch of 10 cm, its centre of mass 5 cm from each edge.
    assert (first.item, second.item) == (0, 1)
    assert (first.patches, first.centres) == pytest.approx((5.0, 5.0), abs=1e-6)
    # 3 cm out: the centre of mass lies 2 cm inside the edge.
    assert (second.patches, second.centres) == pytest.approx((2.0, 2.0), abs=1e-6)


def test_the_margin_is_negative_where_balance_is_lost():
    lay = layout((10.0, 0.0, 0.0, 10.0, 10.0, 10.0), (17.0, 10.0, 0.0, 10.0, 10.0, 10.0))
    lost = margins(lay)[1]
    assert lost.item == 1
    assert (lost.patches, lost.centres) == pytest.approx((-2.0, -2.0), abs=1e-6)
    nothing = margins(layout((10.0, 5.0, 0.0, 10.0, 10.0, 10.0)))[0]
    assert (nothing.patches, nothing.centres) == (-np.inf, -np.inf)
    assert np.isnan(margins(lay, centres=False)[1].centres)


def test_the_margin_of_a_stack_is_that_of_its_weakest_joint():
    # Shifted by 4, then by 1: over the lowest edge the joint centre of the upper two (7 and 9.5
    # cm past its left end, mean 9.5 of 10) has 0.5 cm; the topmost alone has 4 cm.
    lay = layout(*((10.0 + x, 5.0 * k, 0.0, 10.0, 5.0, 10.0) for k, x in enumerate((0, 4.0, 5.0))))
    last = margins(lay)[2]
    assert last.patches == pytest.approx(0.5, abs=1e-6)
    # A shift of either upper centre by 1 cm moves the joint centre by half of it.
    assert last.centres == pytest.approx(1.0, abs=1e-6)
    # Three times as heavy at the top: (9 + 3 * 10) / 4 = 9.75, and a shift counts three quarters.
    heavy = Layout("heavy", PALLET, (*lay.items[:2], dataclasses.replace(lay.items[2], weight=3.0)))
    last = margins(heavy)[2]
    assert (last.patches, last.centres) == pytest.approx((0.25, 1.0 / 3.0), abs=1e-6)


def test_margins_have_the_sign_of_the_verdict():
    for lay in random_layouts(9, seed=35):
        found = margins(lay)
        step = failing_step("equilibrium", lay)
        for kind in ("patches", "centres"):
            lost = [m.step for m in found if getattr(m, kind) < -1e-4]
            assert (lost[0] if lost else None) == step


# --- sides and friction ---------------------------------------------------------------------------


def clamped(weight):
    """A box of 1 kg between two others, with nothing under it."""
    return layout(
        (10.0, 0.0, 0.0, 10.0, 30.0, 10.0, weight),
        (30.0, 0.0, 0.0, 10.0, 30.0, 10.0, weight),
        (20.0, 10.0, 0.0, 10.0, 10.0, 10.0, 1.0),
    )


def test_friction_on_sides_accepts_a_jammed_box_that_falls():
    assert failing_step("equilibrium", clamped(10.0)) == 2
    assert failing_step("equilibrium:sides=frictionless", clamped(10.0)) == 2
    assert failing_step("equilibrium:time=0.3", clamped(10.0)) == 2
    assert failing_step("label@reference", clamped(10.0)) == 2
    assert failing_step("equilibrium:sides=friction", clamped(10.0)) is None
    # The clamping force N must satisfy 2 mu N >= 1 and N <= mu (w + 1/2), so w >= 1.5.
    assert failing_step("equilibrium:sides=friction", clamped(1.51)) is None
    assert failing_step("equilibrium:sides=friction", clamped(1.49)) == 2
    assert failing_step("equilibrium:sides=friction,friction=0.45", clamped(1.51)) == 2


def test_exact_cones_accept_what_coarse_pyramids_refuse():
    # With three edges a pyramid reaches half as far down as up: more clamping is asked for.
    spec = "equilibrium:sides=friction,facets=3"
    assert failing_step(spec, clamped(1.7)) == 2
    assert failing_step(f"{spec},cones=exact", clamped(1.7)) is None
    assert failing_step(f"{spec},cones=exact", clamped(1.4)) == 2


def test_a_wall_holds_a_box_that_leans_on_it():
    # The centre of mass lies 1 cm beyond the edge, towards a heavy wall that the box touches.
    wall = (15.0, 0.0, 0.0, 10.0, 40.0, 10.0, 50.0)
    base, box = (0.0, 0.0, 0.0, 8.0, 10.0, 10.0), (3.0, 10.0, 0.0, 12.0, 20.0, 10.0)
    assert failing_step("equilibrium", layout(wall, base, box)) == 2
    assert failing_step("equilibrium:sides=frictionless", layout(wall, base, box)) is None
    assert failing_step("equilibrium:time=0.3", layout(wall, base, box)) is None
    assert failing_step("label@reference", layout(wall, base, box)) is None


# --- plumbing -------------------------------------------------------------------------------------


@pytest.mark.parametrize("extreme", [1e-9, 1e6])
def test_weights_may_differ_by_many_orders(extreme):
    tower = layout(*((20.0, 5.0 * k, 0.0, 10.0, 5.0, 10.0, extreme if k == 2 else 1.0)
                     for k in range(6)))  # fmt: skip
    assert failing_step("equilibrium", tower) is None


@pytest.mark.parametrize("spec", [f"equilibrium:sides={sides}" for sides in SIDES])
@pytest.mark.parametrize("ratio", [10.0**k for k in range(13)])
def test_a_light_and_a_heavy_box_stand_up_to_the_edge_and_no_further(ratio, spec):
    heavy = min(1e6, ratio)
    light = heavy / ratio
    base, box = (20.0, 0.0, 0.0, 10.0, 10.0, 10.0), (10.0, 0.0, 10.0, 10.0, 10.0)
    for below, above in ((heavy, light), (light, heavy)):
        for overhang, fails in ((4.99, None), (5.01, 1), (7.0, 1)):
            lay = layout((*base, below), (20.0 + overhang, *box, above))
            assert failing_step(spec, lay) == fails


@pytest.mark.parametrize("spec", [f"equilibrium:sides={sides}" for sides in SIDES])
@pytest.mark.parametrize("ratio", [10.0**k for k in range(13)])
def test_a_light_plank_on_a_heavy_block_tips_at_the_same_load(ratio, spec):
    # The plank's centre lies 5 cm inside the edge, the load's 9 cm outside: it tips above 5 / 9.
    heavy = min(1e6, ratio)
    light = heavy / ratio * 2.0
    for share, fails in ((0.55, None), (0.56, 3)):
        lay = layout(
            (20.0, 0.0, 0.0, 20.0, 10.0, 10.0, heavy), (20.0, 10.0, 0.0, 20.0, 10.0, 10.0, heavy),
            (20.0, 20.0, 0.0, 30.0, 2.0, 10.0, light),
            (48.0, 22.0, 0.0, 2.0, 2.0, 10.0, light * share),
        )  # fmt: skip
        assert failing_step(spec, lay) == fails


def test_what_rounding_hides_is_an_error_and_no_verdict():
    """15 orders of magnitude, and a box whose centre lies 10 nm past what counts as the edge."""
    past = 5.0 + 1e-5 + 1e-6
    lay = layout((20.0, 0.0, 0.0, 10.0, 10.0, 10.0, 1e6),
                 (20.0 + past, 10.0, 0.0, 10.0, 10.0, 10.0, 1e-9))  # fmt: skip
    verdict = make_method("equilibrium:sides=friction").judge(lay)
    assert (verdict.status, verdict.score) == ("error", None)
    assert verdict.reason == (
        "step 1: forces cannot be told from rounding: the weights of items that touch each other "
        "differ by a factor of 1e+15"
    )


def test_options_are_checked():
    method = make_method("equilibrium:time=300ms,sides=friction")
    assert str(method.spec) == "equilibrium:sides=friction,time=0.3"
    assert make_method("equilibrium:time=none").parameters.time is None
    for wrong in ("sides=rough", "facets=2", "time=0", "cones=round", "friction=-1"):
        with pytest.raises(SpecError):
            make_method(f"equilibrium:{wrong}")


@pytest.mark.parametrize("margin", [0.01, 0.3])
def test_a_margin_is_what_every_patch_can_lose(margin):
    method, ways = make_method(f"equilibrium:margin={margin}"), set()
    layouts = random_layouts(60, seed=11, scenario=Scenario.S1)
    verdicts = method.judge_many(layouts)
    for lay, verdict in zip(layouts, verdicts, strict=True):
        lost = [m.step for m in margins(lay, centres=False) if m.patches < margin]
        assert verdict.failing_step == (lost[0] if lost else None), lay.name
        assert method.judge(lay).failing_step == verdict.failing_step
        ways.add((verdict.stable, make_method("equilibrium").judge(lay).stable))
    assert {(False, True), (True, True)} <= ways


def test_a_margin_of_a_session_and_of_single_steps_is_that_of_the_verdict():
    method = make_method("equilibrium:margin=0.2")
    for lay in random_layouts(20, seed=3, scenario=Scenario.S1):
        step = method.judge(lay).failing_step
        scorer = method.steps(lay, Stopwatch())
        end = len(lay) if step is None else step
        assert all(scorer.step_score(k) == 0.0 for k in range(end))
        assert step is None or scorer.step_score(step) == 1.0
        with LoadingSession(lay.pallet, method) as session:
            said = [session.try_place(item).stable for item in lay.items[: end + 1]]
        assert said == [True] * end + [False] * (step is not None)


def test_a_margin_is_for_vertical_forces_alone():
    for more in ("time=0.3", "sides=frictionless"):
        with pytest.raises(SpecError, match="without time and sides"):
            make_method(f"equilibrium:margin=0.1,{more}")
