"""The kernels' part of ``steadyload warm-up``: each is called on a stack of two items."""

from __future__ import annotations

from typing import Any

import numpy as np

from steadyload.statics.kernels import loading
from steadyload.statics.kernels.balance import (
    balance_whole_group,
    first_unbalanced,
    first_unbalanced_of_many,
    joined,
)
from steadyload.statics.kernels.balance import begin as begin_held
from steadyload.statics.kernels.base_support import (
    covered,
    first_with_little_support,
    first_with_little_support_of_many,
)
from steadyload.statics.kernels.cells import items_near
from steadyload.statics.kernels.constants import FLOOR
from steadyload.statics.kernels.contacts import contacts_of
from steadyload.statics.kernels.free_places import free_places
from steadyload.statics.kernels.growing import BOX, first_arrays, put, take_off
from steadyload.statics.kernels.least_energy import Columns, Factors, solved
from steadyload.statics.kernels.least_squares import nonnegative_least_squares
from steadyload.statics.kernels.local_balance import closest_to_balance
from steadyload.statics.kernels.margin import margin_as_planned
from steadyload.statics.kernels.placing import SUPPORTED, place, stand
from steadyload.statics.kernels.sme import first_unsupported, first_unsupported_of_many
from steadyload.statics.kernels.timed_balance import (
    begin,
    first_moved,
    first_moved_of,
    first_moved_of_many,
    moved,
    moving_group,
)


def warm_up() -> None:
    """Compile the kernels, or load the compiled code."""
    lower = _fixed([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    upper = _fixed([[1.0, 1.0, 1.0], [1.0, 2.0, 1.0]])
    weights, offsets = _fixed([1.0, 1.0]), _fixed(np.zeros((2, 3)))
    floor = _fixed([-np.inf, -np.inf, np.inf, np.inf, 0.0])
    floors, starts = _fixed(floor[None]), np.array([0, 2], dtype=np.int64)
    starts.setflags(write=False)
    covered(0.0, 0.0, 1.0, 1.0, np.zeros((1, 6))[:, 2:])
    first_with_little_support(lower, upper, floor, 1.0)
    first_with_little_support_of_many(lower, upper, floors, starts, 1.0)
    for one, many, how in (
        (first_unsupported, first_unsupported_of_many, ()),
        (first_unbalanced, first_unbalanced_of_many, (0.0,)),
    ):
        one(lower, upper, weights, offsets, floor, *how)
        many(lower, upper, weights, offsets, floors, starts, *how)
    margin_as_planned(lower, upper, weights, offsets, floor, 1.0)
    held = begin_held(lower, upper, weights, offsets, floor, 0.0)
    balance_whole_group(1, held)
    joined(1, held.contacts)
    used, patches, middles = np.array([[0, 0, FLOOR]]), np.ones((1, 4)), 0.5 * (lower + upper)
    closest_to_balance(np.arange(1), used, patches, middles, weights, lower, upper, 0.0)
    arrays, motion = (lower, upper, weights, offsets), (0.5, 980.0, 0.3, 10.0, 10.0)
    loading = begin(*arrays, floor)
    first_moved(loading, 0, 2, *motion)
    moving_group(1, loading)
    loading.moves[:] = True  # only what moves has a motion
    moved(1, np.arange(2), loading, *motion)
    first_moved_of(*arrays, floor, np.inf, *motion)
    first_moved_of_many(*arrays, floors, starts, np.inf, *motion)
    nonnegative_least_squares(np.eye(2), np.ones(2))
    _hold_one()
    warm_up_searches()


def warm_up_searches() -> None:
    """Compile what a search for another plan calls, or load the compiled code."""
    limits, half = np.array([0.0, 0.0, 0.0, 1.0, 3.0, 1.0, 0.0, 0.0, 1.0, 1.0]), np.full(3, 0.5)
    ways, lower = np.array([np.inf, -np.inf, np.inf]), np.zeros((2, 3))
    contacts_of(_fixed(lower), _fixed(lower + 1.0), _fixed([-np.inf, -np.inf, np.inf, np.inf, 0.0]))
    free_places(
        lower, lower + 1.0, lower + 0.5, np.ones(3), half, half, 0.5, limits, np.array([2.0]),
        ways, 4,
    )  # fmt: skip
    _load_two(limits, ways)
    _place_two()


def _hold_one() -> None:
    """One item, on a corner below its centre."""
    of_box = np.arange(3)
    factors = Factors(
        np.array([0, 2, 3, 3]), np.array([1, 2, 2]), np.zeros(3), np.full(3, 1e-12)
    )  # fmt: skip
    columns = Columns(np.array([0, 3]), of_box, np.array([1.0, 0.0, 0.0]))
    presses, held = np.ones(1, dtype=np.bool_), np.zeros(1, dtype=np.bool_)
    right, multipliers, corners = np.array([1.0, 0.0, 0.0]), np.zeros(3), np.zeros(1, dtype=int)
    solved(factors, columns, corners, of_box, right, presses, held, multipliers, np.empty(1))


def _place_two() -> None:
    """One item on another, on a layout that grows."""
    arrays = first_arrays((0.0, 0.0, 0.0), (9.0, 9.0, 9.0), (0.0, 0.0, 9.0, 9.0, 1.0))
    kept, positions, endings = tuple(arrays), np.zeros((1, 3)), np.zeros(1, dtype=np.int8)
    arrays.limits[BOX:] = (0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    put(kept)
    arrays.limits[BOX + 1] = 1.0
    place(kept, SUPPORTED, 1.0)
    stand(kept, SUPPORTED, 1.0, positions, endings, 0)
    take_off(kept, 1)
    low, high = arrays.vectors[0], arrays.vectors[1]
    items_near(low, high, arrays.cells, 0, arrays.limits, low[0], high[0], 1.0)


def _load_two(limits: Any, ways: Any) -> None:
    """One box on another, and free places of it."""
    arrays = first_arrays((0.0, 0.0, 0.0), (9.0, 9.0, 9.0), (0.0, 0.0, 9.0, 9.0, 1.0))
    places, without = np.zeros((2, 4)), np.zeros(2, dtype=np.bool_)
    places[1, 1] = 1.0
    boxes = tuple(
        loading.Boxes(np.ones((2, 2, 3)), np.zeros((2, 2, 3)), np.ones(2), places, np.ones(2))
    )
    kept, turns, refused = tuple(arrays), tuple(loading.no_turns(2)), np.empty((0, 5))
    loading.begin(kept, boxes, turns, places, np.zeros(2), refused, 2)
    loading.load(kept, boxes, turns, places, np.zeros(2), refused, True, True)
    loading.said(turns, 0, 0, True, True)
    found, _ = loading.places_among(boxes, places, without, 1, 0.5, limits, ways, 1, 4)
    found_at = np.zeros(1, dtype=np.int64)
    loading.first_standing(kept, boxes, 1, found, 0.5, refused, found_at)
    loading.cost(boxes, places)


def _fixed(values: Any) -> Any:
    """An array as a layout has it: read-only and C-contiguous."""
    array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array
