"""Random plans that fail, repaired by the command and checked by code that shares none with it."""

import ast
import json
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import outside_checker
import pytest
from outside_checker import (
    Box,
    Plan,
    Rules,
    plans_of,
    unbalanced,
    violations,
)

from steadyload.cli import main

WORDS = ("order", "drop", "shift", "turn", "move", "leave")
RULES = Rules(frozenset(WORDS), 30.0)
COLUMNS = (
    "layout", "pallet_width", "pallet_height", "pallet_depth", "sequence", "item", "x", "y", "z",
    "width", "height", "depth", "weight", "offset_x", "offset_y", "offset_z", "max_load",
)  # fmt: skip


# --- random plans ---------------------------------------------------------------------------------


def failing_plan(rng):
    """A random plan that the outside checker calls unbalanced, crushed or blocked by its order."""
    while True:
        plan = random_plan(rng)
        if unbalanced(plan):
            return plan


def random_plan(rng):
    """Boxes let down onto each other, most of them well carried; some hang, some swap turns."""
    overhang = float(rng.choice([0.0, 5.0, 10.0, 30.0]))
    limits, offsets, alike = rng.random(3) < (0.4, 0.4, 0.4)
    boxes = []
    plan = Plan(
        "plan", (float(rng.choice([80, 120])), float(rng.choice([100, 160])), 80.0), (),
        overhang=overhang, floor=str(rng.choice(["deck", "infinite"])),
    )  # fmt: skip
    count = int(rng.integers(2, 26))
    while len(boxes) < count:
        size = np.array([rng.integers(10, 46), rng.integers(8, 31), rng.integers(10, 46)], float)
        low = _place(rng, boxes, plan, size)
        if low is None:
            break
        offset = np.zeros(3)
        if offsets and rng.random() < 0.5:
            offset = np.round(rng.uniform(-0.25, 0.25, 3) * size, 2)
        most = float(rng.integers(3, 60)) if limits and rng.random() < 0.4 else None
        name = f"SKU-{rng.integers(3)}" if alike else f"SKU-{len(boxes)}"
        weight = float(rng.integers(1, 31))
        boxes.append(Box(name, tuple(low), tuple(size), weight, tuple(offset), most))
    order = np.arange(len(boxes))
    if rng.random() < 0.3:
        a, b = rng.integers(0, len(boxes), 2)
        order[[a, b]] = order[[b, a]]
    return replace(plan, boxes=tuple(boxes[k] for k in order))


def _place(rng, boxes, plan, size):
    """A lower corner on top of all that is below; now and then a gap above it."""
    width, height, depth = plan.size
    out = plan.overhang if rng.random() < 0.3 else 0.0
    best = None
    for _ in range(30):
        x = float(np.round(rng.uniform(-out, width + out - size[0])))
        z = float(np.round(rng.uniform(-out, depth + out - size[2])))
        box = Box("", (x, 0.0, z), tuple(size), 1.0)
        shared = [
            (other.high[1], min(box.high[0], other.high[0]) - max(x, other.low[0]),
             min(box.high[2], other.high[2]) - max(z, other.low[2]))
            for other in boxes
        ]  # fmt: skip
        over = [(top, dx * dz) for top, dx, dz in shared if min(dx, dz) > 0.0]
        top = max((top for top, _ in over), default=0.0)
        area = sum(part for level, part in over if level == top) if over else size[0] * size[2]
        gap = float(rng.choice([0.0, 0.3, 1.5, 6.0], p=[0.9, 0.04, 0.03, 0.03]))
        if top + gap + size[1] <= height and (best is None or area > best[0]):
            best = (area, (x, top + gap, z))
            if rng.random() < 0.15 or area > 0.8 * size[0] * size[2]:
                break
    return None if best is None else best[1]


def write(path, plan):
    """A plan as a native file, or as a CSV file, which has no place for the deck."""
    if path.suffix == ".csv":
        rows = [
            (plan.name, *plan.size, step, box.id, *box.low, *box.size, box.weight, *box.offset,
             "" if box.max_load is None else box.max_load)
            for step, box in enumerate(plan.boxes)
        ]  # fmt: skip
        path.write_text("".join(",".join(map(str, row)) + "\n" for row in (COLUMNS, *rows)))
        return
    items = [
        {"sequence": step, "name": box.id, "position": box.low, "size": box.size,
         "weight": box.weight, "mass_offset": box.offset}
        | ({} if box.max_load is None else {"max_load": box.max_load})
        for step, box in enumerate(plan.boxes)
    ]  # fmt: skip
    pallet = dict(zip(("width", "height", "depth"), plan.size, strict=True))
    pallet |= {"overhang": plan.overhang, "floor": plan.floor}
    layout = {"name": plan.name, "pallet": pallet, "items": items}
    path.write_text(json.dumps({"format": "steadyload-layouts", "version": 1, "layouts": [layout]}))


