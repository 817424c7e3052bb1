"""The contract of loaders: the verdict on each placement, while a layout grows."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from steadyload.layouts.model.growing import GrowingLayout
from steadyload.layouts.model.layout import FloatArray, Item
from steadyload.methods.contract.stopwatch import Stopwatch
from steadyload.methods.contract.verdict import Finding


class Loader(ABC):
    """Judges the items of a growing layout as they are placed, each once (:meth:`.Method.begin`).

    Only the last placement may have failed; whoever calls takes that item off again before the
    next. A loader's finding on a placement is that of :meth:`.Method.judge` on the layout by then.
    A loader implements :meth:`place`, or :meth:`load` where it judges an item as it puts it on.

    Args:
        layout: what is loaded; it is changed by whoever calls.
    """

    def __init__(self, layout: GrowingLayout) -> None:
        self.layout = layout

    def load(self, item: Item, watch: Stopwatch) -> Finding:
        """Put the next item on the layout and judge that; one that fails may be left there.

        Args:
            item: its sequence number is the number of items.
            watch: of the judgement.

        Raises:
            LayoutError: the item cannot be there; nothing has changed.
            RefusedError: the method does not apply.
        """
        self.layout.put(item)
        return self.place(watch)

    def place(self, watch: Stopwatch) -> Finding:
        """Judge the placement of the item that was put on the layout last.

        All items before it stand. May raise :class:`RefusedError`.
        """
        raise NotImplementedError

    def feasible(self, item: Item, positions: FloatArray) -> NDArray[np.bool_] | None:
        """Whether the next item would stand on each of some places, as :meth:`load` would say.

        Nothing changes by it.

        Args:
            item: its own position does not matter.
            positions: lower corners [cm], shape (K, 3), C-contiguous; any numbers.

        Returns:
            Shape (K,), False also where the item cannot be; None, the default, where nothing is
            faster than trying each.
        """
        return None

    @abstractmethod
    def go_back(self, count: int) -> None:
        """Forget all items but the first ``count``, also those without a finding."""

    @abstractmethod
    def fork(self, layout: GrowingLayout) -> Loader:
        """A loader in the same state, for an independent copy of the layout."""

    def close(self) -> None:
        """Release resources of engines. Closing twice is allowed."""
