"""The kernels' part of ``steadyload warm-up``: each is called on a stack of two items."""

from __future__ import annotations

from typing import Any

import numpy as np

from steadyload.kernels.contacts import contacts_of


def warm_up() -> None:
    """Compile the kernels, or load the compiled code."""
    lower = _fixed([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    upper = _fixed([[1.0, 1.0, 1.0], [1.0, 2.0, 1.0]])
    contacts_of(lower, upper, _fixed([-np.inf, -np.inf, np.inf, np.inf, 0.0]))


def _fixed(values: Any) -> Any:
    """An array as a layout has it: read-only and C-contiguous."""
    array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array
