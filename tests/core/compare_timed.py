"""Compare loadings that are followed, in C, with the same in numba: numbers of every step.

    PYTHONPATH=.src python tests/core/compare_timed.py [--random 20000] [--shipped 100]

Without ``--library`` the files of ``harness/core`` that it takes are built into a temporary folder.
Every number is compared to the bit, but for the sign of zeros, which is counted; where one differs,
by how many units in the last place is said.
"""

from __future__ import annotations

import argparse
import collections
import ctypes as ct
import importlib.util
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import ClassVar

import numpy as np

from steadyload.engines.world import GRAVITY
from steadyload.layouts.benchmark.dataset import SETS, load_benchmark
from steadyload.methods import make_method
from steadyload.statics import kernels

CORE = Path(__file__).parents[2] / "harness" / "core"
FILES = (
    "memory", "contacts", "support", "sme", "balance", "group", "least_squares", "touching",
    "group_forces", "carrying", "pendulums", "motion", "timed", "timed_api",
)  # fmt: skip
INT, REAL, AT = ct.c_int32, ct.c_double, ct.c_void_p
G = 100.0 * GRAVITY


class How(ct.Structure):
    _fields_ = [(n, REAL) for n in ("friction", "gravity", "seconds", "eps_t", "eps_r")]


class Moved(ct.Structure):
    _fields_ = [
        *((n, INT) for n in ("ended", "step", "item", "unused")),
        *((n, REAL) for n in ("shift", "turn", "beyond")),
    ]


MOVED = np.dtype(Moved)


class Finding(ct.Structure):
    _fields_ = [*((n, INT) for n in ("ended", "step", "item", "unused")), ("number", REAL)]


_POINTERS = (
    "on_floor", "starts", "ends", "below", "corners", "above_starts", "above_ends", "above",
    "meets", "presses", "pressing", "pushes", "moves", "answers", "solved", "leans", "farthest",
    "beyond", "counts", "work",
)  # fmt: skip


class View(ct.Structure):
    _fields_ = [("count", INT), ("patches", INT), *((n, AT) for n in _POINTERS)]


def build(folder):
    """The library, by the flags of the project."""
    spec = importlib.util.spec_from_file_location("building", CORE / "building.py")
    building = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(building)
    made = Path(folder) / "timed.so"
    sources = [str(CORE / f"{name}.c") for name in FILES]
    how = [*building.compiler(), *building.FLAGS, "-shared", "-fPIC"]
    subprocess.run([*how, *sources, "-o", str(made), "-lm"], check=True)
    return made


def load(path):
    """The library, with the types of its functions."""
    library = ct.CDLL(str(path))
    layout = [INT, AT, AT, AT, AT, AT]
    for name, result, takes in (
        ("sl_work_new", AT, []), ("sl_work_free", None, [AT]),
        ("sl_timed_new", AT, [*layout, REAL]), ("sl_timed_free", None, [AT]),
        ("sl_timed_look", None, [AT, AT]), ("sl_timed_place", INT, [AT, INT, AT, AT]),
        ("sl_timed_first", INT, [AT, INT, INT, AT, AT]),
        ("sl_timed_group", INT, [AT, INT, AT, AT, AT]),
        ("sl_timed_moved", INT, [AT, INT, INT, AT, AT, AT]),
        ("sl_timed_is_near_its_edge", INT, [AT, INT, REAL]),
        ("sl_first_moved", INT, [AT, *layout, REAL, AT, AT]),
        ("sl_first_moved_many", INT, [AT, INT, AT, AT, AT, AT, AT, AT, REAL, AT, AT]),
        ("sl_held_new", AT, [*layout, REAL]), ("sl_held_free", None, [AT]),
        ("sl_held_place", INT, [AT, INT, AT]), ("sl_held_presses", AT, [AT, AT]),
        ("sl_held_group", INT, [AT, INT, AT]),
        ("sl_closest_to_balance", INT,
         [AT, INT, AT, AT, AT, AT, INT, AT, INT, AT, INT, AT, REAL, AT, AT]),
        ("sl_nonnegative_least_squares", INT, [AT, INT, INT, AT, AT, AT, AT]),
        ("sl_thin_side", REAL, [REAL, REAL]),
    ):  # fmt: skip
        function = getattr(library, name)
        function.restype, function.argtypes = result, takes
    return library