# --- repairs of them ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("first", "last"),
    [(0, 3), *((k, k + 100) for k in range(0, 400, 100))],
)
def test_no_repair_of_a_random_plan_breaks_a_rule(first, last, tmp_path, capsys, in_this_process):
    outcomes, found = Counter(), []
    for number in range(first, last):
        rng = np.random.default_rng(number)
        plan = failing_plan(rng)
        source, target = (
            tmp_path / f"{name}.{('json', 'csv')[number % 2]}" for name in ("in", "out")
        )
        write(source, plan)
        allow = frozenset(rng.choice(WORDS, rng.integers(2, 7), replace=False).tolist())
        rules = Rules(allow, float(rng.choice([5.0, 30.0, 60.0])))
        words = [
            "--allow", ",".join(sorted(rules.allow)), "--shift-cm", f"{rules.shift:g}",
            "--seed", str(rng.integers(100)), "--seconds", "2", "--json",
            *([] if rng.random() < 0.5 else ["-m", "equilibrium"]),
        ]  # fmt: skip
        deck = {}
        if source.suffix == ".csv":
            deck = {"overhang": plan.overhang, "floor": plan.floor}
            words += ["--overhang", f"{plan.overhang:g}", "--floor", plan.floor]
        assert main(["repair", str(source), "-o", str(target), *words]) in (0, 1, 3), number
        [record] = json.loads(capsys.readouterr().out)
        [before], [after] = (plans_of(file, **deck).values() for file in (source, target))
        assert before == plan
        outcomes[record["outcome"]] += 1
        found += [(number, told) for told in violations(before, after, record, rules)]
    told = ", ".join(f"{number} {outcome}" for outcome, number in sorted(outcomes.items()))
    print(f"{last - first} failing plans: {told}; {len(found)} violations")  # shown with -rP
    assert found == []
    assert outcomes["repaired"] >= (last - first) // 2


# --- the checker ----------------------------------------------------------------------------------


