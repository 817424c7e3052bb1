"""A session says of every placement what its method says of the whole layout by then."""

import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from convex_hulls import strictly_inside_hull
from hypothesis import given, settings
from hypothesis import strategies as st
from piles import top_below

from steadyload.engines.world import EngineError
from steadyload.layouts import Item, Layout, LayoutError, Pallet
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods import Status
from steadyload.methods.contract.method import STABLE, Finding, Method, Seconds, WholeLoader
from steadyload.methods.contract.spec import MethodSpec
from steadyload.methods.equilibrium import equilibrium
from steadyload.methods.session.session import LoadingSession, SessionError
from steadyload.methods.simulation.placements import Placements
from steadyload.properties.strategies import layouts, packings
from steadyload.statics.touching import touching_points

FEW = settings(max_examples=40, derandomize=True)

RULES = (
    "fbs",
    "pbs0.7",
    "sme",
    "equilibrium",
    "equilibrium:margin=1.5",
    "equilibrium:time=0.3",
    "equilibrium:sides=friction",
    "lstm_1:outside=accept",
    "lstm_e:outside=accept",
)


def step(verdict):
    """What is asked of every method."""
    return (verdict.item_count, verdict.status, verdict.failing_step)


def said(verdict):
    """All of a verdict but its times and what was simulated for it."""
    moved = (verdict.displacement, verdict.rotation)
    numbers = (None if m is None else pytest.approx(m, rel=1e-6, abs=1e-6) for m in moved)
    return (*step(verdict), verdict.moved_item, verdict.reason, *numbers)


def place_and_compare(session, item, told=said):
    """Try an item; see that the verdict is that on the whole, and that a rejected one is gone."""
    before = session.items
    verdict = session.try_place(item)
    after = (*before, replace(item, sequence=len(before)))
    whole = session.method.judge(Layout("session", session.pallet, after))
    assert told(verdict) == told(whole)
    assert session.items == (after if verdict.stable else before)
    return verdict


def walk(session, items, undos=(0,), told=said):
    """Place items, and undo so many steps after each; returns how many placements were stable."""
    stable = 0
    for place, item in enumerate(items):
        stable += place_and_compare(session, item, told).stable
        kept = session.items
        gone = session.undo(min(undos[place % len(undos)], len(session)))
        assert (*session.items, *gone) == kept
    return stable


WIDE = Pallet(30.0, 400.0, 20.0)

_box = st.tuples(
    *[st.integers(4, 20)] * 3,  # sides
    *[st.integers(0, 20)] * 2,  # x, z, as far as there is room
    *[st.sampled_from((0.0, 0.0, 0.3, -0.3))] * 2,  # offsets along x and z, in shares
    st.sampled_from((1.0, 1.0, 20.0)),
)
boxes = st.lists(_box, min_size=3, max_size=14)


def let_down(session, box):
    """A box as an item that lies on what is below it there."""
    width, height, depth, x, z, shift_x, shift_z, weight = box
    x, z = min(x, 30 - width), min(z, 20 - depth)
    top = top_below(session.items, x, z, width, depth)
    offset = (shift_x * width, 0.0, shift_z * depth)
    size = (float(width), float(height), float(depth))
    return Item(0, (x, top, z), size, weight, offset)


@pytest.mark.parametrize("spec", RULES)
@FEW
@given(boxes=boxes, undos=st.lists(st.sampled_from((0, 0, 0, 0, 1, 2)), min_size=1))
def test_a_rule_says_of_boxes_that_lie_anyhow_what_it_says_of_the_whole(spec, boxes, undos):
    session = LoadingSession(WIDE, spec)
    for place, box in enumerate(boxes):
        place_and_compare(session, let_down(session, box))
        session.undo(min(undos[place % len(undos)], len(session)))


@pytest.mark.parametrize("spec", RULES)
@FEW
@given(data=st.data(), layout=layouts() | packings(most=15))
def test_a_rule_says_step_by_step_what_it_says_of_the_whole(spec, data, layout):
    # In any order: then items float, and others are pushed in below them.
    items = data.draw(st.permutations(layout.items) | st.just(layout.items))
    undos = data.draw(st.lists(st.sampled_from((0, 0, 0, 1, 3)), min_size=1, max_size=20))
    walk(LoadingSession(layout.pallet, spec), items, undos)


