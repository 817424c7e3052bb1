"""Test vectors of the C library: layouts, and the numbers that it has to find for them.

``make_vectors.py`` makes ``vectors.parquet`` beside this file. Each row of it is a layout with the
numbers of some of :data:`PARTS`.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from steadyload.core import forces, learned, loading, session, timed, whole
from steadyload.core.constants import (
    BALANCED,
    CARRIED,
    FLOOR,
    LEFT_OUT,
    STANDS,
    SUPPORTED,
    UNRESOLVED,
)
from steadyload.core.timed import How

FILE = Path(__file__).with_name("vectors.parquet")
ARRAYS = ("lower", "upper", "weights", "offsets", "floor")
RULES = (
    (SUPPORTED, 1.0), (SUPPORTED, 0.7), (CARRIED, 0.0), (BALANCED, 0.0), (BALANCED, 0.5),
)  # fmt: skip
PLACED = ((BALANCED, 0.0), (BALANCED, 0.5), (BALANCED, 0.0), (SUPPORTED, 0.7), (CARRIED, 0.0))
G = 980.665
HOWS = (
    How(0.5, G, 0.3, 10.0, 10.0), How(0.5, G, 1.0, 5.0, 5.0), How(0.0, G, 0.3, 10.0, 10.0),
    How(1.2, G, 5.0, 1.0, 200.0), How(0.5, G, 0.02, 0.0, 10.0), How(0.25, G, 30.0, 10.0, 0.0),
)  # fmt: skip
WAYS = ((np.inf, -np.inf, np.inf), (30.0, -np.inf, 0.01), (5.0, -0.01, 0.01))
SHIFTS = np.array([(0.0, 0.0, 0.0), (20.0, 0.0, 0.0), (-7.0, 0.0, 3.0), (0.0, 10.0, 0.0)])

# Every part takes a layout and a whole number, which decides how the part calls what it calls.


def rules(arrays, variant):
    """The first failure by every rule, and the margin of balance."""
    given = whole.Given(*arrays)
    found = [given.judge(*rule) for rule in RULES]
    found.append(given.margin((10.0, 1.0, 60.0)[variant % 3]))
    ended, step, item, number = zip(*found, strict=True)
    return {"ended": ended, "step": step, "item": item, "number": np.array(number, float)}


def contacts(arrays, _):
    """What stands on what, and where."""
    return whole.Given(*arrays).contacts()._asdict()


def placed(arrays, variant):
    """Boxes put on one after the other, half of them taken off, and put on again; contact forces
    in the end.
    """
    held, rows = session.Session(limits_of(arrays).tolist()), boxes_of(arrays)
    rule, alpha = PLACED[variant % len(PLACED)]
    endings, found = [], []
    for turn in range(2):
        for k, row in enumerate(rows):
            if (k + variant) % 7 == 0:
                endings += held.endings(row, np.array(row[:3]) + SHIFTS, rule, alpha).tolist()
            if (k + variant) % 5 == 4:
                found.append((held.put(row), -1, 0.0))
            else:
                ended, _, item, number = held.place(row, rule, alpha)
                fails = ended != STANDS and ended <= UNRESOLVED
                found.append((ended, item if fails else -1, number))
        if turn == 0:
            held.cut(len(held) // 2)
    ended, item, number = zip(*found, strict=True)
    below = [held.below(box) for box in range(len(held))]
    return {
        "ended": ended, "item": item, "number": np.array(number, float), "endings": endings,
        "near": held.near(*(each[0].copy() for each in arrays[:2]), 10.0),
        "below": joined(*(each.below for each in below)),
        "corners": joined(*(each.patches for each in below), kind=float),
        "forces": joined(*(each.presses for each in below), kind=float),
    }  # fmt: skip


def moved(arrays, variant):
    """The first box that comes too far, of two ways to follow boxes."""
    given = whole.Given(*arrays)
    asked = (HOWS[0], 1e4), (HOWS[variant % len(HOWS)], (1e4, 50.0)[variant % 2])
    found = [timed.first_moved(given, limit, how)[:5] for how, limit in asked]
    *whole_numbers, shift, turn = zip(*found, strict=True)
    ways = np.array([shift, turn], float)
    return {"found": np.array(whole_numbers), "ways": ways}


def followed(arrays, variant):
    """Every step, whatever came of those before, and what is known of all boxes in the end."""
    how, margin = HOWS[variant % len(HOWS)], (0.0, 0.01, 0.5, 0.0)[variant // 7 % 4]
    loads, found, ways = timed.Followed(whole.Given(*arrays), margin, 1e4), [], []
    for step in range(len(arrays[2])):
        ended, kept, items = loads.group(step)
        item, way = -1, (0.0, 0.0, 0.0)
        if len(items) and not kept:
            ended, _, item, *way = loads.moved(step, items, how)
        if variant % 2:  # as a step of Followed.first
            ended = STANDS if kept else ended
            loads.counts[0] += kept
        else:
            found += [kept, loads.is_near_its_edge(step, 0.5), *items]
        found += [ended, item]
        ways.append(way)
    kept = loads.moves, loads.answers, loads.solved, loads.counts, loads.pressing, loads.pushes
    return {
        "found": found, "ways": np.array(ways, float), "state": joined(*kept),
        "farthest": loads.farthest.copy(), "beyond": loads.beyond.copy(),
    }  # fmt: skip


def held(arrays, variant):
    """Balance of whole groups at every step."""
    balance = timed.Held(whole.Given(*arrays), (0.0, 0.5, 0.01, 2.0)[variant % 4])
    found = [balance.place(step) for step in range(len(arrays[2]))]
    return {"found": np.array(found), "group": balance.group(len(found) - 1)}


def closest(arrays, variant):
    """Forces that come closest to balancing the group of a box, with wider or narrower patches."""
    given = whole.Given(*arrays)
    found = given.contacts()
    step = max(len(arrays[2]) - 1 - variant % 2, 0)
    items = timed.Held(given).group(step)
    used = [
        (k, above, found.below[k])
        for above in items.tolist()
        for k in range(found.starts[above], found.starts[above + 1])
        if found.below[k] <= step
    ]
    grow = (1e-5, 0.0, 0.5, 5.0, -0.02)[variant % 5]
    used = np.array(used, np.int32).reshape(-1, 3)
    found = timed.closest_to_balance(given, items, used, found.patches, grow)
    return {"found": found[1:], "forces": found.forces}


def loaded(arrays, variant):
    """Plans that are loaded, changed, and loaded again; free places of a box."""
    limits, count = limits_of(arrays), len(arrays[2])
    boxes = loading.Boxes(*plan_of(arrays))
    order = loading.Loading(limits.tolist(), boxes)
    places, refused = boxes.planned, np.empty((0, 5))
    margins = np.full(count, (0.0, 0.05, 0.5)[variant % 3])
    reorder, looks, found, numbers = variant % 4 > 0, variant % 5 == 0, [], []
    for turn in range(4):
        first = count if (variant + turn) % 3 else variant % count
        each = np.stack([margins, np.maximum(margins, 0.5)])
        wishes = loading.Wishes(boxes, places, each, refused)
        order.begin(wishes, first)
        while not order.load(wishes, reorder=reorder, looks=looks):
            stays = (sum(order.loaded().order) + order.looked_at) % 6 != 0
            order.say(stays, reorder=reorder)
        there, stuck = order.loaded()
        box = stuck[0] if stuck else (variant + 5 * turn) % count
        without = (np.arange(count) + variant + turn) % 9 == 0
        free, far = boxes.places_among(
            places, without, box, (0.0, 0.05, 0.5, 3.0)[(variant + turn) % 4], limits[:10].copy(),
            np.array(WAYS[(variant + turn) % 3]), 1 + variant % 2, (4000, 60)[variant % 2],
        )  # fmt: skip
        found += [*there, -1, *stuck, -1, len(free)]
        numbers += [*boxes.cost(places), *free[:3].ravel(), *far[:3], far.sum()]
        if box not in there:
            found += order.first_standing(wishes, box, free[:200].copy(), 0.05, 3).tolist()
        places, margins = places.copy(), margins.copy()
        if len(free):
            places[box] = free[min(variant % 5, len(free) - 1)]
        change, other = (variant + turn) % 5, (3 * variant + turn) % count
        if change == 0:
            places[other] = (0.0, 0.0, 0.0, LEFT_OUT)
        elif change == 1:
            refused = np.vstack([refused, [float(box), *places[box]]])
        elif change == 2:
            margins[other] = 1.0
        elif change == 3:
            places[other] = boxes.planned[other]
    return {"found": found, "numbers": np.array(numbers, float), "tried": order.tried()}


def energy(arrays, variant):
    """Forces of least energy, as a load grows."""
    (below, above), columns = effects(arrays)
    equations = columns.shape[1]
    right = np.zeros(equations)
    right[::3] = arrays[2]
    each = [np.flatnonzero(column) for column in columns]
    values = [column[rows] for column, rows in zip(columns, each, strict=True)]
    starts = np.cumsum([0, *range(equations - 1, -1, -1)])
    rows = [row for first in range(equations) for row in range(first + 1, equations)]
    diagonal = 1e-12 * (1.0 + (columns**2).sum(axis=0))
    solved = forces.Energy(
        as_int32(starts), as_int32(rows), diagonal,
        as_int32(np.cumsum([0, *map(len, each)])), joined(*each),
        joined(*values, kind=float), right, (np.arange(len(columns)) + variant) % 4 > 0,
    )  # fmt: skip
    ended, pulls = [], []
    for count in sorted({len(arrays[2]) // 2, len(arrays[2]) - 1, len(arrays[2])} - {0}):
        there = np.flatnonzero((below < count) & (above < count))
        pull = solved.pulls(as_int32(there), np.arange(3 * count, dtype=np.int32))
        ended.append(pull is not None)
        if pull is None:
            break
        pulls.append(pull)
    return {"ended": ended, "pulls": joined(*pulls, kind=float)}


def squares(arrays, _):
    """Least squares of the vertical balance of all boxes."""
    _, columns = effects(arrays)
    target = np.zeros(columns.shape[1])
    target[::3] = arrays[2]
    x, rest, ended = forces.least_squares(columns, target)
    return {"ended": [ended], "x": x, "rest": rest}


def features(arrays, _):
    """What learned methods judge by."""
    given = whole.Given(*arrays)
    support, network = learned.support(given)
    return {
        "support": support, "network": network,
        "plain": learned.plain_features(given, np.array([120.0, 150.0, 80.0])),
        "quantities": learned.quantities(given),
    }  # fmt: skip


PARTS = {
    part.__name__: part
    for part in (
        rules, contacts, placed, moved, followed, held, closest, loaded, energy, squares, features,
    )
}  # fmt: skip
OF_ALL = ("rules", "contacts", "placed", "moved")
"""Parts that are asked of every layout; the others of some."""

OF_FEW = ("energy", "squares", "features")
"""Parts that are asked of layouts of few boxes alone."""

UNITS = {"moved": 2, "followed": 2, "features": 2}
"""By how many units in the last place numbers may differ: these parts call functions of the
platform's library of mathematics. All others are equal to the bit.
"""


def limits_of(arrays):
    """A contour about a layout, and its deck."""
    lower, upper, *_, floor = arrays
    deck = floor if np.isfinite(floor).all() else np.array([0.0, 0.0, 120.0, 80.0, 0.0])
    low = np.minimum(lower.min(axis=0), 0.0) - 5.0
    high = np.maximum(upper.max(axis=0), (deck[2], 20.0, deck[3])) + 5.0
    low[1] = 0.0
    return np.concatenate((low, high, deck))


def boxes_of(arrays):
    """Boxes as a session takes them."""
    lower, upper, weights, offsets, _ = arrays
    return np.column_stack([lower, upper - lower, offsets, weights]).tolist()


def plan_of(arrays):
    """The arrays of a plan, as the search of a repair has them."""
    lower, upper, weights, offsets, _ = arrays
    sizes, turned = upper - lower, offsets[:, ::-1] * (1.0, 1.0, -1.0)
    return (
        np.stack([sizes, sizes[:, ::-1]]), np.stack([offsets, turned]) + 0.0, weights,
        np.column_stack([lower, np.zeros(len(lower))]), sizes[:, 0] * sizes[:, 1] * sizes[:, 2],
    )  # fmt: skip


def effects(arrays):
    """Forces up at the corners of patches: the boxes below and above each, (2, C), and what a unit
    force does to all boxes: force and moments about the middle, (C, 3 J).
    """
    lower, upper = arrays[:2]
    found, middles = whole.Given(lower, upper, *arrays[2:]).contacts(), 0.5 * (lower + upper)
    above = np.repeat(np.arange(len(lower)), np.diff(found.starts))
    on_floor = np.flatnonzero(found.on_floor)
    patches = np.concatenate([
        found.patches, np.column_stack([lower[on_floor][:, ::2], upper[on_floor][:, ::2]])
    ])  # fmt: skip
    below = np.repeat([*found.below, *(FLOOR for _ in on_floor)], 4).astype(int)
    above = np.repeat([*above, *on_floor], 4).astype(int)
    xs, zs = patches[:, [0, 0, 2, 2]].ravel(), patches[:, [1, 3, 1, 3]].ravel()
    columns = np.zeros((len(xs), len(lower), 3))
    for boxes, sign in ((above, 1.0), (below, -1.0)):
        at = np.flatnonzero(boxes != FLOOR)
        some = middles[boxes[at]]
        columns[at, boxes[at]] += sign * np.column_stack(
            [np.ones(len(at)), xs[at] - some[:, 0], zs[at] - some[:, 2]]
        )
    return (below, above), np.ascontiguousarray(columns.reshape(len(xs), 3 * len(lower)))


def as_int32(values):
    """A copy of that type."""
    return np.array(values, np.int32)


def joined(*arrays, kind=np.int32):
    """All numbers of some arrays, one after the other."""
    return np.concatenate([np.zeros(0, kind), *(np.ravel(each).astype(kind) for each in arrays)])


# --- the file -----------------------------------------------------------------------------------


class Row(NamedTuple):
    """A layout and what is expected of it.

    Attributes:
        name: "drawn", or of a shipped set, and a number.
        variant: see the parts.
        arrays: of the layout.
        expected: part -> name -> numbers, of the parts that are asked of it.
    """

    name: str
    variant: int
    arrays: tuple[Any, ...]
    expected: dict[str, dict[str, Any]]


def asked(part: str, arrays: tuple[Any, ...], variant: int) -> dict[str, Any]:
    """The numbers of a part, in flat arrays of type int32, float32 or float64, by name. What is in
    no array has whole numbers alone.
    """
    return {
        name: np.array(each, _kind(each)).ravel()
        for name, each in PARTS[part](arrays, variant).items()
    }


def _kind(each: Any) -> Any:
    kind = getattr(each, "dtype", np.dtype(np.int32))
    return kind if kind.kind == "f" else np.int32


def write(rows: list[Row], file: Path = FILE) -> None:
    """Write rows; what is not asked of a layout is missing in its row."""
    columns: dict[str, list[Any]] = {}
    for k, row in enumerate(rows):
        numbers = dict(zip(ARRAYS, map(np.ravel, row.arrays), strict=True))
        for part, found in row.expected.items():
            numbers |= {f"{part}.{name}": each for name, each in found.items()}
        for key, each in numbers.items():
            columns.setdefault(key, [None] * len(rows))[k] = each
    kinds = {key: next(n.dtype for n in each if n is not None) for key, each in columns.items()}
    table = {"name": [row.name for row in rows], "variant": [row.variant for row in rows]} | {
        key: pa.array(each, pa.list_(pa.from_numpy_dtype(kinds[key])))
        for key, each in sorted(columns.items())
    }
    pq.write_table(pa.table(table), file, compression="zstd", compression_level=19)


def read(file: Path = FILE) -> list[Row]:
    """The rows that were written."""
    table = pq.read_table(file)
    columns = {key: list(_numbers(table[key].combine_chunks())) for key in table.column_names[2:]}
    rows = []
    for k, (name, variant) in enumerate(
        zip(table["name"].to_pylist(), table["variant"].to_pylist(), strict=True)
    ):
        arrays = tuple(
            columns[key][k].reshape(-1, 3)
            if key in ("lower", "upper", "offsets")
            else columns[key][k]
            for key in ARRAYS
        )
        rows.append(Row(name, variant, arrays, {}))
    for key, each in columns.items():
        part, _, name = key.partition(".")
        for k in range(len(rows)) if name else ():
            if each[k] is not None:
                rows[k].expected.setdefault(part, {})[name] = each[k]
    return rows


def _numbers(column: Any) -> Iterator[Any]:
    """Copies of the numbers of all rows of a column, None where they are missing."""
    numbers, ends = column.values.to_numpy(), column.offsets.to_numpy().tolist()
    there = column.is_valid().to_numpy(zero_copy_only=False).tolist()
    for is_there, (start, end) in zip(there, pairwise(ends), strict=True):
        yield numbers[start:end].copy() if is_there else None


def differing(found: Any, expected: Any, units: int) -> Any:
    """Which numbers differ, by more than some units in the last place or, by 0, in a bit."""
    if units and found.dtype.kind == "f":
        with np.errstate(invalid="ignore"):
            near = np.abs(found - expected) <= units * np.spacing(np.abs(expected))
        return ~(near | (found == expected) | (np.isnan(found) & np.isnan(expected)))
    whole_numbers = f"i{found.itemsize}"
    return found.view(whole_numbers) != expected.view(whole_numbers)


def differences(part: str, rows: list[Row]) -> list[str]:
    """Lines on the numbers of a part that are not those expected, by name of the layout."""
    lines, units = [], UNITS.get(part, 0)
    for row in rows:
        if part not in row.expected:
            continue
        for name, found in asked(part, row.arrays, row.variant).items():
            expected, of = row.expected[part][name], f"{row.name}: {part}.{name}"
            if found.shape != expected.shape:
                lines.append(f"{of}: {len(found)} numbers, not {len(expected)}")
            elif (wrong := differing(found, expected, units)).any():
                at = int(np.argmax(wrong))
                lines.append(
                    f"{of}: {np.count_nonzero(wrong)} of {len(found)} numbers differ; "
                    f"number {at} is {found[at]!r}, not {expected[at]!r}"
                )
    return lines
