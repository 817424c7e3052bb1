"""Forces and loads of piles that can be worked out by hand."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from steadyload.errors import UnsolvedError
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.layouts.packing.packing import random_layouts
from steadyload.numbers import NumberError
from steadyload.statics.bearing.crushing import first_crushed
from steadyload.statics.bearing.forces import Statics, contact_forces
from steadyload.statics.bearing.loads import loads, payload
from steadyload.time_limit import TimeoutExpiredError

PALLET = Pallet(100, 200, 100)


def pile(*items):
    """A layout of (position, size, weight, mass offset x, max load)."""
    boxes = (
        Item(k, at, size, weight, (shift, 0.0, 0.0), f"B{k}", most)
        for k, (at, size, weight, shift, most) in enumerate(items)
    )
    return Layout("pile", PALLET, tuple(boxes))


def column(*weights, most=None):
    return pile(
        *(((0.0, 10.0 * k, 0.0), (20.0, 10.0, 20.0), w, 0.0, most) for k, w in enumerate(weights))
    )


def bridge(shift, *, most=None, weight=40.0):
    """A plank of 50 cm on two posts of 10 cm, its centre of mass off the middle."""
    post = (10.0, 10.0, 10.0)
    return pile(
        ((0.0, 0.0, 0.0), post, 1.0, 0.0, most),
        ((40.0, 0.0, 0.0), post, 1.0, 0.0, most),
        ((0.0, 10.0, 0.0), (50.0, 10.0, 10.0), weight, shift, None),
    )


def test_a_column_bears_what_stands_on_it():
    found = loads(column(5.0, 6.0, 7.0, 8.0))
    for values in (found.borne, found.least, found.most):
        assert values == pytest.approx([21.0, 15.0, 8.0, 0.0], abs=1e-4)


UNEQUAL = [
    (1e-9, 1e6),
    (1e6, 1e-9, 1e6),
    (1e6, 1.0, 1e-3, 1e6, 1e-3),
    (*[1e-3] * 6, 1e6),
    tuple(10.0**k for k in range(-6, 4)),
]
"""Weights of columns from the bottom up."""


@pytest.mark.parametrize("weights", UNEQUAL)
def test_a_column_bears_what_stands_on_it_however_weights_differ(weights):
    layout = column(*weights)
    above = [sum(weights[k + 1 :]) for k in range(len(weights))]
    found = loads(layout)
    for values in (found.borne, found.least, found.most):
        assert values == pytest.approx(above, rel=1e-6)
    assert np.isinf(payload(layout)).all()
    limited = column(*weights, most=2.0 * above[0])
    assert payload(limited) == pytest.approx([above[0]] * len(weights), rel=2e-3)
    held = contact_forces(layout).resultants()[:, 3]
    assert held == pytest.approx(np.cumsum(weights[::-1])[::-1], rel=1e-9)


def test_a_payload_that_no_programme_tells_is_no_payload_of_nothing(monkeypatch):
    failed = SimpleNamespace(success=False, status=4, message="it failed", fun=None)
    monkeypatch.setitem(payload.__globals__, "linprog", lambda *_, **__: failed)
    with pytest.raises(UnsolvedError, match="it failed"):
        payload(overhanging())


@pytest.mark.parametrize(("rows", "columns", "shift"), [(6, 3, 8.0), (6, 6, 6.0)])
def test_a_wall_of_shifted_rows_tips_under_no_weight(rows, columns, shift):
    """Below the middle of every box there are boxes down to the floor."""
    size = (20.0, 10.0, 20.0)
    places = [
        (20.0 * k + row % 2 * shift, 10.0 * row, 0.0) for row in range(rows) for k in range(columns)
    ]
    wall = Layout(
        "wall",
        Pallet(140, 80, 20),
        tuple(Item(k, place, size, 10.0) for k, place in enumerate(places)),
    )
    assert np.isinf(payload(wall)).all()


@pytest.mark.parametrize("sought", [loads, payload])
def test_loads_and_payloads_end_when_their_time_is_up(sought):
    with pytest.raises(TimeoutExpiredError, match=rf"^no {sought.__name__} within 1e-09 s of CPU"):
        sought(bridge(0.0), timeout=1e-9)
    with pytest.raises(NumberError):
        sought(bridge(0.0), timeout=0.0)


@pytest.mark.parametrize("sought", [loads, payload])
def test_a_programme_is_given_longer_while_cpu_time_is_left(sought, monkeypatch):
    """Its solver measures wall time, of which a busy machine takes more."""
    real, given = sought.__globals__["linprog"], []

    def busy(*all_of, options, **others):
        given.append(options["time_limit"])
        if len(given) < 3:
            return SimpleNamespace(success=False, status=1, message="time is up", fun=None)
        return real(*all_of, options=options, **others)

    monkeypatch.setitem(sought.__globals__, "linprog", busy)
    assert sought(bridge(0.0), timeout=100.0) is not None
    assert 99.0 < given[0] <= 100.0
    assert given[1:3] == [4.0 * given[0], 16.0 * given[0]]


@pytest.mark.parametrize("shift", [0.0, -5.0, 8.0])
def test_what_a_post_must_bear_at_least_is_the_law_of_the_lever(shift):
    """Its force acts where it helps most: at its outer edge, that of the other post at its inner
    one; at the most it is the other way round.
    """
    found = loads(bridge(shift))
    left = 25.0 + shift
    assert found.least[0] == pytest.approx(40.0 * (40.0 - left) / 40.0, abs=1e-3)
    assert found.most[0] == pytest.approx(40.0 * (50.0 - left) / 40.0, abs=1e-3)
    assert found.least[1] + found.most[0] == pytest.approx(40.0, abs=1e-3)
    assert found.least[0] < found.borne[0] < found.most[0]
    assert found.borne[:2].sum() == pytest.approx(40.0, abs=1e-6)


def brute_force(layout, item, points):
    """The least load on a box, over all pairs of points, one on each post, that carry the plank."""
    middle = 25.0 + layout.mass_offsets[2, 0]
    best = np.inf
    for a in np.linspace(0.0, 10.0, points):
        for b in np.linspace(40.0, 50.0, points):
            on_left = 40.0 * (b - middle) / (b - a)
            shares = (on_left, 40.0 - on_left)
            if min(shares) >= 0.0:
                best = min(best, shares[item])
    return best


@pytest.mark.parametrize("shift", [-9.0, -3.0, 2.5, 12.0])
@pytest.mark.parametrize("item", [0, 1])
def test_the_least_load_is_that_of_a_search_over_all_places_of_the_forces(shift, item):
    layout = bridge(shift)
    assert loads(layout).least[item] == pytest.approx(brute_force(layout, item, 41), abs=1e-3)


def test_forces_press_more_on_the_side_of_the_centre_of_mass():
    """Under one box on the floor, pressure varies evenly: mean force (1 + 12 e x / w^2) there."""
    forces = contact_forces(pile(((0.0, 0.0, 0.0), (20.0, 10.0, 20.0), 8.0, 2.0, None)))
    # Four corners: 2 (1 +- s) on each side with 2 x 2 s x 10 = 8 x 2.
    assert sorted(forces.forces) == pytest.approx([1.6, 1.6, 2.4, 2.4], abs=1e-4)


def overhanging():
    return pile(
        ((20.0, 0.0, 0.0), (20.0, 10.0, 20.0), 5.0, 0.0, None),
        ((33.0, 10.0, 0.0), (20.0, 10.0, 20.0), 6.0, -5.0, None),
    )


def mirrored(layout):
    """A layout seen in a mirror that stands across x."""
    width = layout.pallet.size[0]

    def of(item):
        (x, y, z), (dx, dy, dz) = item.position, item.mass_offset
        return replace(item, position=(width - x - item.size[0], y, z), mass_offset=(-dx, dy, dz))

    return replace(layout, items=tuple(map(of, layout.items)))


def swapped(layout):
    """A layout whose x is z, and whose z is x."""

    def of(item):
        changed = {name: getattr(item, name)[::-1] for name in ("position", "size", "mass_offset")}
        return replace(item, **changed)

    pallet = Pallet(*layout.pallet.size[::-1])
    return replace(layout, pallet=pallet, items=tuple(map(of, layout.items)))


WAYS = {
    "swapped": swapped,
    "mirrored": mirrored,
    "swapped and mirrored": lambda layout: mirrored(swapped(layout)),
    "mirrored and swapped": lambda layout: swapped(mirrored(layout)),
}
"""Ways to turn a pile about the vertical, so that what was worked out along x holds along z."""

ASYMMETRIC = {
    "bridge": lambda: bridge(-5.0, most=22.0),
    "overhanging": lambda: overhanging(),
    "three posts": lambda: on_three_posts(22.0),
    "packed": lambda: random_layouts(1, seed=1)[0].first(8),
}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", ASYMMETRIC)
def test_a_pile_bears_the_same_whichever_way_it_is_turned(name, way):
    layout = ASYMMETRIC[name]()
    other = WAYS[way](layout)
    one, turned = loads(layout), loads(other)
    assert one is not None
    for what in ("borne", "least", "most"):
        expected = pytest.approx(getattr(one, what), rel=1e-3, abs=2e-3)
        assert getattr(turned, what) == expected, what
    assert payload(other) == pytest.approx(payload(layout), rel=5e-3)
    crushed, also = first_crushed(layout), first_crushed(other)
    assert (crushed and (crushed.step, crushed.item)) == (also and (also.step, also.item))
    sizes = [np.sort(contact_forces(each).resultants()[:, 3]) for each in (layout, other)]
    assert sizes[1] == pytest.approx(sizes[0], abs=2e-3)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", ASYMMETRIC)
def test_a_weight_on_a_top_is_that_of_a_small_box_there(name, way):
    """Both sides of the equations: what is pressed on, and what stands on it."""
    layout = WAYS[way](ASYMMETRIC[name]())
    top = len(layout) - 1
    middle, weight = 0.5 * (layout.lower + layout.upper)[top], 0.5
    at = (middle[0] - 0.05, layout.upper[top, 1], middle[2] - 0.05)
    small = Item(top + 1, tuple(map(float, at)), (0.1, 0.1, 0.1), weight)
    statics, with_it = Statics(layout), replace(layout, items=(*layout.items, small))
    pressed = statics.least_energy(statics.right + weight * statics.pressed(top))
    stands = contact_forces(with_it)
    assert (pressed is None) == (stands is None)
    if pressed is not None:
        known = stands.forces[: len(pressed)]
        assert pressed == pytest.approx(known, abs=1e-3 * layout.weights.sum())


def test_what_falls_has_no_forces():
    falling = pile(
        ((0.0, 0.0, 0.0), (10.0, 10.0, 10.0), 1.0, 0.0, None),
        ((8.0, 10.0, 0.0), (10.0, 10.0, 10.0), 1.0, 0.0, None),
    )
    assert contact_forces(falling) is None
    assert loads(falling) is None
    assert payload(falling) is None


def test_the_first_box_that_bears_too_much_is_named():
    assert first_crushed(column(5.0, 6.0, 7.0, 8.0, most=21.0)) is None
    found = first_crushed(column(5.0, 6.0, 7.0, 9.0, most=21.0))
    assert (found.step, found.item, found.label) == (3, 0, "box B0 (1st of 4)")
    assert (found.bears_kg, found.allowed_kg) == (pytest.approx(22.0), 21.0)
    assert str(found) == "crushed when the 4th box is placed: box B0 (1st of 4) bears 22 kg of 21"
    assert first_crushed(column(5.0, 6.0, 7.0, 9.0)) is None


def test_a_load_that_is_shared_crushes_nobody():
    assert first_crushed(bridge(0.0, most=20.5)) is None
    found = first_crushed(bridge(-5.0, most=20.5))
    assert (found.item, found.step) == (0, 2)


def test_a_hair_beyond_its_limit_is_said_in_full():
    found = first_crushed(column(1.0, 10.001, most=10.0))
    assert str(found).endswith("bears 10.001 kg of 10")


def test_weights_beyond_four_digits_are_said_without_exponents():
    found = first_crushed(column(1.0, 16.0055, most=12.345))
    assert found.sentence(Frame(weight="g")).endswith("bears 16 kg of 12.3")
    heavy = first_crushed(column(1.0, 123456.0, most=20000.0))
    assert str(heavy).endswith("bears 123456 kg of 20000")


def test_the_payload_tips_at_the_lever_and_crushes_at_the_limit():
    # The upper box tips about x = 40: 6 kg at 38 hold W at 43.
    assert payload(overhanging()) == pytest.approx([np.inf, 4.0], rel=1e-3)
    assert payload(column(5.0, 6.0, 7.0, most=21.0)) == pytest.approx([8.0, 8.0, 8.0], rel=2e-3)
    assert payload(column(5.0, 6.0, 7.0, most=10.0)) == pytest.approx([0.0, 0.0, 0.0])


def on_three_posts(most=None, added=0.0):
    """A plank on three posts, its centre of mass at x = 10 cm, and a weight at x = 30 cm."""
    post = (5.0, 10.0, 10.0)
    boxes = [
        ((0.0, 0.0, 0.0), post, 1.0, 0.0, None),
        ((12.0, 0.0, 0.0), post, 1.0, 0.0, most),
        ((20.0, 0.0, 0.0), post, 1.0, 0.0, None),
        ((0.0, 10.0, 0.0), (60.0, 5.0, 10.0), 40.0, -20.0, None),
    ]
    if added:
        boxes.append(((29.95, 15.0, 4.95), (0.1, 0.1, 0.1), added, 0.0, None))
    return pile(*boxes)


@pytest.mark.parametrize("most", [15.0, 18.0, 22.0, 26.0])
def test_a_post_that_bears_more_and_then_less_is_crushed_on_the_way(most):
    """Three equally stiff posts, as springs: by hand. The plank tips at 120 kg."""
    places = np.array([2.5, 14.5, 22.5])
    about = places - places.mean()
    stiffness = (about**2).sum() + 3.0 * 2.5**2  # the posts yield at their own edges, too

    def bears(weight, x):
        return weight * (1.0 / 3.0 + about[1] * (x - places.mean()) / stiffness)

    by_hand = (most - bears(40.0, 10.0)) / bears(1.0, 30.0)
    found = payload(on_three_posts(most))[3]
    assert found == pytest.approx(by_hand, rel=2e-3)
    assert first_crushed(on_three_posts(most, 0.99 * found)) is None
    assert first_crushed(on_three_posts(most, 1.01 * found)).item == 1
    assert payload(on_three_posts())[3] == pytest.approx(120.0, rel=1e-3)


def test_a_box_that_yields_passes_its_load_on_slowly():
    """The limited box bears more only as its neighbour sinks: far beyond the sum of all limits."""

    def yielding(added=0.0, most=7.0):
        return pile(
            ((0.0, 0.0, 0.0), (20.0, 5.0, 10.0), 10.0, 0.0, None),
            ((20.0, 0.0, 0.0), (20.0, 5.0, 10.0), 10.0, 0.0, most),
            ((10.0, 5.0, 0.0), (20.0, 5.0, 10.0), 10.0, 0.0, None),
            ((0.0, 5.0, 0.0), (10.0, 5.0, 10.0), 1.0 + added, 0.0, None),
        )

    found = payload(yielding())[3]
    assert first_crushed(yielding(0.99 * found)) is None
    assert first_crushed(yielding(1.01 * found)).item == 1
    assert payload(yielding(most=11.0))[3] == np.inf  # it bears 10 kg at most


@pytest.mark.parametrize("gap", [0.0, 0.02, 0.3])
def test_a_box_that_hangs_elsewhere_hides_no_load(gap):
    """No forces balance it; those that come nearest carry the column."""
    boxes = [((70.0, gap, 70.0), (10.0, 10.0, 10.0), 1.0, 0.0, None)]
    boxes += [
        ((0.0, 30.0 * k, 0.0), (40.0, 30.0, 40.0), 50.0, 0.0, None if k else 80.0) for k in range(4)
    ]
    found = first_crushed(pile(*boxes))
    assert (found.step, found.item) == (3, 1)
    assert found.bears_kg == pytest.approx(100.0, rel=1e-3)


@pytest.mark.parametrize("weight", [10.0, 1e3, 1e4, 1e5, 1e6])
def test_a_heavy_box_beside_it_hides_no_load(weight):
    """The centre of mass of the upper one lies above the corner of what carries it."""
    boxes = (
        ((5.0, 0.0, 10.0), (10.0, 10.0, 15.0), 33.5, 0.0, 0.05),
        ((15.0, 0.0, 10.0), (15.0, 5.0, 5.0), weight, 0.0, None),
        ((10.0, 10.0, 20.0), (10.0, 10.0, 10.0), 0.1, 0.0, None),
    )
    assert first_crushed(pile(*boxes)).bears_kg == pytest.approx(0.1)
    assert contact_forces(pile(*boxes)) is not None


def test_forces_balance_every_box_of_a_thousand_layouts():
    """Summed by hand, box by box: to 1e-6 of its weight, moments in weights times its sides."""
    worst, counted = 0.0, 0
    for name in ("lists", "real"):
        benchmark = load_benchmark(name)
        for case in benchmark.cases.itertuples():
            if counted == 1000:
                break
            if case.scenario != "S1" or case.item_count > 62:
                continue
            layout = benchmark.layout(case.layout, case.scenario)
            found = contact_forces(layout)
            if found is not None:
                counted += 1
                worst = max(worst, unbalanced(layout, found))
                assert found.forces.min() >= 0.0
    assert counted == 1000
    assert worst <= 1e-6


def unbalanced(layout, found):
    """What is left of weights, and of moments about centres of mass, in weights and sides."""
    left = np.zeros((len(layout), 3))
    left[:, 0] = -layout.weights
    centres = 0.5 * (layout.lower + layout.upper) + layout.mass_offsets
    for below, above, (x, _, z), force in zip(
        found.below, found.above, found.positions, found.forces, strict=True
    ):
        for box, sign in ((above, 1.0), (below, -1.0)):
            if box >= 0:
                arm = np.array((1.0, x - centres[box, 0], z - centres[box, 2]))
                left[box] += sign * force * arm
    left[:, 1:] /= layout.sizes[:, ::2]
    return float(np.abs(left / layout.weights[:, None]).max())


def test_a_box_may_be_crushed_by_its_own_placement():
    items = (
        Item(0, (0, 0, 0), (10, 10, 10), 1.0),
        Item(1, (40, 0, 0), (10, 10, 10), 1.0),
        Item(2, (0, 10, 0), (50, 10, 10), 40.0),
        Item(3, (20, 0, 0), (10, 10, 10), 1.0, max_load=0.0),
    )
    found = first_crushed(Layout("post", Pallet(120, 200, 100), items))
    assert found is not None
    assert found.step == 3
