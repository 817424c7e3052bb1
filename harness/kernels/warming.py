"""The kernels' part of ``steadyload warm-up``: each is called on a stack of two items."""

from __future__ import annotations

from typing import Any

import numpy as np

from steadyload.kernels.balance import first_unbalanced, first_unbalanced_of_many
from steadyload.kernels.base_support import (
    covered,
    first_with_little_support,
    first_with_little_support_of_many,
)
from steadyload.kernels.contacts import contacts_of
from steadyload.kernels.sme import first_unsupported, first_unsupported_of_many


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
    for one, many in (
        (first_unsupported, first_unsupported_of_many),
        (first_unbalanced, first_unbalanced_of_many),
    ):
        one(lower, upper, weights, offsets, floor)
        many(lower, upper, weights, offsets, floors, starts)


def _fixed(values: Any) -> Any:
    """An array as a layout has it: read-only and C-contiguous."""
    array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array
