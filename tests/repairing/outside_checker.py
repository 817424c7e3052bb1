"""A checker of repaired plans that shares no code with what made them: numpy, scipy, nothing else.

It reads native JSON and CSV files by itself, follows each box from the plan to its repair by the
record of the repair, and says what does not hold. Lengths in cm, weights in kg; y points up.
"""

from __future__ import annotations

import csv
import json
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import linprog

APART = 0.0101
"""Lengths that differ by no more count as equal: a tenth of a millimetre, and rounding."""

SAME = 1e-4
"""Places that differ by no more are the same: a file has a few decimals."""

HOVERS = 2.0
"""A box that is higher above what carries it than this hovers; lower ones are let down."""

DECK_OVERHANG = 10.0
"""How far boxes may stand out over the deck where a file does not state it."""


@dataclass(frozen=True)
class Box:
    """A box at its place: ``low``, its lower corner, and ``size`` are (x, y, z)."""

    id: str
    low: tuple[float, float, float]
    size: tuple[float, float, float]
    weight: float
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    max_load: float | None = None

    @property
    def high(self) -> tuple[float, float, float]:
        """The upper corner."""
        x, y, z = np.add(self.low, self.size).tolist()
        return x, y, z

    @property
    def middle(self) -> np.ndarray:
        """The middle between both corners."""
        return np.add(self.low, np.multiply(self.size, 0.5))


@dataclass(frozen=True)
class Plan:
    """Boxes in the order of loading on a pallet of ``size``, (width, height, depth)."""

    name: str
    size: tuple[float, float, float]
    boxes: tuple[Box, ...]
    overhang: float = DECK_OVERHANG
    floor: str = "auto"

    @property
    def on_deck(self) -> bool:
        """Nothing carries beyond the deck."""
        if self.floor == "auto":
            return bool(max(standing_out(self)) > APART)
        return self.floor == "deck"


@dataclass(frozen=True)
class Rules:
    """What was allowed of a repair: words of ``--allow``, and ``--shift-cm``."""

    allow: frozenset[str]
    shift: float


# --- files ----------------------------------------------------------------------------------------


def plans_of(path: Path, **stated: Any) -> dict[str, Plan]:
    """The plans of a native or a CSV file, by name.

    Args:
        path: the file.
        stated: ``overhang`` and ``floor`` of all pallets, where the file states none.
    """
    text = path.read_text()
    read = _native(json.loads(text)) if text.startswith("{") else _table(text)
    return {plan.name: replace(plan, **stated) for plan in read}


def _native(content: dict[str, Any]) -> list[Plan]:
    found = []
    for one in content["layouts"]:
        pallet = one["pallet"]
        deck = {key: pallet[key] for key in ("overhang", "floor") if key in pallet}
        boxes = [
            Box(
                item.get("name", ""), tuple(item["position"]), tuple(item["size"]), item["weight"],
                tuple(item.get("mass_offset", (0.0, 0.0, 0.0))), item.get("max_load"),
            )
            for item in sorted(one["items"], key=lambda item: item["sequence"])
        ]  # fmt: skip
        size = (pallet["width"], pallet["height"], pallet["depth"])
        found.append(Plan(one["name"], size, tuple(boxes), **deck))
    return found


def _table(text: str) -> list[Plan]:
    rows: dict[str, list[dict[str, str]]] = {}
    for row in csv.DictReader(text.splitlines()):
        rows.setdefault(row["layout"], []).append(row)

    def numbers(row: dict[str, str], *names: str) -> Any:
        return tuple(float(row.get(name) or 0.0) for name in names)

    found = []
    for name, own in rows.items():
        own.sort(key=lambda row: int(row["sequence"]))
        boxes = [
            Box(
                row["item"], numbers(row, "x", "y", "z"), numbers(row, "width", "height", "depth"),
                float(row["weight"]), numbers(row, "offset_x", "offset_y", "offset_z"),
                float(row["max_load"]) if row.get("max_load") else None,
            )
            for row in own
        ]  # fmt: skip
        size = numbers(own[0], "pallet_width", "pallet_height", "pallet_depth")
        found.append(Plan(name, size, tuple(boxes)))
    return found


# --- a repair -------------------------------------------------------------------------------------


def violations(before: Plan, after: Plan, record: dict[str, Any], rules: Rules) -> list[str]:
    """What does not hold of a repair: texts that begin with the kind, none for a good one.

    Args:
        before: the plan.
        after: what was written in its place.
        record: what ``repair --json`` says of it.
        rules: what was allowed.
    """
    if record["outcome"] != "repaired":
        return [] if before == after else ["changed: it was not repaired, and differs"]
    left, changes = set(record["steps_left_out"]), record["changes"]
    count = len(before.boxes)
    if len(after.boxes) != count - len(left) or not left <= set(range(count)):
        return [f"boxes: {len(after.boxes)} of {count}, {len(left)} left out"]
    steps = _steps(count, left, changes)
    if sorted(steps) != sorted(set(range(count)) - left):
        return ["boxes: the list of changes names a step twice"]
    found = ["left out: not allowed"] if left and "leave" not in rules.allow else []
    if steps != sorted(steps) and "order" not in rules.allow:
        found.append("order: another one is not allowed")
    said = {change["step"]: change for change in changes}
    for step, now in zip(steps, after.boxes, strict=True):
        told = _of_box(before.boxes[step], now, rules, said.get(step))
        found += [f"{kind}: step {step}" for kind in told]
    if (before.size, before.overhang, before.floor) != (after.size, after.overhang, after.floor):
        found.append("pallet: another one")
    return [
        *found, *_contour(before, after), *overlaps(after.boxes),
        *_ways_from_above(before, after, steps), *unbalanced(after),
    ]  # fmt: skip


