"""Compare the searches in C with those of numba, bit for bit, on random and on shipped layouts.

``python tests/core/compare_searching.py [PART ...] [--share S] [--seed N]``; a part is one of
``PARTS``, none means all. Prints for each how many layouts and numbers were compared, and how many
differ; the exit status is 1 where one does.
"""

from __future__ import annotations

import argparse
import sys
import time

import numpy as np

from steadyload.core import forces, loading, session, whole
from steadyload.core.constants import BALANCED
from steadyload.layouts.benchmark.dataset import SETS, load_benchmark
from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.statics import kernels
from steadyload.statics.bearing import growing
from steadyload.statics.bearing.forces import Rectangles
from steadyload.statics.kernels import growing as grown
from steadyload.statics.kernels import least_energy, placing
from steadyload.statics.kernels import loading as loads
from steadyload.statics.kernels.constants import FULL, STANDS

WIDTH, DEPTH, HEIGHT = 120.0, 80.0, 200.0
PLANE = np.array([-np.inf, -np.inf, np.inf, np.inf, 0.0])
DECK = np.array([0.0, 0.0, WIDTH, DEPTH, 14.4])


class Tally:
    """How much was compared, and what differs."""

    def __init__(self):
        self.layouts = self.numbers = self.differ = 0
        self.shown = []

    def same(self, what, one, other):
        """Compare numbers of numba and of C."""
        a, b = np.ascontiguousarray(one), np.ascontiguousarray(other)
        if a.dtype != b.dtype:  # whole numbers of two sizes
            assert a.dtype.kind in "iub", (what, a.dtype)
            assert b.dtype.kind in "iub", (what, b.dtype)
            a, b = a.astype(np.int64), b.astype(np.int64)
        self.numbers += a.size
        if a.shape != b.shape or a.tobytes() != b.tobytes():
            self.differ += 1
            if len(self.shown) < 5:
                self.shown.append((what, a, b))
            return False
        return True


# --- layouts ------------------------------------------------------------------------------------


def stack(rng, most):
    """Random drops onto a deck: grids of few lengths, so that edges, tops and centres tie."""
    grid = float(rng.choice([0.1, 1.0, 5.0, 10.0]))
    jitter = float(rng.choice([0.0, 0.0, 1e-9, 0.0101, 0.00999, 0.02]))
    over = float(rng.choice([0.0, 0.0, 10.0]))
    low, high, count = np.empty((most, 3)), np.empty((most, 3)), 0
    for _ in range(int(rng.integers(2, most + 1))):
        size = np.maximum(np.round(rng.uniform(8, 60, 3) / grid) * grid, grid)
        span = np.array([WIDTH + over - size[0], 1.0, DEPTH + over - size[2]])
        place = np.round(rng.uniform((-over, 0.0, -over), span) / grid) * grid
        if count and rng.random() < 0.5:  # flush with another
            axis = int(rng.choice([0, 2]))
            place[axis] = (low if rng.random() < 0.5 else high)[rng.integers(count), axis]
        end = place + size
        shared = np.minimum(high[:count], end) - np.maximum(low[:count], place)
        under = np.minimum(shared[:, 0], shared[:, 2]) > 0.0100001
        place[1] = high[:count, 1][under].max() if under.any() else 0.0
        if rng.random() < 0.2:
            place[1] = max(place[1] + float(rng.choice([-1.0, 1.0])) * jitter, 0.0)
        if place[1] + size[1] > HEIGHT:
            continue
        low[count], high[count] = place, place + size
        count += 1
    low, high = low[:count], high[:count]
    if rng.random() < 0.15:  # odd orders: some are pushed below others
        order = rng.permutation(count)
        low, high = low[order], high[order]
    weights = (
        np.round(rng.uniform(1, 30, count))
        if rng.random() < 0.5
        else (10 ** rng.uniform(-2, 3, count))
    )
    offsets = np.zeros((count, 3))
    if rng.random() < 0.5:
        offsets = rng.uniform(-0.3, 0.3, (count, 3)) * (high - low)
    if rng.random() < 0.2:
        offsets = np.round(offsets)
    return low.copy(), high.copy(), weights, offsets, DECK if rng.random() < 0.5 else PLANE


def random_ones(count, seed, most):
    """So many random layouts."""
    rng = np.random.default_rng(seed)
    for k in range(count):  # some are so large that arrays get more room
        yield stack(rng, 9 * most if k % 100 == 99 else most)