def at(array):
    return array.ctypes.data


class Tally:
    """Numbers compared, and those that differ."""

    def __init__(self):
        self.compared = collections.Counter()
        self.differ = collections.Counter()
        self.farthest = collections.Counter()
        self.zeros = collections.Counter()
        self.seen = collections.Counter()
        self.shown = 0

    def take(self, name, ours, numba, where=""):
        ours, numba = np.asarray(ours), np.asarray(numba)
        self.compared[name] += numba.size
        if ours.shape != numba.shape:
            self.differ[name] += max(numba.size, 1)
            self.say(name, f"shapes {ours.shape} {numba.shape}", where)
            return
        equal = (ours == numba) | ((ours != ours) & (numba != numba))
        if numba.dtype.kind == "f":
            signs = np.signbit(ours) != np.signbit(numba)
            self.zeros[name] += np.count_nonzero(signs & (ours == 0.0) & (numba == 0.0))
        if equal.all():
            return
        off = np.count_nonzero(~equal)
        self.differ[name] += off
        if numba.dtype.kind == "f":
            a = np.ascontiguousarray(ours[~equal]).view(np.int64)
            b = np.ascontiguousarray(numba[~equal]).view(np.int64)
            self.farthest[name] = max(self.farthest[name], int(np.abs(a - b).max()))
        self.say(name, f"{ours[~equal][:3]} {numba[~equal][:3]}", where)

    def say(self, name, what, where):
        self.shown += 1
        if self.shown <= 20:
            print("  differ:", name, where, what, flush=True)

    def tell(self):
        for name, count in self.compared.items():
            units = f", by up to {self.farthest[name]} units" if self.differ[name] else ""
            print(f"  {name:24s} {count:10d} numbers, {self.differ[name]} differ{units}")
        print("  zeros of another sign:", dict(self.zeros))
        print("  seen:", dict(sorted(self.seen.items(), key=str)))
        return sum(self.differ.values())


class Timed:
    """A loading in C."""

    types: ClassVar = {
        "on_floor": ("u1", ()), "starts": ("i4", ()), "ends": ("i4", ()), "moves": ("u1", ()),
        "answers": ("i4", ()), "solved": ("u1", ()), "leans": ("u1", ()), "beyond": ("f8", ()),
        "above_starts": ("i4", ()), "above_ends": ("i4", ()), "farthest": ("f8", (3, 2)),
        "presses": ("f8", (3,)), "pressing": ("u1", (4,)), "corners": ("f8", (4,)),
        "below": ("i4", ()),
    }  # fmt: skip

    def __init__(self, library, arrays, margin=0.0):
        self.library, count = library, len(arrays[2])
        self.handle = library.sl_timed_new(count, *map(at, arrays), margin)
        assert self.handle
        view = View()
        library.sl_timed_look(self.handle, ct.byref(view))
        assert view.count == count
        for name, (kind, shape) in self.types.items():
            by_patch = name in ("presses", "pressing", "corners", "below")
            rows = view.patches if by_patch else count
            setattr(self, name, self._array(getattr(view, name), kind, (rows, *shape)))
        carried = int((self.below >= 0).sum())
        self.above = self._array(view.above, "i4", (carried,))
        self.meets = self._array(view.meets, "i4", (carried,))
        self.pushes = self._array(view.pushes, "u2", (count + 1, count + 1))
        self.counts = self._array(view.counts, "i8", (2,))
        self.work = self._array(view.work, "f8", (2,))
        self.group = np.empty(max(count, 1), dtype=np.int32)

    @staticmethod
    def _array(address, kind, shape):
        size = int(np.prod(shape)) * np.dtype(kind).itemsize
        if not size:
            return np.zeros(shape, kind)
        return np.frombuffer((ct.c_char * size).from_address(address), kind).reshape(shape)

    def place(self, step, how):
        found = Moved()
        ended = self.library.sl_timed_place(self.handle, step, ct.byref(how), ct.byref(found))
        assert ended == found.ended
        return found

    def moving_group(self, step):
        kept, size = INT(), INT()
        ended = self.library.sl_timed_group(
            self.handle, step, ct.byref(kept), ct.byref(size), at(self.group)
        )
        return ended, kept.value, self.group[: size.value].copy()

    def moved(self, step, group, how):
        found, who = Moved(), np.array(group, dtype=np.int32)
        self.library.sl_timed_moved(
            self.handle, step, len(who), at(who), ct.byref(how), ct.byref(found)
        )
        return found

    def free(self):
        self.library.sl_timed_free(self.handle)