def test_the_checker_imports_nothing_of_the_project():
    tree = ast.parse(Path(outside_checker.__file__).read_text())
    names = [node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    names += [one.name for node in ast.walk(tree) if isinstance(node, ast.Import)
              for one in node.names]  # fmt: skip
    assert {name.split(".")[0] for name in names} <= {"numpy", "scipy", *sys.stdlib_module_names}


LOW, SIZE = (0.0, 0.0, 0.0), (40.0, 30.0, 30.0)
GOOD = Plan(
    "plan", (120.0, 130.0, 80.0),
    (
        Box("A", LOW, SIZE, 12.0, (1.0, 0.0, 0.0)),
        Box("B", (5.0, 30.0, 0.0), SIZE, 9.0, max_load=9.0),
        Box("C", (60.0, 0.0, 0.0), SIZE, 7.0),
        Box("D", (10.0, 60.0, 0.0), SIZE, 7.0),
    ),
    overhang=10.0, floor="deck",
)  # fmt: skip
"""Column A, B, D and box C beside it."""


def moved(step, *, into=(0, 1, 2, 3), **values):
    """The plan with a box of other values, and its boxes in another order of loading."""
    boxes = list(GOOD.boxes)
    boxes[step] = replace(boxes[step], **values)
    return replace(GOOD, boxes=tuple(boxes[k] for k in into))


def change(step, new_step, x=0.0, y=0.0, z=0.0, turned=False):
    return {"step": step, "new_step": new_step, "x_cm": x, "y_cm": y, "z_cm": z, "turned": turned}


def kinds(after, *changes, left=(), allow=WORDS, before=GOOD):
    """Kinds of violations of a repair of the plan."""
    record = {"outcome": "repaired", "steps_left_out": list(left), "changes": changes}
    told = violations(before, after, record, Rules(frozenset(allow), 30.0))
    return {one.partition(":")[0] for one in told}


def reordered(*steps):
    return replace(GOOD, boxes=tuple(GOOD.boxes[step] for step in steps))


TURNED = (30.0, 30.0, 40.0)
PLANTED = {
    "changed": (moved(2, low=(61.0, 0.0, 0.0)), (), {}),
    "boxes": (reordered(0, 1, 2), (), {}),
    "left out": (reordered(0, 1, 2), (), {"left": (3,), "allow": ("order",)}),
    "order": (
        reordered(2, 0, 1, 3), (change(2, 0),), {"allow": ("drop", "shift")},
    ),
    "contents": (moved(2, weight=6.0), (), {}),
    "size": (moved(2, size=(41.0, 30.0, 30.0)), (change(2, 2, x=0.5),), {}),
    "offset": (moved(0, offset=(-1.0, 0.0, 0.0)), (), {}),
    "turned": (
        moved(2, size=TURNED, low=(65.0, 0.0, 0.0)), (change(2, 2, z=5.0, turned=True),),
        {"allow": ("shift",)},
    ),
    "shift": (moved(2, low=(60.0, 0.0, 31.0)), (change(2, 2, z=31.0),), {"allow": ("shift",)}),
    "up": (
        moved(2, low=(10.0, 30.0, 40.0)), (change(2, 2, x=-50.0, y=30.0, z=40.0),),
        {"allow": ("shift", "drop")},
    ),
    "drop": (
        moved(3, low=(60.0, 30.0, 0.0)), (change(3, 3, x=50.0, y=-30.0),), {"allow": ("shift",)},
    ),
    "list of changes": (moved(2, low=(62.0, 0.0, 0.0)), (), {}),
    "pallet": (replace(GOOD, size=(120.0, 140.0, 80.0)), (), {}),
    "height": (
        replace(moved(3, low=(10.0, 60.0, 0.0)), size=(120.0, 89.0, 80.0)), (),
        {"before": replace(GOOD, size=(120.0, 89.0, 80.0))},
    ),
    "overhang": (moved(2, low=(81.0, 0.0, 0.0)), (change(2, 2, x=21.0),), {}),
    "overlap": (moved(2, low=(39.0, 0.0, 0.0)), (change(2, 2, x=-21.0),), {}),
    "blocked": (reordered(1, 0, 2, 3), (change(1, 0),), {}),
    "balance": (moved(3, low=(26.0, 60.0, 0.0)), (change(3, 3, x=16.0),), {}),
    "max_load": (
        moved(2, low=(10.0, 90.0, 0.0), into=(0, 1, 3, 2)),
        (change(2, 3, x=-50.0, y=90.0),), {},
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", PLANTED)
def test_the_checker_finds_a_planted_violation(kind):
    after, changes, how = PLANTED[kind]
    if kind == "changed":
        [told] = violations(GOOD, after, {"outcome": "not repaired"}, RULES)
        assert told.startswith("changed: ")
    else:
        assert kind in kinds(after, *changes, **how)


def test_the_checker_finds_nothing_in_good_repairs():
    assert kinds(GOOD) == set()
    assert unbalanced(GOOD) == []
    assert kinds(reordered(2, 0, 1, 3), change(2, 0)) == set()
    assert kinds(reordered(0, 1, 2), left=(3,)) == set()
    lifted = moved(2, low=(60.0, 1.0, 0.0))
    assert kinds(GOOD, change(2, 2, y=-1.0), before=lifted, allow=("drop",)) == set()
    assert unbalanced(lifted) == []
    assert unbalanced(moved(2, low=(60.0, 3.0, 0.0))) == ["balance: step 2"]
    hanging = replace(reordered(1, 0, 2, 3), floor="infinite")  # B over A, which is loaded later
    assert "blocked" not in kinds(hanging, before=hanging)
    steps = {1: 1.0, 0: 0.0, 2: 0.0, 3: 1.0}  # B and D come down as a gap below B is closed
    gap = [replace(GOOD.boxes[k], low=tuple(np.add(GOOD.boxes[k].low, (0.0, up, 0.0))))
           for k, up in steps.items()]  # fmt: skip
    airy, down = replace(hanging, boxes=tuple(gap)), (change(0, 0, y=-1.0), change(3, 3, y=-1.0))
    assert "blocked" not in kinds(hanging, *down, before=airy)
    aside = (replace(hanging.boxes[0], low=(6.0, 30.0, 0.0)), *hanging.boxes[1:])
    assert "blocked" in kinds(
        replace(hanging, boxes=aside), change(0, 0, x=1.0, y=-1.0), down[1], before=airy
    )
    turned_round = moved(0, size=TURNED, offset=(0.0, 0.0, 1.0), low=(5.0, 0.0, -5.0))
    assert kinds(turned_round, change(0, 0, turned=True), allow=("turn",)) == {"overhang"}