def shipped(count, most=1000):
    """About so many layouts of every labelled set that is shipped, as arrays."""
    for word in (None, *SETS):
        bench = load_benchmark() if word is None else load_benchmark(word)
        step = max(len(bench.cases) // count, 1)
        batch = bench.batch(bench.cases.iloc[::step])
        for k in range(len(batch.starts) - 1):
            part = slice(batch.starts[k], batch.starts[k + 1])
            if part.stop - part.start <= most:
                yield (
                    batch.lower[part].copy(), batch.upper[part].copy(), batch.weights[part].copy(),
                    batch.mass_offsets[part].copy(), batch.floors[k].copy(),
                )  # fmt: skip


def both(share, seed, random, of_each, most=14):
    """Random layouts, then shipped ones."""
    yield from random_ones(int(random * share), seed, most)
    yield from shipped(max(int(of_each * share), 1))


def fixed(array):
    """A copy as a layout has it."""
    made = np.array(array, dtype=float)
    made.setflags(write=False)
    return made


def limits_of(lower, upper, floor):
    """A contour about a layout, and its deck."""
    deck = floor if np.isfinite(floor).all() else np.array([0.0, 0.0, WIDTH, DEPTH, 0.0])
    low = np.minimum(lower.min(axis=0), 0.0) - 5.0
    high = np.maximum(upper.max(axis=0), (deck[2], 20.0, deck[3])) + 5.0
    low[1] = 0.0
    return np.concatenate((low, high, deck))


# --- parts --------------------------------------------------------------------------------------


def margins(tally, share, seed):
    """Margins of whole loads."""
    rng = np.random.default_rng(seed + 1)
    for arrays in both(share, seed, 8000, 60, 20):
        tally.layouts += 1
        given = [fixed(array) for array in arrays]
        most = float(rng.choice([10.0, 10.0, 1.0, 0.005, 60.0]))
        ended, margin, step, item = kernels.margin.margin_as_planned(*given, most)
        found = whole.margin(most, *given)
        tally.same("how", [ended, step, item], [found.ended, found.step, found.item])
        tally.same("margin", [float(margin)], [found.number])


def contacts(tally, share, seed):
    """Who stands on whom."""
    for lower, upper, *_, floor in both(share, seed + 60, 1500, 40, 20):
        tally.layouts += 1
        given = fixed(lower), fixed(upper), fixed(floor)
        want, found = kernels.contacts.contacts_of(*given), whole.contacts(*given)
        for name in found._fields:
            tally.same(name, getattr(want, name), getattr(found, name))


class Growing:
    """A growing layout of numba, as the model of one calls it."""

    def __init__(self, limits):
        low, high, deck = limits[:3].tolist(), limits[3:6].tolist(), limits[6:].tolist()
        self.arrays = grown.first_arrays(low, high, deck)
        self.kept = tuple(self.arrays)

    def grow(self):
        self.arrays = grown.with_more_room(self.arrays)
        self.kept = tuple(self.arrays)

    def call(self, function, box, *how):
        while True:
            self.arrays.limits[grown.BOX :] = box
            found = function(self.kept, *how)
            if found[0] != FULL:
                return found
            self.grow()

    def endings(self, box, positions, rule, alpha):
        found, done = np.empty(len(positions), dtype=np.int8), 0
        self.arrays.limits[grown.BOX :] = box
        while done < len(positions):
            done = placing.stand(self.kept, rule, alpha, positions, found, done)
            if done < len(positions):
                self.grow()
        return found

    def __len__(self):
        return int(self.arrays.counts[grown.ITEMS])


def same_session(tally, of_numba, of_c):
    """Compare all that is kept of a growing layout."""
    arrays, count = of_numba.arrays, len(of_numba)
    tally.same("count", [count], [len(of_c)])
    tally.same("overhung", [arrays.counts[grown.OVERHUNG]], [of_c.overhung])
    boxes = of_c.boxes()
    for k in range(3):
        tally.same("vectors", arrays.vectors[k, :count], boxes[k])
    tally.same("weights", arrays.weights[:count], boxes.weights)
    for item in range(min(count, len(of_c))):
        start, end, _, above, above_end, _, _, on_floor, _ = arrays.blocks[:, item].tolist()
        found = of_c.below(item)
        tally.same("on floor", [bool(on_floor)], [of_c.is_on_floor(item)])
        tally.same("below", arrays.links[0, start:end], found.below)
        tally.same("patches", arrays.patches[start:end], found.patches)
        tally.same("presses", arrays.presses[0, start:end], found.presses)
        tally.same("above", arrays.links[1, above:above_end], of_c.above(item))


def sessions(tally, share, seed):
    """Layouts that grow and shrink."""
    rng = np.random.default_rng(seed + 2)
    for arrays in both(share, seed + 10, 5000, 40, 16):
        tally.layouts += 1
        limits = limits_of(arrays[0], arrays[1], arrays[4])
        one, other = Growing(limits), session.Session(limits.tolist())
        rule = int(rng.integers(3))
        alpha = float(rng.choice(((0.5, 0.7, 1.0), (0.0,), (0.0, 0.0, 0.005, 0.5, 2.0))[rule]))
        for low, high, weight, offset in zip(*arrays[:4], strict=True):
            box = np.concatenate((low, high - low, offset, [weight]))
            if len(one) and rng.random() < 0.1:
                box[:3] = one.arrays.vectors[int(rng.integers(2)), int(rng.integers(len(one)))]
            if rng.random() < 0.2:
                shift = np.zeros((int(rng.integers(1, 5)), 3))
                shift[:, ::2] = np.round(rng.uniform(-20, 20, (len(shift), 2)))
                want = one.endings(box, box[:3] + shift, rule, alpha)
                tally.same(
                    "endings", want, other.endings(box.tolist(), box[:3] + shift, rule, alpha)
                )
            if rng.random() < 0.1:
                want = one.call(grown.put, box)
                tally.same("put", [int(want[0])], [other.put(box.tolist())])
            else:
                ended, item, number = one.call(placing.place, box, rule, alpha)
                found = other.place(box.tolist(), rule, alpha)
                tally.same("place", [int(ended)], [found.ended])
                if ended != STANDS and ended < 3:
                    tally.same("item", [int(item)], [found.item])
                tally.same("number", [float(number)], [found.number])
            if len(one) and rng.random() < 0.08:
                count = int(rng.integers(len(one) + 1))
                grown.take_off(one.kept, count)
                other.cut(count)
            if len(one) and rng.random() < 0.05:  # a copy goes on, the first one does not matter
                before, other = other, other.copy()
                before.cut(0)
        same_session(tally, one, other)
        if len(one):
            item, wider = int(rng.integers(len(one))), float(rng.choice([0.0, 0.02, 10.0]))
            low, high, _ = one.arrays.vectors
            near = kernels.cells.items_near(
                low, high, one.arrays.cells, len(one), one.arrays.limits, low[item], high[item],
                wider,
            )  # fmt: skip
            tally.same("near", near, other.near(low[item].copy(), high[item].copy(), wider))


def plan_of(arrays):
    """The arrays of a plan, as the search of a repair has them."""
    lower, upper, weights, offsets, _ = arrays
    sizes = upper - lower
    turned = offsets[:, ::-1] * (1.0, 1.0, -1.0)
    return loads.Boxes(
        np.stack([sizes, sizes[:, ::-1]]), np.stack([offsets, turned]) + 0.0, weights,
        np.column_stack([lower, np.zeros(len(lower))]), sizes.prod(axis=1),
    )  # fmt: skip


class Order:
    """Loading by numba, as the search of a repair calls it."""

    def __init__(self, boxes, limits, reorder, looks):
        self.boxes, self.grown = tuple(boxes), Growing(limits)
        self.turns, self.how = tuple(loads.no_turns(len(boxes.weights))), (reorder, looks)

    def begin(self, places, margins, refused, first):
        loads.begin(self.grown.kept, self.boxes, self.turns, places, margins, refused, first)

    def load(self, places, margins, refused, stays):
        while True:
            ended = loads.load(
                self.grown.kept, self.boxes, self.turns, places, margins, refused, *self.how
            )
            if ended == loads.ALL:
                break
            if ended == loads.FULL:
                grown.take_off(self.grown.kept, 0)
                self.turns = tuple(loads.no_turns(len(places)))
                self.grown.grow()
                continue
            turns, place = loads.Turns(*self.turns), len(self.grown) - 1
            box = turns.looked_at
            keeps = stays(turns.order[:place].tolist(), box)
            if not keeps:
                grown.take_off(self.grown.kept, place)
            loads.said(self.turns, place, box, keeps, self.how[0])
        turns = loads.Turns(*self.turns)
        return turns.order[: len(self.grown)].tolist(), list(turns.stuck)

    def first_standing(self, box, places, margin, refused, most):
        found = np.empty(most, dtype=np.int64)
        while True:
            count = loads.first_standing(
                self.grown.kept, self.boxes, box, places, margin, refused, found
            )
            if count >= 0:
                return found[:count]
            self.grown.grow()


def stays(order, box):
    """Some answer to whether a box stays on others, the same whoever asks."""
    return hash((tuple(order), box)) % 6 != 0


def free_of(rng, tally, boxes, of_c, places, box, limits):
    """Free places of a box by both, which are compared."""
    without = rng.random(len(places)) < float(rng.choice([0.0, 0.1]))
    margin = float(rng.choice([0.0, 0.05, 0.5, 3.0]))
    ways = [(np.inf, -np.inf, np.inf), (30.0, -np.inf, 0.01), (5.0, -0.01, 0.01)]
    ways = np.array(ways[int(rng.choice([0, 0, 1, 2]))])
    turns, most = int(rng.integers(1, 3)), int(rng.choice([4000, 4000, 60]))
    given = places, without, box, margin, limits[:10].copy(), ways, turns, most
    found, far = loads.places_among(tuple(boxes), *given)
    same, as_far = of_c.places_among(*given)
    tally.same("places", found, same)
    tally.same("far", far, as_far)
    return found


def searches(tally, share, seed):
    """Plans that are loaded, changed, and loaded again."""
    rng = np.random.default_rng(seed + 3)
    for arrays in both(share, seed + 20, 5000, 20, 12):
        tally.layouts += 1
        boxes, count = plan_of(arrays), len(arrays[2])
        limits = limits_of(arrays[0], arrays[1], arrays[4])
        of_c, reorder = loading.Boxes(*boxes), bool(rng.random() < 0.7)
        looks = bool(rng.random() < 0.2)
        one, other = Order(boxes, limits, reorder, looks), loading.Loading(limits.tolist(), of_c)
        places, refused = boxes.planned, np.empty((0, 5))
        margin = np.full(count, float(rng.choice([0.0, 0.05, 0.5])))
        for _ in range(int(rng.integers(2, 6))):
            first = count if rng.random() < 0.7 else int(rng.integers(count))
            one.begin(places, margin, refused, first)
            other.begin(places, margin, refused, first)
            order, stuck = one.load(places, margin, refused, stays)
            while not other.load(reorder=reorder, looks=looks):
                now, box = other.loaded().order, other.looked_at
                other.say(stays(now, box), reorder=reorder)
            found = other.loaded()
            tally.same("order", np.array(order, dtype=int), np.array(found.order, dtype=int))
            tally.same("stuck", np.array(stuck, dtype=int), np.array(found.stuck, dtype=int))
            tally.same("tried", one.turns[0], other.tried())
            same_session(tally, one.grown, other.session)
            tally.same("cost", np.array(loads.cost(tuple(boxes), places), float),
                       np.array(of_c.cost(places), float))  # fmt: skip
            box = stuck[0] if stuck else int(rng.integers(count))
            free = free_of(rng, tally, boxes, of_c, places, box, limits)
            if box not in order:
                own, most = float(rng.choice([0.05, 0.5])), int(rng.integers(1, 5))
                want = one.first_standing(box, free[:300], own, refused, most)
                found = other.first_standing(box, free[:300].copy(), own, most)
                tally.same("standing", want, found)
            places, margin = places.copy(), margin.copy()
            if len(free):
                places[box] = free[min(int(rng.geometric(0.2)) - 1, len(free) - 1)]
            chance = rng.random()
            if chance < 0.2:
                places[int(rng.integers(count))] = (0.0, 0.0, 0.0, loads.LEFT_OUT)
            elif chance < 0.4:
                refused = np.vstack([refused, [float(box), *places[box]]])
            elif chance < 0.5:
                margin[int(rng.integers(count))] = 1.0
            elif chance < 0.6:
                back = int(rng.integers(count))
                places[back] = boxes.planned[back]


def places(tally, share, seed):
    """Free places of one side of a box."""
    rng = np.random.default_rng(seed + 4)
    for lower, upper, weights, offsets, floor in both(share, seed + 30, 1500, 20, 16):
        tally.layouts += 1
        limits = limits_of(lower, upper, floor)[:10].copy()
        size = np.round(rng.uniform(5, 50, 3))
        middle = 0.5 * size + rng.uniform(-0.2, 0.2, 3) * size * (weights[0] > 10.0)
        start, ways = np.round(rng.uniform(0, 40, 3)), np.array([np.inf, -np.inf, np.inf])
        levels = np.unique(np.concatenate(([0.0], upper[:, 1])))
        given = (
            lower, upper, 0.5 * (lower + upper) + offsets, size, middle, start,
            float(rng.choice([0.0, 0.5])), limits, levels, ways, int(rng.choice([5, 2000])),
        )  # fmt: skip
        tally.same("free", kernels.free_places.free_places(*given), loading.free_places(*given))


def layout_of(arrays):
    """A layout as the model has it."""
    lower, upper, weights, offsets, _ = arrays
    shift = np.array([-min(lower[:, 0].min(), 0.0), 0.0, -min(lower[:, 2].min(), 0.0)])
    lower, upper = lower + shift, upper + shift
    pallet = Pallet(*(float(x) for x in np.maximum(upper.max(axis=0), 1.0)))
    items = [
        Item(k, tuple(lower[k].tolist()), tuple((upper[k] - lower[k]).tolist()),
             float(weights[k]), tuple(offsets[k].tolist()))
        for k in range(len(lower))
    ]  # fmt: skip
    return Layout("random", pallet, tuple(items))


def standing(arrays):
    """Of the boxes of a layout those that stand on the ones before them."""
    lower, upper, weights, offsets, floor = arrays
    held = session.Session(limits_of(lower, upper, floor).tolist())
    kept = [
        k
        for k in range(len(lower))
        if held.place(
            [*lower[k], *(upper[k] - lower[k]), *offsets[k], weights[k]], BALANCED, 0.0
        ).ended
        == STANDS
    ]
    return lower[kept], upper[kept], weights[kept], offsets[kept], floor


def energy(tally, share, seed):
    """Forces of least energy, as a load grows."""
    rng, given = np.random.default_rng(seed + 5), []
    growing.Energy = lambda *equations: given.extend(equations) or forces.Energy(*equations)
    for arrays in both(share, seed + 40, 2400, 15, 16):
        try:
            layout = layout_of(arrays if rng.random() < 0.2 else standing(arrays))
        except ValueError:  # it overlaps by rounding
            continue
        tally.layouts += 1
        contacts = Rectangles.of(layout)
        presses = rng.random((len(contacts.pairs), 4)) < 0.7
        given.clear()
        statics = growing.GrowingStatics(layout, contacts, presses)
        starts, rows, diagonal, column_starts, column_rows, values, right, pressed = map(
            np.copy, given
        )
        factors = least_energy.Factors(
            starts.astype(np.int64), rows.astype(np.int64), np.zeros(len(rows)), diagonal
        )
        columns = least_energy.Columns(
            column_starts.astype(np.int64), column_rows.astype(np.int64), values
        )
        held, multipliers = np.zeros(len(pressed), dtype=np.bool_), np.zeros(len(right))
        below, above = statics._pairs.T
        for count in sorted(set(rng.integers(1, len(layout) + 1, 4).tolist()) | {len(layout)}):
            there = np.zeros(len(layout) + 1, dtype=bool)
            there[:count] = there[-1] = True
            at = np.flatnonzero(there[below] & there[above])
            corners = (4 * at[:, None] + np.arange(4)).ravel()
            group = np.sort(statics._place[:count])
            equations = (3 * group[:, None] + np.arange(3)).ravel()
            pulls = np.empty(len(corners))
            ended = least_energy.solved(
                factors, columns, corners, equations, right, pressed, held, multipliers, pulls,
            )  # fmt: skip
            found = statics._energy.pulls(corners.astype(np.int32), equations.astype(np.int32))
            tally.same("ended", [bool(ended)], [found is not None])
            if found is None or not ended:
                break
            tally.same("pulls", pulls, found)


def squares(tally, share, seed):
    """Least squares of few columns."""
    rng = np.random.default_rng(seed + 6)
    for _ in range(int(1000 * share)):
        tally.layouts += 1
        columns = rng.normal(size=(int(rng.integers(1, 12)), int(rng.integers(1, 9))))
        if rng.random() < 0.5:
            columns = np.round(columns)
        target = np.round(rng.normal(size=columns.shape[1]), 1)
        x, rest, ended = kernels.least_squares.nonnegative_least_squares(columns, target)
        found = forces.least_squares(columns, target)
        tally.same("x", x, found[0])
        tally.same("rest", rest, found[1])
        tally.same("ended", [bool(ended)], [found[2]])


def nonsense(tally, share, seed):
    """Numbers that mean nothing: all ends, and a build with sanitizers finds no fault."""
    rng = np.random.default_rng(seed + 7)
    odd = np.array([np.nan, np.inf, -np.inf, -1.0, 0.0, -0.0, 5e-324, 1e300, -1e300, 1e9, 0.5])

    def spoilt(array):
        made = np.array(array, dtype=float)
        many = rng.random(made.shape) < float(rng.choice([0.02, 0.2, 1.0]))
        made[many] = rng.choice(odd, int(many.sum()))
        return made if rng.random() < 0.7 else np.array(array, dtype=float)

    np.seterr(all="ignore")
    for arrays in random_ones(int(1500 * share), seed + 50, 10):
        tally.layouts += 1
        lower, upper, weights, offsets, floor = map(spoilt, arrays)
        whole.contacts(lower, upper, floor)
        limits, count = spoilt(limits_of(*arrays[:2], arrays[4])), len(weights)
        whole.margin(float(rng.choice([0.0, 10.0, 1e6])), lower, upper, weights, offsets, floor)
        held = session.Session(limits.tolist())
        for low, high, weight, offset in zip(lower, upper, weights, offsets, strict=True):
            box = [*low, *(high - low), *offset, weight]
            held.place(box, int(rng.integers(3)), float(rng.choice([*odd, 0.5])))
            held.put(box)
            held.near(low.copy(), high.copy(), float(rng.choice(odd)))
        held.copy().cut(int(rng.integers(-2, 4)))
        boxes = loading.Boxes(*map(spoilt, plan_of((lower, upper, weights, offsets, floor))))
        order, refused = loading.Loading(limits.tolist(), boxes), spoilt(rng.random((3, 5)))
        for _ in range(3):
            places, margin = spoilt(plan_of(arrays).planned), spoilt(np.zeros(count))
            order.begin(places, margin, refused, int(rng.integers(count + 2)))
            while not order.load(reorder=True, looks=True):
                order.say(rng.random() < 0.8, reorder=True)
            box, ways, turns = int(rng.integers(count)), spoilt([np.inf, -np.inf, np.inf]), 2
            found, _ = boxes.places_among(
                places, rng.random(count) < 0.1, box, float(rng.choice(odd)), limits[:10].copy(),
                ways, turns, 200,
            )  # fmt: skip
            order.first_standing(box, spoilt(found), 0.5, 3)
            boxes.cost(places)
        columns = spoilt(rng.normal(size=(5, 4)))
        forces.least_squares(columns, spoilt(np.ones(4)))
        starts = np.array([0, 2, 3, 3], np.int32), np.arange(0, 13, 3).astype(np.int32)
        held = forces.Energy(
            starts[0], np.array([1, 2, 2], np.int32), spoilt(np.full(3, 1e-12)), starts[1],
            np.tile(np.arange(3, dtype=np.int32), 4), spoilt(rng.normal(size=12)),
            spoilt([1.0, 0.0, 0.0]), rng.random(4) < 0.5,
        )  # fmt: skip
        held.pulls(np.arange(4, dtype=np.int32), np.arange(3, dtype=np.int32))


PARTS = {
    part.__name__: part
    for part in (contacts, margins, sessions, searches, places, energy, squares, nonsense)
}


def main():
    """Compare, and say how it went."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", choices=[*PARTS, []], default=[])
    parser.add_argument("--share", type=float, default=1.0)
    parser.add_argument("--seed", type=int, default=1)
    given, differ = parser.parse_args(), 0
    for name in given.parts or PARTS:
        tally, began = Tally(), time.process_time()
        PARTS[name](tally, given.share, given.seed)
        print(
            f"{name}: {tally.layouts} layouts, {tally.numbers} numbers compared, "
            f"{tally.differ} differences, {time.process_time() - began:.0f} s",
            flush=True,
        )
        for what in tally.shown:
            print("  ", *what)
        differ += tally.differ
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