UNDECIDED = {7: 6}  # ours: numba's


def compare_state(tally, ours, numba, where):
    for name, other in (
        ("presses", numba.presses), ("pressing", numba.corners), ("pushes", numba.pushes),
        ("moves", numba.moves), ("answers", numba.answers), ("solved", numba.solved),
        ("leans", numba.leans), ("farthest", numba.most), ("beyond", numba.beyond),
        ("counts", numba.counts), ("work", numba.work),
    ):  # fmt: skip
        tally.take(name, getattr(ours, name), other, where)


def compare_begun(tally, ours, numba, where):
    c = numba.contacts
    tally.take("contacts", ours.corners, c.patches, where)
    for name in ("on_floor", "ends", "below", "above", "above_ends"):
        tally.take("contacts", getattr(ours, name), getattr(c, name)[: len(getattr(ours, name))],
                   where)  # fmt: skip
    tally.take("contacts", ours.meets, numba.meets, where)


def loading_by_steps(library, tally, arrays, how, where, limit=np.inf):
    """Every step of a layout, whatever came of those before."""
    ours, numba = Timed(library, arrays), kernels.timed_balance.begin(*arrays)
    ours.work[1] = numba.work[1] = limit
    compare_begun(tally, ours, numba, where)
    given = tuple(getattr(how, n) for n, _ in How._fields_)
    for step in range(len(arrays[2])):
        found = ours.place(step, how)
        ended, item, shift, turn, beyond = kernels.timed_balance.place(step, numba, *given)
        at_step = f"{where} step {step}"
        tally.take("ended and item", (UNDECIDED.get(found.ended, found.ended), found.item),
                   (ended, item), at_step)  # fmt: skip
        tally.take("shift, turn, beyond", (found.shift, found.turn, found.beyond),
                   (shift, turn, beyond), at_step)  # fmt: skip
        compare_state(tally, ours, numba, at_step)
        tally.seen["step", int(ended), "far" if beyond > 1.0 else ""] += 1
    tally.seen["motions kept"] += int(numba.counts[0])
    tally.seen["motions asked for"] += int(numba.counts[1])
    tally.seen["leaning"] += int(numba.leans.sum())
    ours.free()


def loading_at_once(library, tally, arrays, how, draw, where):
    """Several steps a call, until something comes too far."""
    ours, numba = Timed(library, arrays), kernels.timed_balance.begin(*arrays)
    given = tuple(getattr(how, n) for n, _ in How._fields_)
    first, found = 0, Moved()
    while first < len(arrays[2]):
        end = int(draw.integers(first, len(arrays[2]) + 1))
        library.sl_timed_first(ours.handle, first, end, ct.byref(how), ct.byref(found))
        ended, step, item, shift, turn = kernels.timed_balance.first_moved(
            numba, first, end, *given
        )
        tally.take("at once", (found.ended, found.step, found.item), (ended, step, item), where)
        tally.take("at once", (found.shift, found.turn), (shift, turn), where)
        compare_state(tally, ours, numba, where)
        if ended != 0:
            break
        first = end
    ours.free()


def among_moving(library, tally, arrays, margin, how, draw, where):
    """As simulations among what moves use it: patches drawn in, answers from elsewhere."""
    ours, numba = Timed(library, arrays, margin), kernels.timed_balance.begin(*arrays)
    kernels.contacts.draw_in(numba.contacts.patches, margin)
    compare_begun(tally, ours, numba, where)
    given = tuple(getattr(how, n) for n, _ in How._fields_)
    for step in range(len(arrays[2])):
        at_step = f"{where} margin {margin} step {step}"
        ended, kept, group = kernels.timed_balance.moving_group(step, numba)
        found = ours.moving_group(step)
        tally.take("moving group", found[2], group, at_step)
        tally.take("moving group", found[:2], (ended, kept), at_step)
        near = kernels.balance.is_near_its_edge(
            step, numba.contacts, *arrays[:2], arrays[3], margin
        )
        own = library.sl_timed_is_near_its_edge(ours.handle, step, margin)
        tally.take("near its edge", own, near, at_step)
        tally.seen["group", int(ended), bool(kept)] += 1
        if ended == 1 and not kept:
            if draw.random() < 0.5:
                found = ours.moved(step, group, how)
                other = kernels.timed_balance.moved(step, group, numba, *given)
                tally.take("moved", (found.ended, found.item), other[:2], at_step)
                tally.take("moved", (found.shift, found.turn, found.beyond), other[2:], at_step)
            else:
                who = np.flatnonzero(draw.random(step + 1) < 0.5)
                far = draw.uniform(0.0, 5.0, (len(who), 3, 2))
                for one, most in ((ours, ours.farthest), (numba, numba.most)):
                    one.answers[who] = step + 1
                    one.solved[who], most[who] = True, far
        compare_state(tally, ours, numba, at_step)
    ours.free()


