"""Many layouts as a few arrays: what compiled methods judge without an object an item."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steadyload.layouts.model import FloatArray, Layout


@dataclass(frozen=True, eq=False)
class LayoutBatch:
    """Layouts one after the other, as read-only arrays.

    Attributes:
        starts: the items of layout k are ``starts[k]`` to ``starts[k + 1]``, shape (L + 1,).
        lower, upper: corners of all items [cm], shape (N, 3).
        weights: [kg], shape (N,). mass_offsets: [cm], shape (N, 3).
        floors: of every layout: x0, z0, x1, z1 of what carries, infinite for a plane, and its
            height above the ground, 0 for a plane [cm], shape (L, 5).
    """

    starts: NDArray[np.int64]
    lower: FloatArray
    upper: FloatArray
    weights: FloatArray
    mass_offsets: FloatArray
    floors: FloatArray

    def __post_init__(self) -> None:
        for array in vars(self).values():
            array.setflags(write=False)

    @classmethod
    def of(cls, layouts: Iterable[Layout]) -> LayoutBatch:
        """The batch of some layouts; there may be none."""
        each = list(layouts)
        empty = np.empty((0, 3))
        return cls(
            np.cumsum([0, *map(len, each)], dtype=np.int64),
            np.concatenate([empty, *(layout.lower for layout in each)]),
            np.concatenate([empty, *(layout.upper for layout in each)]),
            np.concatenate([empty[:, 0], *(layout.weights for layout in each)]),
            np.concatenate([empty, *(layout.mass_offsets for layout in each)]),
            np.array([layout.floor.corners for layout in each]).reshape(-1, 5),
        )

    def __len__(self) -> int:
        """Number of layouts."""
        return len(self.floors)

    @property
    def item_counts(self) -> NDArray[np.int64]:
        """Number of items of every layout, shape (L,)."""
        return np.diff(self.starts)