@pytest.mark.parametrize(
    ("spec", "told"),
    [
        ("label@mujoco", said),
        ("label@mujoco:scope=local,jitter=0.1mm", said),
        ("ps_opt@mujoco", said),  # widening
        ("ps_opt-paper@mujoco", said),  # carries its state on
        # Of Bullet's worlds one differs from the next in some digits, whoever asks.
        ("label@bullet:scope=local", step),
        ("ps_opt@bullet", step),
    ],
)
def test_a_simulation_says_step_by_step_what_it_says_of_the_whole(spec, told):
    stable = count = 0
    for layout in random_layouts(4, seed=5):
        items = layout.first(8).items
        with LoadingSession(layout.pallet, spec) as session:
            stable += walk(session, items, (0, 0, 0, 2, 0), told)
        count += len(items)
    assert 0 < stable < count


def test_a_planar_engine_judges_in_the_plane_that_is_left():
    # The second box leaves the first's depth, the third its width: then there is no plane.
    plank = {"size": (30.0, 10.0, 20.0), "weight": 2.0}
    items = [
        Item(0, (0.0, 0.0, 40.0), **plank),
        Item(0, (0.0, 10.0, 45.0), **plank),
        Item(0, (5.0, 20.0, 45.0), **plank),
        Item(0, (0.0, 20.0, 65.0), **plank),  # falls
        Item(0, (0.0, 20.0, 45.0), **plank),
    ]
    with LoadingSession(Pallet(100.0, 100.0, 100.0), "label@chipmunk") as session:
        verdicts = [place_and_compare(session, item) for item in items]
        assert [v.stable for v in verdicts] == [True, True, False, False, True]
        assert [v.status for v in verdicts[2:4]] == [Status.REFUSED, Status.DONE]
        session.undo(2)
        # Now the depth is shared again, and the width no more.
        assert place_and_compare(session, Item(0, (10.0, 10.0, 40.0), **plank)).stable


def recursively_supported(layout, step):
    """SME as the authors write it: the new item, and then everything below it."""
    scene = layout.supports
    part = layout.first(step + 1)
    centre = 0.5 * (part.lower + part.upper) + part.mass_offsets

    def supported(item):
        if scene.on_floor[item]:
            return True
        who = [item, *(a for a in scene.above[item] if a <= step)]
        x, _, z = np.average(centre[who], axis=0, weights=part.weights[who])
        patches = [p for p in scene.below[item] if p.below <= step]
        corners = [(a, b) for p in patches for a in (p.x0, p.x1) for b in (p.z0, p.z1)]
        low, high = part.lower, part.upper
        over = any(
            low[p.below, 0] - 1e-9 <= x <= high[p.below, 0] + 1e-9
            and low[p.below, 2] - 1e-9 <= z <= high[p.below, 2] + 1e-9
            for p in patches
        )
        inside = over or strictly_inside_hull((x, z), corners, 1e-9)
        return inside and all(supported(p.below) for p in patches)

    return supported(step)


@FEW
@given(boxes=boxes)
def test_sme_asks_enough_when_it_asks_the_new_item_and_its_carriers(boxes):
    session = LoadingSession(WIDE, "sme")
    for box in boxes:
        item = let_down(session, box)
        whole = Layout("session", WIDE, (*session.items, replace(item, sequence=len(session))))
        assert session.try_place(item).stable == recursively_supported(whole, len(whole) - 1)


# --- many places at once ----


def some_places(draw, session, size):
    """Places at corners of what is loaded, some moved a little, some that cannot be."""
    corners = [(0.0, 0.0, 0.0), (30.0, 0.0, 20.0)]
    for item in session.items:
        corners += [item.position, tuple(np.add(item.position, item.size))]
    axes = [sorted({corner[k] for corner in corners}) for k in range(3)]
    places = [[draw.choice(values) for values in axes] for _ in range(60)]
    places += [np.subtract(at, (size[0], 0.0, 0.0)).tolist() for at in places[:20]]
    moved = [np.add(at, draw.choice((0.005, 0.02, 1.0, -2.0), 3)).tolist() for at in places[:20]]
    return [*places, *moved, [np.nan, 0.0, 0.0], [0.0, np.inf, 0.0], [1e300, -1e300, 0.0]]