def whole_groups(library, tally, arrays, margin, where):
    count = len(arrays[2])
    handle = library.sl_held_new(count, *map(at, arrays), margin)
    held = kernels.balance.begin(*arrays, margin)
    patches, item = INT(), INT()
    address = library.sl_held_presses(handle, ct.byref(patches))
    presses = Timed._array(address, "f8", (patches.value, 3))
    group = np.empty(count, dtype=np.int32)
    for step in range(count):
        at_step = f"{where} margin {margin} step {step}"
        ended, other = kernels.balance.balance_whole_group(step, held)
        found = library.sl_held_place(handle, step, ct.byref(item))
        tally.take("whole: ended and item", (found, item.value), (ended, other), at_step)
        tally.take("whole: presses", presses, held.presses, at_step)
        size = library.sl_held_group(handle, step, at(group))
        tally.take("whole: group", group[:size], kernels.balance.joined(step, held.contacts),
                   at_step)  # fmt: skip
        tally.seen["whole", int(ended)] += 1
    library.sl_held_free(handle)


def closest(library, work, tally, arrays, draw, where):
    """Forces of the group of one step, with patches that are wider or narrower."""
    lower, upper, weights, offsets, floor = arrays
    contacts = kernels.contacts.contacts_of(lower, upper, floor)
    step = int(draw.integers(len(weights)))
    items = kernels.balance.joined(step, contacts)
    if draw.random() < 0.3:
        items = draw.permutation(items)
    used = np.array([
        (k, above, contacts.below[k])
        for above in items
        for k in range(contacts.starts[above], contacts.ends[above])
        if contacts.below[k] <= step
    ], dtype=np.int64).reshape(-1, 3)  # fmt: skip
    if not len(used):
        return
    grow = float(draw.choice([1e-5, 0.0, 0.5, 5.0, -0.02]))
    centres = 0.5 * (lower + upper) + offsets
    forces, ended, item, through = kernels.local_balance.closest_to_balance(
        items, used, contacts.patches.copy(), centres, weights, lower, upper, grow
    )
    who, which = items.astype(np.int32), used.astype(np.int32)
    ours, found = np.empty((len(used), 4)), Finding()
    corners = np.ascontiguousarray(contacts.patches)
    library.sl_closest_to_balance(
        work, len(weights), *map(at, arrays[:4]), len(who), at(who), len(which), at(which),
        len(corners), at(corners), grow, at(ours), ct.byref(found),
    )  # fmt: skip
    tally.take("closest: ended and item", (found.ended, found.item, found.number),
               (ended, item, through), where)  # fmt: skip
    tally.take("closest: forces", ours, forces, where)
    tally.seen["closest", int(ended)] += 1


def batches(library, work, tally, sets, how, limit, where):
    """Whole layouts in one call."""
    lower, upper, weights, offsets, floors, starts = sets
    given = tuple(getattr(how, n) for n, _ in How._fields_)
    began = time.process_time()
    numba = kernels.timed_balance.first_moved_of_many(
        lower, upper, weights, offsets, floors, starts, limit, *given
    )
    between = time.process_time()
    found = np.zeros(len(starts) - 1, MOVED)
    firsts = starts.astype(np.int32)
    ended = library.sl_first_moved_many(
        work, len(found), at(firsts), at(lower), at(upper), at(weights), at(offsets), at(floors),
        limit, ct.byref(how), at(found),
    )  # fmt: skip
    took = time.process_time() - between
    assert ended == 0
    ours = np.where(found["ended"] == 7, 6, found["ended"])
    tally.take("many: ended", ours, numba[0], where)
    tally.take("many: step", found["step"], numba[1], where)
    tally.take("many: shift", found["shift"], numba[2], where)
    tally.take("many: turn", found["turn"], numba[3], where)
    for end in np.unique(numba[0]):
        tally.seen["many", int(end)] += int((numba[0] == end).sum())
    each = 1e6 / len(found)
    print(f"  {where}: {len(found)} layouts, us each: numba {(between - began) * each:.2f}, "
          f"C {took * each:.2f}", flush=True)  # fmt: skip


