"""Small random plans, some boxes of which have little or nothing under them."""

from dataclasses import replace

import numpy as np

from steadyload.layouts import Item, Layout, LayoutError, Pallet
from steadyload.layouts.model.layout import replace_items
from steadyload.methods import make_method

WIDTH, HEIGHT, DEPTH = 30.0, 60.0, 20.0
GRID = 5.0
"""All sides and positions are multiples of it [cm]."""


def random_plan(
    seed, boxes, *, floating=0.15, shuffled=0.3, name="plan", limits=False, overhang=0.0
):
    """A valid plan of boxes let down onto each other, and now and then left in the air.

    Args:
        seed: of all draws.
        boxes: number of boxes.
        floating: share of boxes that are one step too high.
        shuffled: share of plans in a random order of loading.
        name: of the layout.
        limits: a third of the boxes state what they may bear.
        overhang: how far boxes may stand out over the deck [cm]; none does.
    """
    rng = np.random.default_rng(seed)
    while True:
        items = []
        for number in range(boxes):
            sides = GRID * rng.integers(1, 5, 3).astype(float)
            width, height, depth = np.minimum(sides, (WIDTH, HEIGHT, DEPTH)).tolist()
            x = GRID * float(rng.integers(0, (WIDTH - width) // GRID + 1))
            z = GRID * float(rng.integers(0, (DEPTH - depth) // GRID + 1))
            y = _top(items, x, z, width, depth) + GRID * float(rng.random() < floating)
            offset = float(rng.choice((0.0, 0.0, 0.2))) * width
            most = float(rng.integers(5, 40)) if limits and rng.random() < 0.33 else None
            items.append(
                Item(
                    number, (x, y, z), (width, height, depth), float(rng.integers(1, 20)),
                    (offset, 0.0, 0.0), f"box-{number}", most,
                )
            )  # fmt: skip
        order = rng.permutation(boxes) if rng.random() < shuffled else np.arange(boxes)
        try:
            return Layout(
                name, Pallet(WIDTH, HEIGHT, DEPTH, overhang=overhang), _numbered(items, order)
            )
        except LayoutError:  # it is too high
            continue


def failing_plan(seed, boxes, **how):
    """The first random plan from a seed on that is not balanced with a margin of 0.5 cm."""
    return _first(seed, boxes, False, **how)


def standing_plan(seed, boxes):
    """The first random plan from a seed on that is balanced with a margin of 0.5 cm."""
    return _first(seed, boxes, True, floating=0.0, shuffled=0.0)


def reordered(plan, order):
    """The same boxes at the same places in another order of loading."""
    return replace_items(plan, _numbered(plan.items, order))


def with_first(plan, item):
    """The plan with another box loaded first; None where that overlaps one."""
    try:
        return replace_items(plan, _numbered((item, *plan.items), range(len(plan) + 1)))
    except LayoutError:
        return None


def _first(seed, boxes, stands, **how):
    judge = make_method("equilibrium:margin=0.5")
    while True:
        plan = random_plan(seed, boxes, **how)
        if judge.judge(plan).stable is stands:
            return plan
        seed += 1000


def _numbered(items, order):
    return tuple(replace(items[box], sequence=turn) for turn, box in enumerate(order))


def _top(items, x, z, width, depth):
    tops = [
        item.position[1] + item.size[1]
        for item in items
        if min(x + width, item.position[0] + item.size[0]) > max(x, item.position[0])
        and min(z + depth, item.position[2] + item.size[2]) > max(z, item.position[2])
    ]
    return max(tops, default=0.0)