def said_of_places(session, item, places):
    """What try_place says of an item at places, and that it keeps to the verdict on the whole."""
    for at in places:
        try:
            stable = place_and_compare(session, replace(item, position=tuple(at))).stable
        except LayoutError:
            stable = False
        if stable:
            session.undo()
        yield stable


@pytest.mark.parametrize("floor", ["auto", "deck", "infinite"])
@pytest.mark.parametrize(
    "spec", ["fbs", "pbs0.7", "pbs:alpha=0", "sme", "equilibrium", "equilibrium:margin=1.5"]
)
@settings(FEW, max_examples=4)
@given(boxes=boxes, seed=st.integers(0, 1000))
def test_places_are_feasible_where_the_item_could_be_placed(spec, floor, boxes, seed):
    session, draw = LoadingSession(replace(WIDE, floor=floor), spec), np.random.default_rng(seed)
    for box in boxes:
        item = let_down(session, box)
        session.try_place(item)
    before = session.items
    places = some_places(draw, session, item.size)
    found = session.feasible(item, places)
    assert found.shape == (len(places),)
    assert session.items == before
    assert found.tolist() == list(said_of_places(session, item, places))
    # And once more, after so much came and went.
    assert (session.feasible(item, places) == found).all()


@pytest.mark.parametrize(
    "spec", ["label@mujoco", "equilibrium:time=0.3", "equilibrium:sides=friction"]
)
def test_any_method_says_where_an_item_would_stand(spec):
    with LoadingSession(Pallet(100.0, 40.0, 20.0), spec) as session:
        for x in (0.0, 20.0):
            session.try_place(cube(x))
        places = [
            (10.0, 0.0, 0.0),
            (5.0, 0.0, 0.0),
            (5.0, 10.0, 0.0),
            (28.0, 10.0, 0.0),
            (95, 0, 0),
        ]
        found = session.feasible(cube(0.0), places)
        assert found.tolist() == list(said_of_places(session, cube(0.0), places))
        assert session.feasible(cube(0.0), np.empty((0, 3))).tolist() == []
        assert len(session) == 2


@pytest.mark.parametrize(
    "positions", [(0.0, 0.0, 0.0), [(0.0, 0.0)], "here", [["a", "b", "c"]], []]
)
def test_positions_of_another_shape_are_refused(positions):
    session = LoadingSession(WIDE, "fbs")
    with pytest.raises(SessionError, match=r"positions .*allowed: numbers \[cm\], shape \(K, 3\)"):
        session.feasible(cube(0.0), positions)


@FEW
@given(boxes=boxes, undos=st.lists(st.sampled_from((0, 0, 1, 2)), min_size=1))
def test_forces_that_are_kept_are_those_of_what_is_loaded(boxes, undos):
    def forces(session):
        held = session._layout._session
        return [held.below(box).presses.tolist() for box in range(len(held))]

    session = LoadingSession(WIDE, "equilibrium")
    for place, box in enumerate(boxes):
        item = let_down(session, box)
        session.feasible(item, [item.position, (0.0, 0.0, 0.0)])
        session.try_place(item)
        session.undo(min(undos[place % len(undos)], len(session)))
    afresh = LoadingSession(WIDE, "equilibrium")
    assert all(afresh.try_place(item).stable for item in session.items)
    assert forces(session.fork()) == forces(session) == forces(afresh)


def test_where_rounding_hides_balance_the_whole_is_judged():
    # A feather under a mass that is so much heavier that what is left of its forces is noise.
    pallet = Pallet(100.0, 100.0, 100.0)
    session = LoadingSession(pallet, "equilibrium")
    boxes = ((0, 0, 10, 1.0), (20, 0, 10, 1.0), (5, 10, 20, 1e-9), (5, 20, 20, 1e6), (5, 30, 20, 1))
    for x, y, width, weight in boxes:
        item = Item(0, (float(x), float(y), 0.0), (float(width), 10.0, 10.0), weight)
        places = [item.position, (50.0, 0.0, 0.0)]
        found = session.feasible(item, places)
        assert found.tolist() == list(said_of_places(session, item, places))
        place_and_compare(session, item)


# --- searches -----------------------------------------------------------------------------------