def squares_of(library, work, tally, where):
    """A search as :mod:`steadyload.statics.least_squares` has it that compares both."""

    def search(matrix, target):
        columns = np.ascontiguousarray(matrix.T)
        target = np.ascontiguousarray(target)
        found, rest, ended = kernels.least_squares.nonnegative_least_squares(columns, target)
        count, rows = columns.shape
        x, left = np.empty(count), np.empty(rows)
        own = library.sl_nonnegative_least_squares(
            work, count, rows, at(columns), at(target), at(x), at(left)
        )
        tally.take("sides: ended", own, 0 if ended else 2, where)
        tally.take("sides: forces", x, found, where)
        tally.take("sides: residual", left, rest, where)
        if not ended:
            raise RuntimeError("the search for contact forces did not end")
        return found, rest

    return search


def random_layout(draw, most):
    """Boxes let down at random places: many lose their balance a little, many touch or tie."""
    kind = int(draw.integers(4))
    grid = (1.0, 5.0, 0.1, 1e-9)[kind]
    wide, deep = float(draw.choice([60.0, 80.0, 120.0])), float(draw.choice([50.0, 60.0, 80.0]))
    over = float(draw.choice([0.0, 0.0, 8.0]))
    jitter = float(draw.choice([0.0, 0.0, 1e-9, 0.005, 0.0101, 0.02, 0.5, 2.0]))
    count = int(draw.integers(2, most + 1))
    lower, upper, found = np.empty((count, 3)), np.empty((count, 3)), 0
    sizes = draw.choice([10.0, 18.0, 20.0, 22.0, 25.0, 40.0], (count, 3))
    if kind == 3:
        sizes = draw.uniform(4.0, 45.0, (count, 3))
    if draw.random() < 0.3 and count > 4:  # all that follows stands on one plate: one group
        lower[:2], upper[0], upper[1] = 0.0, (wide, 20.0, deep), (wide, 25.0, deep)
        lower[1, 1], found = 20.0, 2
        sizes = sizes[2:]
    for size in sizes:
        if draw.random() < 0.1:
            size[draw.integers(3)] = draw.choice([0.5, 2.0, 3.0])
        place = draw.uniform(
            [-over, 0.0, -over], [wide + over - size[0], 1.0, deep + over - size[2]]
        )
        place = np.round(place / grid) * grid
        low, high = lower[:found], upper[:found]
        if found and draw.random() < 0.4:
            other, axis = int(draw.integers(found)), int(draw.choice([0, 2]))
            place[axis] = (
                high[other, axis] if draw.random() < 0.5 else low[other, axis] - size[axis]
            )
            place[axis] += draw.choice([0.0, 0.0, 0.01, 0.3])
        shared = np.minimum(high[:, ::2], (place + size)[::2]) - np.maximum(low[:, ::2], place[::2])
        under = high[shared.min(axis=1) > 0.0100001, 1] if found else np.empty(0)
        place[1] = under.max() if len(under) else 0.0
        if draw.random() < 0.25:
            place[1] = max(place[1] + draw.choice([-1.0, 1.0, 1.0]) * jitter, 0.0)
        lower[found], upper[found] = place, place + size
        found += 1
    weights = draw.uniform(1.0, 20.0, count)
    if draw.random() < 0.3:
        weights = 10.0 ** draw.uniform(-2.0, 3.0, count)
    offsets = np.zeros((count, 3))
    if draw.random() < 0.5:
        offsets = draw.uniform(-0.3, 0.3, (count, 3)) * (upper - lower)
    if draw.random() < 0.1:
        order = draw.permutation(count)
        lower, upper = lower[order], upper[order]
    plane = draw.random() < 0.4
    floor = [-np.inf, -np.inf, np.inf, np.inf, 0.0] if plane else [0.0, 0.0, wide, deep, 14.4]
    return fixed(lower, upper, weights, offsets, floor)


