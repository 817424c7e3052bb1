"""One pass over the boxes of a plan, which searches nothing: what a repair is compared with."""

from __future__ import annotations

from collections import deque

import numpy as np

from steadyload.core.constants import AS_PLANNED, TURNED
from steadyload.layouts.model.layout import TOLERANCE, FloatArray, Item, Layout, LayoutError, Pallet
from steadyload.methods.session.session import LoadingSession
from steadyload.repairing.plan import Boxes

METHOD = "equilibrium:margin=0.5"
"""Says where a box stands: balanced even if its supports were 0.5 cm narrower."""

_WEIGHTS = np.array([1.0, 2.0, 1.0])
"""Of the distances along the axes by which places are ordered: up and down count twice."""

_PLACES = 400
"""Nearest places of a box that are looked at, by turn."""


def one_pass(plan: Layout) -> tuple[Layout, tuple[int, ...]]:
    """Load the boxes in their order, each at its place or at the nearest one where it stands.

    A box without such a place waits until others are loaded; one for which there is none then,
    either, is left out.

    Returns:
        What was loaded, and of each item its step in the plan.
    """
    boxes = Boxes(plan)
    waiting, order, passed = deque(range(len(boxes))), list[int](), 0
    with LoadingSession(plan.pallet, METHOD, timed=False) as session:
        while waiting:
            box = waiting.popleft()
            if _is_placed(session, plan.items[box]) or _is_placed_near(session, boxes, box):
                order.append(box)
                passed = 0
            elif passed < len(waiting):
                waiting.append(box)
                passed += 1
        return session.layout(plan.name), tuple(order)


def _is_placed(session: LoadingSession, item: Item) -> bool:
    try:
        return session.try_place(item).stable
    except LayoutError:  # something is there already
        return False


def _is_placed_near(session: LoadingSession, boxes: Boxes, box: int) -> bool:
    """Whether a box was placed at the nearest place where it stands."""
    planned = boxes.planned[box, :3]
    found: list[tuple[float, Item]] = []
    for turn in (AS_PLANNED, TURNED):
        item = boxes.item(box, (*planned, turn))
        places = _places(session.items, item, session.pallet)
        far = np.abs(places - planned) @ _WEIGHTS
        nearest = np.argsort(far, kind="stable")[:_PLACES]
        stands = np.flatnonzero(session.feasible(item, places[nearest]))
        if len(stands):
            first = nearest[stands[0]]
            found.append((float(far[first]), boxes.item(box, (*places[first], turn))))
    return bool(found) and _is_placed(session, min(found, key=lambda one: one[0])[1])


def _places(loaded: tuple[Item, ...], item: Item, pallet: Pallet) -> FloatArray:
    """Where an item is let down beside the sides of others or of the bin, or at its place [cm].

    Returns:
        Its lower corner, shape (K, 3).
    """
    low = np.array([one.position for one in loaded]).reshape(-1, 3)
    high = low + np.array([one.size for one in loaded]).reshape(-1, 3)
    least, most = pallet.contour
    size, axes = np.array(item.size), []
    for axis in (0, 2):
        sides = np.concatenate([low[:, axis], high[:, axis], [least[axis]]])
        along = np.unique([*sides, *(sides - size[axis]), item.position[axis]])
        inside = (along >= least[axis]) & (along + size[axis] <= most[axis] + TOLERANCE)
        axes.append(along[inside])
    x, z = (grid.ravel() for grid in np.meshgrid(*axes, indexing="ij"))
    y = np.zeros(len(x))
    for corner, end in zip(low, high, strict=True):
        below = (
            (corner[0] < x + size[0] - TOLERANCE) & (x < end[0] - TOLERANCE)
            & (corner[2] < z + size[2] - TOLERANCE) & (z < end[2] - TOLERANCE)
        )  # fmt: skip
        y[below] = np.maximum(y[below], end[1])
    fits = y + size[1] <= most[1] + TOLERANCE
    return np.column_stack([x, y, z])[fits]