@pytest.mark.parametrize("spec", ["pbs0.7", "sme", "equilibrium:time=0.3", "lstm_e:outside=accept"])
@settings(FEW, max_examples=12)
@given(boxes=boxes, others=boxes)
def test_a_fork_and_what_it_came_from_go_on_by_themselves(spec, boxes, others):
    session = LoadingSession(WIDE, spec)
    for box in boxes:
        session.try_place(let_down(session, box))
    other = session.fork()
    before = session.items
    assert other.items == before
    for box in others[:5]:
        place_and_compare(other, let_down(other, box))
    assert session.items == before
    for branch in (session, other):
        branch.undo(min(2, len(branch)))
        for box in others[:3]:
            place_and_compare(branch, let_down(branch, box))


@pytest.mark.parametrize("spec", ["ps_opt@mujoco", "ps_opt-paper@mujoco"])
def test_forks_of_simulations_go_on_by_themselves(spec):
    for layout in random_layouts(3, seed=8):
        *first, last = layout.first(8).items
        with LoadingSession(layout.pallet, spec) as session:
            walk(session, first)
            with session.fork() as other:
                before = session.items
                other.undo()
                place_and_compare(other, last)
                assert session.items == before
            place_and_compare(session, last)


class _Counting(Method):
    """Every item is fine but those that are named; what is asked is kept."""

    def __init__(self):
        super().__init__(MethodSpec("counting"), None)
        self.asked = []

    def _judge(self, layout, watch):
        self.asked.append(len(layout))
        name = layout.items[-1].name
        if name == "raises":
            raise ZeroDivisionError(name)
        return Finding(failing_step=len(layout) - 1) if name == "fails" else STABLE


def cube(x, name=""):
    return Item(0, (x, 0.0, 0.0), (10.0, 10.0, 10.0), 1.0, name=name)


def test_a_method_without_a_loader_of_its_own_judges_the_whole():
    method = _Counting()
    session = LoadingSession(Pallet(100.0, 20.0, 20.0), method)
    assert isinstance(method.begin(None), WholeLoader)
    assert session.try_place(cube(0.0)).stable
    assert not session.try_place(cube(10.0, "fails")).stable
    assert session.try_place(cube(10.0)).stable
    other = session.fork()
    assert other.try_place(cube(20.0)).item_count == 3
    assert len(session) == 2
    assert method.asked == [1, 2, 2, 3]


def test_whatever_a_placement_comes_to_the_session_stays_as_it_was():
    session = LoadingSession(Pallet(100.0, 20.0, 20.0), _Counting())
    session.try_place(cube(0.0))
    with pytest.raises(ZeroDivisionError):
        session.try_place(cube(10.0, "raises"))
    for x, wrong in ((5.0, "overlaps item 0 by 5 cm"), (105.0, "spans x = 105 to 115 cm")):
        with pytest.raises(LayoutError, match=wrong):
            session.try_place(cube(x))
    assert session.items == (cube(0.0),)
    assert session.layout().items == session.items


@pytest.mark.parametrize("timed", [True, False])
def test_a_placement_that_takes_too_long_is_not_kept(timed):
    how = {"timeout": 1e-9, "timed": timed}
    with LoadingSession(Pallet(100.0, 20.0, 20.0), "label@mujoco", **how) as session:
        assert session.try_place(cube(0.0)).status is Status.TIMEOUT
        assert len(session) == 0


@pytest.mark.parametrize("spec", ["label@mujoco", "ps_opt@bullet", "ps_opt-paper@mujoco"])
def test_an_engine_that_fails_at_one_item_judges_the_next(spec, monkeypatch):
    settle = Placements._settle

    def give_up(self, step, *others):
        found = settle(self, step, *others)
        if step == 2:
            raise EngineError("out of memory")
        return found

    with LoadingSession(Pallet(100.0, 40.0, 20.0), spec) as session:
        walk(session, [cube(0.0), cube(10.0)], told=step)
        with monkeypatch.context() as patch:
            patch.setattr(Placements, "_settle", give_up)
            on_top = replace(cube(5.0), position=(5.0, 10.0, 0.0))
            verdict = session.try_place(on_top)
            assert (verdict.status, verdict.reason) == (Status.ERROR, "out of memory")
        assert walk(session, [on_top, cube(20.0)], told=step) == 2