def bridged(draw):
    """Two plates joined by a bridge; a bar on one of them comes down onto a prop; then more boxes,
    of which many neither load nor meet what moves.
    """
    rows = [
        (0, 0, 0, 40, 20, 40), (100, 0, 0, 40, 20, 40), (0, 20, 0, 40, 10, 40),
        (100, 20, 0, 40, 10, 40), (30, 30, 0, 80, 5, 10),
        (0, 0, 90, 10, 30 - draw.choice([0.5, 1.0, 3.0]), 10), (0, 30, 20, 10, 5, 80),
    ]  # fmt: skip
    for _ in range(int(draw.integers(1, 5))):
        x = draw.choice([0.0, 10.0, 20.0, 30.0, 100.0, 110.0, 120.0, 130.0, 137.0])
        taken = [k for k, row in enumerate(rows[7:]) if row[0] == x]
        rows.append((x, 30 + 5 * len(taken), 20 if x else 90 - 20 * len(taken), 10, 5, 10))
    table = np.array(rows, dtype=float)
    count = len(table)
    return fixed(table[:, :3], table[:, :3] + table[:, 3:], draw.uniform(1.0, 9.0, count),
                 np.zeros((count, 3)), [-np.inf, -np.inf, np.inf, np.inf, 0.0])  # fmt: skip


def fixed(*arrays):
    made = tuple(np.array(each, dtype=float, order="C") for each in arrays)
    for each in made:
        each.setflags(write=False)
    return made


def joined(layouts):
    """A batch of layouts."""
    starts = np.cumsum([0, *(len(each[2]) for each in layouts)])
    starts.setflags(write=False)
    parts = [np.concatenate([each[k] for each in layouts]) for k in range(4)]
    parts.append(np.array([each[4] for each in layouts]))
    return (*fixed(*parts), starts)


def shipped(word, count, draw, most):
    """Some layouts of a labelled set."""
    data = load_benchmark(word) if word else load_benchmark()
    batch = data.batch(data.cases)
    sizes = np.diff(batch.starts)
    some = np.flatnonzero(sizes <= most)
    some = np.sort(draw.choice(some, min(count, len(some)), replace=False))
    return [
        fixed(*(each[batch.starts[k] : batch.starts[k + 1]]
                for each in (batch.lower, batch.upper, batch.weights, batch.mass_offsets)),
              batch.floors[k])
        for k in some
    ]  # fmt: skip


HOWS = (
    How(0.5, G, 0.3, 10.0, 10.0), How(0.5, G, 1.0, 5.0, 5.0), How(0.0, G, 0.3, 10.0, 10.0),
    How(1.2, G, 5.0, 1.0, 200.0), How(0.5, G, 0.02, 0.0, 10.0), How(0.25, G, 30.0, 10.0, 0.0),
)  # fmt: skip


def a_layout(library, work, tally, arrays, draw, where):
    how = HOWS[int(draw.integers(len(HOWS)))] if draw.random() < 0.5 else HOWS[0]
    limit = float(draw.choice([1e4, 1e4, 1e4, 50.0]))
    part = draw.integers(8)
    if part == 0:
        loading_at_once(library, tally, arrays, how, draw, where)
    elif part < 4:
        loading_by_steps(library, tally, arrays, how, where, limit)
    elif part < 6:
        margin = float(draw.choice([0.0, 0.01, 0.5, 2.0]))
        among_moving(library, tally, arrays, margin, how, draw, where)
    elif part == 6:
        margin = float(draw.choice([0.0, 0.005, 0.01, 0.5, 2.0]))
        whole_groups(library, tally, arrays, margin, where)
    else:
        closest(library, work, tally, arrays, draw, where)


def sides(library, work, tally, draw, count):
    """Layouts with forces at sides, whose searches are compared on their way."""
    from steadyload.statics import friction, motion

    data = load_benchmark()
    rows = data.cases[data.cases["item_count"].between(6, 14)]
    rows = rows.iloc[np.sort(draw.choice(len(rows), count, replace=False))]
    kept = friction.nonnegative_least_squares
    try:
        for name, scenario in rows[["layout", "scenario"]].to_numpy():
            search = squares_of(library, work, tally, f"{name} {scenario}")
            friction.nonnegative_least_squares = motion.nonnegative_least_squares = search
            for spec in ("equilibrium:sides=friction,time=0.3", "equilibrium:sides=frictionless"):
                make_method(spec).judge(data.layout(name, scenario))
    finally:
        friction.nonnegative_least_squares = motion.nonnegative_least_squares = kept


