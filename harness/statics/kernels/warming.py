"""The kernels' part of ``steadyload warm-up``: each is called on a stack of two items."""

from __future__ import annotations

from typing import Any

import numpy as np

from steadyload.statics.kernels.balance import first_unbalanced, first_unbalanced_of_many
from steadyload.statics.kernels.base_support import (
    covered,
    first_with_little_support,
    first_with_little_support_of_many,
)
from steadyload.statics.kernels.cells import items_near
from steadyload.statics.kernels.contacts import contacts_of
from steadyload.statics.kernels.growing import BOX, first_arrays, put, take_off
from steadyload.statics.kernels.least_energy import Columns, Factors, solved
from steadyload.statics.kernels.least_squares import nonnegative_least_squares
from steadyload.statics.kernels.placing import (
    place_balanced,
    place_sme,
    place_supported,
    stands_balanced,
    stands_sme,
    stands_supported,
)
from steadyload.statics.kernels.sme import first_unsupported, first_unsupported_of_many
from steadyload.statics.kernels.timed_balance import (
    begin,
    first_moved,
    first_moved_of,
    first_moved_of_many,
)


def warm_up() -> None:
    """Compile the kernels, or load the compiled code."""
    lower = _fixed([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    upper = _fixed([[1.0, 1.0, 1.0], [1.0, 2.0, 1.0]])
    weights, offsets = _fixed([1.0, 1.0]), _fixed(np.zeros((2, 3)))
    floor = _fixed([-np.inf, -np.inf, np.inf, np.inf, 0.0])
    floors, starts = _fixed(floor[None]), np.array([0, 2], dtype=np.int64)
    starts.setflags(write=False)
    contacts_of(lower, upper, floor)
    covered(0.0, 0.0, 1.0, 1.0, np.zeros((1, 6))[:, 2:])
    first_with_little_support(lower, upper, floor, 1.0)
    first_with_little_support_of_many(lower, upper, floors, starts, 1.0)
    for one, many, how in (
        (first_unsupported, first_unsupported_of_many, ()),
        (first_unbalanced, first_unbalanced_of_many, (0.0,)),
    ):
        one(lower, upper, weights, offsets, floor, *how)
        many(lower, upper, weights, offsets, floors, starts, *how)
    arrays, motion = (lower, upper, weights, offsets), (0.5, 980.0, 0.3, 10.0, 10.0)
    first_moved(begin(*arrays, floor), 0, 2, *motion)
    first_moved_of(*arrays, floor, *motion)
    first_moved_of_many(*arrays, floors, starts, *motion)
    nonnegative_least_squares(np.eye(2), np.ones(2))
    _place_two()
    _hold_one()


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
    """One item on another, on a layout that grows, by every rule."""
    positions, endings = np.zeros((1, 3)), np.zeros(1, dtype=np.int8)
    for place, many, how in (
        (put, None, ()),
        (place_supported, stands_supported, (1.0,)),
        (place_sme, stands_sme, ()),
        (place_balanced, stands_balanced, ()),
    ):
        arrays = first_arrays((0.0, 0.0, 0.0), (9.0, 9.0, 9.0), (0.0, 0.0, 9.0, 9.0, 1.0))
        for y in (0.0, 1.0):
            arrays[-1][BOX:] = (0.0, y, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0)
            place(*arrays, *how)
        if many is not None:
            many(*arrays, *how, positions, endings, 0)
        take_off(*arrays, 0)
    vectors, cells, limits = arrays[0], arrays[8], arrays[-1]
    items_near(vectors[0], vectors[1], cells, 0, limits, vectors[0, 0], vectors[1, 0], 1.0)


def _fixed(values: Any) -> Any:
    """An array as a layout has it: read-only and C-contiguous."""
    array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array