@pytest.mark.parametrize("spec", ["fbs", "sme", "equilibrium", "label@mujoco"])
def test_without_times_verdicts_are_the_same_and_state_none(spec):
    with (
        LoadingSession(Pallet(100.0, 40.0, 20.0), spec, timed=False) as session,
        LoadingSession(Pallet(100.0, 40.0, 20.0), spec) as other,
        session.fork() as fork,
    ):
        for at in ((0.0, 0.0), (8.0, 10.0), (10.0, 0.0), (10.0, 10.0), (95.0, 0.0)):
            item = replace(cube(0.0), position=(*at, 0.0))
            verdict, timed = session.try_place(item), other.try_place(item)
            assert verdict == fork.try_place(item) == replace(timed, cpu=Seconds(), wall=Seconds())
            assert timed.wall.total > 0.0


def test_only_what_is_loaded_can_be_undone():
    session = LoadingSession(Pallet(100.0, 20.0, 20.0), "fbs")
    session.try_place(cube(0.0))
    for steps in (2, -1):
        with pytest.raises(SessionError, match="allowed: 0 to 1, the items loaded"):
            session.undo(steps)
    assert session.undo() == (cube(0.0),)
    with pytest.raises(LayoutError, match="has no items"):
        session.layout()


# --- cost ---------------------------------------------------------------------------------------


def instructions(call):
    """How many byte codes Python runs in a call."""
    count = 0

    def trace(frame, event, argument):
        nonlocal count
        frame.f_trace_opcodes = True
        count += event == "opcode"
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        call()
    finally:
        sys.settrace(before)
    return count


def pile(number):
    """Five boxes at a place of their own: a bridge on two posts, loaded twice."""
    z = 81.0 * number  # a whole number of cells of the index: all piles lie alike in them
    boxes = [
        ((0.0, 0.0), (10.0, 20.0)), ((30.0, 0.0), (10.0, 20.0)), ((0.0, 20.0), (40.0, 5.0)),
        ((5.0, 25.0), (12.0, 12.0)), ((20.0, 25.0), (18.0, 7.0)),
    ]  # fmt: skip
    return [Item(0, (x, y, z), (w, h, 20.0), 1.0) for (x, y), (w, h) in boxes]


@pytest.mark.parametrize(
    "spec",
    ["pbs0.5", "sme", "equilibrium", "equilibrium:sides=frictionless,time=0.3",
     "equilibrium:time=0.3"],
)  # fmt: skip
def test_a_placement_takes_as_much_after_800_items_as_after_500(spec):
    session = LoadingSession(Pallet(100.0, 100.0, 14_000.0), spec)
    taken = {}
    for number in range(161):
        *first, last = pile(number)
        overhanging = replace(last, position=(39.5, *last.position[1:]))
        tried = [*first, overhanging, last]
        work = [partial(session.try_place, item) for item in tried]
        work += [session.undo, partial(session.try_place, last)]
        if number in (100, 160):
            taken[number] = [instructions(call) for call in work]
            if spec == "equilibrium:time=0.3":  # what does not balance is judged as a whole
                del taken[number][tried.index(overhanging)]
        else:
            for call in work:
                call()
    assert len(session) == 161 * 5
    assert taken[160] == pytest.approx(taken[100], rel=0.1)