def bad_numbers(library, work, draw):
    """Layouts of which some numbers have no meaning, for sanitizers; nothing is compared."""
    bad = np.array([np.nan, np.inf, -np.inf, 1e308, -1e308, 5e-324, 0.0, -0.0, -1.0, 1e-300])
    arrays = [np.array(each) for each in random_layout(draw, 9)]
    for each in (*arrays, *([arrays[0]] * 2)):
        some = draw.random(each.shape) < draw.choice([0.0, 0.02, 0.3])
        each[some] = draw.choice(bad, some.sum())
    how = How(*(draw.choice([0.5, 1.0, 10.0, *bad]) for _ in range(5)))
    if draw.random() < 0.5:
        how = HOWS[int(draw.integers(len(HOWS)))]
    count, margin = len(arrays[2]), float(draw.choice([0.0, 0.5, np.nan, np.inf, -1.0]))
    ours, held = (
        Timed(library, arrays, margin),
        library.sl_held_new(count, *map(at, arrays), margin),
    )
    ours.work[1] = draw.choice([np.inf, 100.0, np.nan])
    item = INT()
    for step in draw.integers(-1, count + 1, 2 * count) if draw.random() < 0.3 else range(count):
        ours.place(int(step), how)
        who = draw.integers(0, count, int(draw.integers(0, count + 1)))
        ours.moved(int(step), np.unique(who) if draw.random() < 0.9 else who, how)
        library.sl_held_place(held, int(step), ct.byref(item))
        library.sl_timed_group(
            ours.handle, int(step), ct.byref(item), ct.byref(INT()), at(ours.group)
        )
    library.sl_held_free(held)
    ours.free()
    library.sl_first_moved(work, count, *map(at, arrays), 1e4, ct.byref(how), ct.byref(Moved()))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--random", type=int, default=20000)
    parser.add_argument("--boxes", type=int, default=9)
    parser.add_argument("--shipped", type=int, default=120)
    parser.add_argument("--sides", type=int, default=60)
    parser.add_argument(
        "--bad", type=int, default=0, help="layouts without a meaning, not compared"
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--library", type=Path)
    given = parser.parse_args()
    tally, draw = Tally(), np.random.default_rng(given.seed)
    with tempfile.TemporaryDirectory() as folder:
        library = load(given.library or build(folder))
        work = library.sl_work_new()
        for seconds in draw.uniform(0.001, 60.0, 1000):
            tally.take("thin side", library.sl_thin_side(G, seconds),
                       kernels.group_forces.thin_side(G, seconds))  # fmt: skip
        for _ in range(given.bad):
            bad_numbers(library, work, draw)
        layouts = []
        for k in range(given.random):
            most = 40 if k % 50 == 0 else given.boxes
            layouts.append(bridged(draw) if k % 20 == 1 else random_layout(draw, most))
            a_layout(library, work, tally, layouts[-1], draw, f"random {k}")
        if len(layouts) > len(HOWS):
            for n, how in enumerate(HOWS):
                for limit in (np.inf, 30.0):
                    batches(library, work, tally, joined(layouts[n::7]), how, limit, f"random {n}")
        for word in ("", *SETS) if given.shipped else ():
            some = shipped(word, given.shipped, draw, 60)
            for k, arrays in enumerate(some):
                a_layout(library, work, tally, arrays, draw, f"{word or 'large'} {k}")
            whole = shipped(word, 2 * given.shipped, draw, 100)
            for how in HOWS[:2]:
                batches(library, work, tally, joined(whole), how, 3000.0, word or "large")
        if given.sides:
            sides(library, work, tally, draw, given.sides)
        library.sl_work_free(work)
    print(f"{given.random} random layouts, {given.shipped} of every set:")
    differ = tally.tell()
    print("all equal" if not differ else f"{differ} numbers differ",
          f"({time.process_time():.0f} s of CPU time)")  # fmt: skip
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