def _steps(count: int, left: set[int], changes: list[dict[str, Any]]) -> list[int]:
    """For each box of the repair its step in the plan: as the changes say, the others in turn."""
    told = {one["new_step"]: one["step"] for one in changes if one["new_step"] is not None}
    others = iter([step for step in range(count) if step not in {*told.values(), *left}])
    return [told[k] if k in told else next(others, -1) for k in range(count - len(left))]


def _of_box(was: Box, now: Box, rules: Rules, change: dict[str, Any] | None) -> list[str]:
    """Kinds of what does not hold of a box."""
    (w, h, d), (x, y, z) = was.size, was.offset
    turned = not _same(was.size, now.size)
    offsets = [(z, y, -x), (-z, y, x)] if turned else [(x, y, z)]
    found = []
    if (was.id, was.max_load) != (now.id, now.max_load) or not math.isclose(
        was.weight, now.weight, rel_tol=1e-6
    ):
        found.append("contents")
    if turned and not _same((d, h, w), now.size):
        found.append("size")
    if not any(_same(offset, now.offset) for offset in offsets):
        found.append("offset")
    if turned and "turn" not in rules.allow:
        found.append("turned")
    way = now.middle - was.middle
    if "move" not in rules.allow:
        if np.hypot(way[0], way[2]) > (rules.shift if "shift" in rules.allow else 0.0) + SAME:
            found.append("shift")
        if way[1] > APART:
            found.append("up")
        if way[1] < -APART and "drop" not in rules.allow:
            found.append("drop")
    listed = (0.0, 0.0, 0.0) if change is None else tuple(change[f"{k}_cm"] for k in "xyz")
    if not _same(way, listed) or turned != bool(change and change["turned"]):
        found.append("list of changes")
    return found


def _same(one: Any, other: Any) -> bool:
    return bool(np.allclose(one, other, rtol=0.0, atol=SAME))


def standing_out(plan: Plan) -> list[float]:
    """How far boxes stand out over the four edges of the deck: -x, -z, +x, +z."""
    low = np.array([box.low for box in plan.boxes])
    high = np.array([box.high for box in plan.boxes])
    width, _, depth = plan.size
    out = [-low[:, 0].min(), -low[:, 2].min(), high[:, 0].max() - width, high[:, 2].max() - depth]
    return [max(float(far), 0.0) for far in out]


def _contour(before: Plan, after: Plan) -> list[str]:
    high = max(box.high[1] for box in after.boxes) - after.size[1]
    low = min(box.low[1] for box in after.boxes)
    found = [f"height: {high:.3f} cm too high"] if high > APART else []
    found += [f"height: {-low:.3f} cm below the floor"] if low < -APART else []
    edges = zip(standing_out(before), standing_out(after), strict=True)
    found += [
        f"overhang: {now:.3f} cm, {was:.3f} cm in the plan"
        for was, now in edges
        if now > min(was, after.overhang) + APART
    ]
    return found


def overlaps(boxes: tuple[Box, ...]) -> list[str]:
    """Pairs of boxes that share space."""
    low, high = np.array([box.low for box in boxes]), np.array([box.high for box in boxes])
    shared = np.minimum(high[:, None], high) - np.maximum(low[:, None], low)
    pairs = np.argwhere(np.triu(shared.min(axis=2) > APART, 1))
    return [f"overlap: boxes {a} and {b}" for a, b in pairs]


def _ways_from_above(before: Plan, after: Plan, steps: list[int]) -> list[str]:
    """A box over a later one is in its way, unless both are as in the plan, and it was so there.

    As in the plan is also a box that has only come down as its gaps, and those below, were closed.
    """
    closed, found = _let_down(list(before.boxes), before), []
    for k, box in enumerate(after.boxes):
        for m, other in enumerate(after.boxes[:k]):
            if not _is_over(other, box):
                continue
            pair = ((box, steps[k]), (other, steps[m]))
            stay = all(
                one.size == before.boxes[step].size
                and any(_same(one.low, was[step].low) for was in (before.boxes, closed))
                for one, step in pair
            )
            so = _is_over(before.boxes[steps[m]], before.boxes[steps[k]]) and steps[m] < steps[k]
            if not (stay and so):
                found.append(f"blocked: box {k} below box {m}, which is loaded before")
    return found