def test_what_may_be_in_the_way_of_a_fall_is_looked_for_nearby(monkeypatch):
    met = []

    def noted(layout, items, firm, **how):
        met.append((list(items), list(firm)))
        return touching_points(layout, items, firm, **how)

    monkeypatch.setattr(equilibrium, "touching_points", noted)
    session = LoadingSession(
        Pallet(100.0, 100.0, 3000.0), "equilibrium:sides=frictionless,time=0.3"
    )
    for number in range(20):
        for item in pile(number):
            session.try_place(item)
    *_, last = pile(7)
    session.undo(3)
    overhanging = replace(last, position=(39.5, 25.0, 81.0 * 7), size=(18.0, 7.0, 10.0))
    assert not session.try_place(overhanging).stable
    group, firm = met[-1]
    assert {item // 5 for item in (*group, *firm) if item < len(session)} == {7}


def test_a_closed_session_can_be_read_and_nothing_else():
    with LoadingSession(Pallet(100.0, 20.0, 20.0), "fbs") as session:
        session.try_place(cube(0.0))
        fork = session.fork()
    for use in (lambda: session.try_place(cube(10.0)), session.undo, session.fork):
        with pytest.raises(SessionError, match="the session is closed; allowed: to read"):
            use()
    assert len(session) == len(session.layout()) == len(session.items) == 1
    session.close()
    assert fork.try_place(cube(10.0)).stable


@pytest.mark.parametrize(
    "use",
    [
        lambda session: session.try_place(cube(20.0)),
        lambda session: session.feasible(cube(20.0), [(20.0, 0.0, 0.0)]),
        lambda session: session.undo(),
        lambda session: session.fork(),
        lambda session: session.layout(),
        lambda session: session.items,
        lambda session: session.close(),
    ],
    ids=["try_place", "feasible", "undo", "fork", "layout", "items", "close"],
)
def test_a_second_thread_is_refused_while_the_first_is_in_the_session(use):
    """The item that is just being judged must not be seen, nor taken off."""
    session = LoadingSession(Pallet(100.0, 20.0, 20.0), "fbs")
    session.try_place(cube(0.0))
    refused = []

    def other_thread():
        try:
            use(session)
        except SessionError as error:
            refused.append(str(error))

    load = session._loader.load

    def meanwhile(item, watch):
        thread = threading.Thread(target=other_thread)
        thread.start()
        thread.join()
        return load(item, watch)

    session._loader.load = meanwhile
    assert session.try_place(cube(10.0)).stable
    assert refused == [
        "the session is in use by another thread; allowed: one thread at a time, or a fork() "
        "for each"
    ]
    session._loader.load = load
    assert len(session) == 2
    assert session.try_place(cube(20.0)).stable


def test_forks_are_used_by_as_many_threads():
    session = LoadingSession(Pallet(100.0, 20.0, 20.0), "fbs")
    session.try_place(cube(0.0))
    forks = [session.fork() for _ in range(8)]
    with ThreadPoolExecutor(4) as pool:
        found = pool.map(lambda fork: fork.try_place(cube(10.0)).stable, forks)
        assert all(found)


@pytest.mark.parametrize("spec", ["sme", "label@mujoco"])
def test_a_placement_that_crushes_a_box_is_refused(spec):
    weak = replace(cube(0.0), max_load=15.0)
    on_top = [replace(cube(0.0), position=(0.0, 10.0 * k, 0.0), weight=8.0) for k in (1, 2)]
    with LoadingSession(Pallet(100.0, 60.0, 20.0), spec) as session:
        assert session.try_place(weak).stable
        assert session.try_place(on_top[0]).stable
        places = [on_top[1].position, (30.0, 0.0, 0.0)]
        assert session.feasible(on_top[1], places).tolist() == [False, True]
        with session.fork() as other:
            verdict = other.try_place(on_top[1])
        assert not verdict.stable
        assert (verdict.failing_step, verdict.moved_item) == (2, 0)
        assert verdict.reason == "crushed when the 3rd box is placed: box 1 of 3 bears 16 kg of 15"
        assert len(session) == 2
        light = replace(on_top[1], weight=6.0)
        assert session.feasible(light, places).tolist() == [True, True]
        assert session.try_place(light).stable


@pytest.mark.parametrize(("margin", "stands"), [(0.0, True), (0.4, True), (1.0, False)])
def test_a_margin_draws_in_what_was_pushed_in_below_an_item(margin, stands):
    """A load 0.5 cm inside the edge of a block that came after the plank that it carries."""
    carrier = Item(0, (0.0, 0.0, 0.0), (20.0, 10.0, 10.0), 50.0)
    plank = Item(0, (0.0, 10.0, 0.0), (24.0, 1.0, 10.0), 1.0)
    pushed_in = Item(0, (20.0, 0.0, 0.0), (3.0, 10.0, 10.0), 50.0)
    load = Item(0, (21.5, 11.0, 0.0), (2.0, 10.0, 10.0), 1000.0)
    with LoadingSession(WIDE, f"equilibrium:margin={margin:g}") as session:
        for item in (carrier, plank, pushed_in):
            assert place_and_compare(session, item).stable
        assert session.feasible(load, [load.position]).tolist() == [stands]
        assert place_and_compare(session, load).stable is stands
