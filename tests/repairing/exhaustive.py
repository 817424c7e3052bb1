"""The best repair of a plan of few boxes, by trying every order, subset and place of a grid."""

from itertools import combinations, permutations, product

import numpy as np

from steadyload.core.constants import AS_PLANNED, TURNED
from steadyload.layouts.model.growing import numbered
from steadyload.layouts.model.layout import TOLERANCE, LayoutError, replace_items
from steadyload.methods.registry import make_method
from steadyload.repairing.plan import LEFT_OUT, Boxes


def best_worth(layout, *, margin, grid, most_moved, most_left=0):
    """The least worth of a plan that stands; None where none is on the grid.

    Args:
        layout: the plan.
        margin: of balance [cm], of all boxes.
        grid: distance of places along x and z [cm].
        most_moved: boxes that are moved at most.
        most_left: boxes that are left out at most.
    """
    boxes, judge = Boxes(layout), make_method(f"equilibrium:margin={margin:g}")
    count = len(layout)
    for left in range(most_left + 1):
        for moved in range(most_moved + 1):
            found = [
                worth
                for gone in combinations(range(count), left)
                for who in combinations([b for b in range(count) if b not in gone], moved)
                if (worth := _best_with(boxes, judge, set(gone), who, grid)) is not None
            ]
            if found:
                return min(found)
    return None


def _best_with(boxes, judge, gone, who, grid):
    best = None
    for places in product(*(_places(boxes, box, grid) for box in who)):
        own = boxes.planned.copy()
        own[sorted(gone)] = (0.0, 0.0, 0.0, LEFT_OUT)
        for box, place in zip(who, places, strict=True):
            own[box] = place
        kept = [b for b in range(len(own)) if b not in gone]
        worth = boxes.worth(own, kept)
        if best is not None and worth >= best:
            continue
        if _overlap([boxes.item(b, own[b]) for b in kept]):
            continue
        for turns in permutations(kept):
            again = boxes.worth(own, turns)
            if (best is None or again < best) and _loadable(boxes, judge, own, turns):
                best = again
    return best


def _places(boxes, box, grid):
    """Every other place of a box on the grid, at the height of a top or of the floor."""
    layout, found = boxes.layout, []
    heights = sorted({0.0, *layout.upper[:, 1].tolist()})
    for turn in (AS_PLANNED, TURNED):
        item = boxes.item(box, (0.0, 0.0, 0.0, turn))
        if turn == TURNED and item.size == layout.items[box].size:
            continue
        width, high, depth = item.size
        for x in np.arange(0.0, layout.pallet.width - width + TOLERANCE, grid):
            for z in np.arange(0.0, layout.pallet.depth - depth + TOLERANCE, grid):
                for y in heights:
                    place = (float(x), y, float(z), turn)
                    if y + high <= layout.pallet.height and place != tuple(boxes.planned[box]):
                        found.append(place)
    return found


def _overlap(items):
    low = np.array([item.position for item in items])
    high = low + [item.size for item in items]
    shared = np.minimum(high[:, None], high) - np.maximum(low[:, None], low)
    deep = shared.min(axis=2)
    np.fill_diagonal(deep, 0.0)
    return deep.max() > TOLERANCE


def _loadable(boxes, judge, places, turns):
    """Whether boxes stand one after the other, each let down from above."""
    items = [boxes.item(box, places[box]) for box in turns]
    low = np.array([item.position for item in items])
    high = low + [item.size for item in items]
    for k, box in enumerate(turns):
        for m in range(k):
            other = turns[m]
            shared = np.minimum(high[k], high[m]) - np.maximum(low[k], low[m])
            over = min(shared[0], shared[2]) > TOLERANCE and low[m, 1] >= high[k, 1] - TOLERANCE
            pair = [box, other]
            planned = (places[pair] == boxes.planned[pair]).all()
            if over and not (planned and other < box):
                return False
    numbers = tuple(numbered(item, k) for k, item in enumerate(items))
    try:
        return judge.judge(replace_items(boxes.layout, numbers)).stable
    except LayoutError:
        return False
