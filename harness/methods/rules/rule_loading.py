"""Loaders of the static rules: an item is put on and judged in one call of the C library."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from steadyload.core.constants import BALANCED, FAILS, STANDS, UNRESOLVED
from steadyload.core.library import Finding as Found
from steadyload.layouts.model.growing import GrowingLayout
from steadyload.layouts.model.layout import FloatArray, Item
from steadyload.methods.contract.method import STABLE, Finding, Loader, Stopwatch


class RuleLoader(Loader):
    """A loader by a rule of the C library, which keeps all that there is to keep.

    Args:
        layout: what is loaded.
        rule: see :meth:`GrowingLayout.try_put`.
        finding: the finding on an item that does not stand.
        alpha: as ``rule``.
    """

    def __init__(
        self,
        layout: GrowingLayout,
        rule: int,
        finding: Callable[[Found], Finding],
        alpha: float = 0.0,
    ) -> None:
        super().__init__(layout)
        self._rule, self._alpha, self._finding = rule, alpha, finding

    def load(self, item: Item, watch: Stopwatch) -> Finding:
        """See :meth:`Loader.load`."""
        found = self.layout.try_put(item, self._rule, self._alpha)
        return STABLE if found.ended == STANDS else self._finding(found)

    def feasible(self, item: Item, positions: FloatArray) -> NDArray[np.bool_] | None:
        """See :meth:`Loader.feasible`."""
        endings = self.layout.endings(item, positions, self._rule, self._alpha)
        found: NDArray[np.bool_] = endings == STANDS
        return found

    def go_back(self, count: int) -> None:
        """Nothing is kept but what the layout has."""

    def fork(self, layout: GrowingLayout) -> RuleLoader:
        """See :meth:`Loader.fork`."""
        return RuleLoader(layout, self._rule, self._finding, self._alpha)


class BalancedLoader(Loader):
    """A loader by the balance of vertical forces, which the C library keeps.

    Where rounding hides whether items balance, or where it takes more than that to fail, the whole
    layout is judged, and again at every placement on top of that: no forces are known then.

    Args:
        layout: what is loaded.
        whole: the finding on all that is loaded.
        unbalanced: of a step and the item that is out of balance; None where such a step may stand,
            as ``whole`` says.
        margin: by which contact patches are drawn in on every side [cm].
    """

    def __init__(
        self,
        layout: GrowingLayout,
        whole: Callable[[GrowingLayout, Stopwatch], Finding],
        unbalanced: Callable[[int, int], Finding] | None = None,
        margin: float = 0.0,
    ) -> None:
        super().__init__(layout)
        self._whole, self._unbalanced, self._margin = whole, unbalanced, margin
        self._known: int | None = None
        """So many items have forces that are known; None for all."""

    def load(self, item: Item, watch: Stopwatch) -> Finding:
        """See :meth:`Loader.load`."""
        if self._known is None:
            found = self.layout.try_put(item, BALANCED, self._margin)
            if found.ended == STANDS:
                return STABLE
            if found.ended != UNRESOLVED and self._unbalanced is not None:
                return self._unbalanced(found.step, found.item)
            self._known = len(self.layout)
        self.layout.put(item)
        return self._whole(self.layout, watch)

    def feasible(self, item: Item, positions: FloatArray) -> NDArray[np.bool_] | None:
        """See :meth:`Loader.feasible`."""
        if self._known is not None:
            return None
        endings = self.layout.endings(item, positions, BALANCED, self._margin)
        open_ones = (UNRESOLVED,) if self._unbalanced is not None else (UNRESOLVED, FAILS)
        return None if np.isin(endings, open_ones).any() else endings == STANDS

    def go_back(self, count: int) -> None:
        """See :meth:`Loader.go_back`."""
        if self._known is not None and count <= self._known:
            self._known = None

    def fork(self, layout: GrowingLayout) -> BalancedLoader:
        """See :meth:`Loader.fork`."""
        other = BalancedLoader(layout, self._whole, self._unbalanced, self._margin)
        other._known = self._known
        return other