def _is_over(upper: Box, lower: Box) -> bool:
    """Whether a box is higher than another one, with a part of it straight above."""
    aside = [min(upper.high[k], lower.high[k]) - max(upper.low[k], lower.low[k]) for k in (0, 2)]
    return min(aside) > APART and upper.low[1] >= lower.high[1] - APART


# --- balance --------------------------------------------------------------------------------------


def unbalanced(plan: Plan) -> list[str]:
    """The first step after which no forces hold all boxes, or only ones that crush a box.

    Forces push straight up at the corners of contacts. Boxes up to :data:`HOVERS` above what
    carries them are let down before.
    """
    boxes: list[Box] = []
    for step, box in enumerate(plan.boxes):
        boxes.append(box)
        # What is loaded before may hang over a later box, so that all are let down again.
        load = _let_down(boxes, plan)
        if not _forces_exist(load, plan, limited=False):
            return [f"balance: step {step}"]
        bearing = any(one.max_load is not None for one in load)
        if bearing and not _forces_exist(load, plan, limited=True):
            return [f"max_load: step {step}"]
    return []


def _let_down(boxes: list[Box], plan: Plan) -> list[Box]:
    done: dict[int, Box] = {}
    for k in sorted(range(len(boxes)), key=lambda k: boxes[k].low[1]):
        box = boxes[k]
        levels = [other.high[1] for other in done.values() if _base(box, other) is not None]
        levels += [0.0] if _on_floor(box, plan) is not None else []
        below = [level for level in levels if level <= box.low[1] + APART]
        gap = box.low[1] - max(below, default=-math.inf)
        x, y, z = box.low
        done[k] = replace(box, low=(x, y - gap, z)) if APART < gap <= HOVERS + APART else box
    return [done[k] for k in range(len(boxes))]


def _base(box: Box, other: Box) -> tuple[float, float, float, float] | None:
    """The rectangle (x0, z0, x1, z1) that two boxes share as seen from above."""
    return _rectangle(box, (other.low[0], other.low[2], other.high[0], other.high[2]))


def _on_floor(box: Box, plan: Plan) -> tuple[float, float, float, float] | None:
    far = math.inf
    deck = (0.0, 0.0, plan.size[0], plan.size[2]) if plan.on_deck else (-far, -far, far, far)
    return _rectangle(box, deck)


def _rectangle(
    box: Box, part: tuple[float, float, float, float]
) -> tuple[float, float, float, float] | None:
    x0, z0 = max(box.low[0], part[0]), max(box.low[2], part[1])
    x1, z1 = min(box.high[0], part[2]), min(box.high[2], part[3])
    return (x0, z0, x1, z1) if min(x1 - x0, z1 - z0) > APART else None


def _forces_exist(boxes: list[Box], plan: Plan, *, limited: bool) -> bool:
    """Whether a linear programme finds forces that hold all boxes; ``limited``: and crush none."""
    columns: list[tuple[int, int, float, float]] = []  # box above, box below or -1, x, z
    for k, box in enumerate(boxes):
        if abs(box.low[1]) <= APART:
            columns += _corners(k, -1, _on_floor(box, plan))
        for m, other in enumerate(boxes):
            if m != k and abs(box.low[1] - other.high[1]) <= APART:
                columns += _corners(k, m, _base(box, other))
    count = len(boxes)
    if not columns:
        return False
    held = np.zeros((3 * count, len(columns)))
    borne = np.zeros((count, len(columns)))
    for n, (above, below, x, z) in enumerate(columns):
        for k, push in ((above, 1.0), (below, -1.0)):
            if k >= 0:
                centre = boxes[k].middle + boxes[k].offset
                arms = ((x - centre[0]) / 100.0, (z - centre[2]) / 100.0)
                held[3 * k : 3 * k + 3, n] = push, push * arms[0], push * arms[1]
        if below >= 0:
            borne[below, n] = 1.0
    total = sum(box.weight for box in boxes)
    weights = np.zeros(3 * count)
    weights[::3] = [box.weight / total for box in boxes]
    most = np.array([
        math.inf if box.max_load is None else box.max_load * 1.0001 / total for box in boxes
    ])  # fmt: skip
    bound = np.isfinite(most) & limited
    # What is missing to balance is paid for: none has to be.
    missing = np.hstack([np.eye(3 * count), -np.eye(3 * count)])
    cost = np.concatenate([np.zeros(len(columns)), np.ones(6 * count)])
    upper = np.hstack([borne, np.zeros((count, 6 * count))])[bound] if bound.any() else None
    said = linprog(
        cost, A_eq=np.hstack([held, missing]), b_eq=weights, A_ub=upper,
        b_ub=most[bound] if bound.any() else None, method="highs",
    )  # fmt: skip
    return bool(said.status == 0 and said.fun <= 1e-6)


def _corners(
    above: int, below: int, rectangle: tuple[float, float, float, float] | None
) -> list[tuple[int, int, float, float]]:
    if rectangle is None:
        return []
    x0, z0, x1, z1 = rectangle
    return [(above, below, x, z) for x in (x0, x1) for z in (z0, z1)]
