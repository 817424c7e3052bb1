"""The authors' force-based rule; the exact solution is :mod:`steadyload.methods.equilibrium`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from steadyload import kernels
from steadyload.kernels.constants import ROUNDING
from steadyload.layouts.batch import LayoutBatch
from steadyload.layouts.contacts import FLOOR, Supports
from steadyload.layouts.contacts import VERSION as CONTACTS
from steadyload.layouts.floor import INFINITE
from steadyload.layouts.growing import GrowingLayout
from steadyload.layouts.model import Arrangement, Layout
from steadyload.methods.convex_hull import Point, strictly_inside_hull
from steadyload.methods.method import (
    STABLE,
    BatchVerdicts,
    Finding,
    Loader,
    Method,
    Stopwatch,
    Trait,
)
from steadyload.methods.spec import NoParameters
from steadyload.methods.warming import judge_one_item


class StaticMechanicalEquilibrium(Method):
    """SME: static mechanical equilibrium after Ramos et al. 2016, as the authors compute it.

    At every step the new item, and then everything below it, must be supported: the weighted mean
    of an item's centre of mass and those of the items directly on top of it must lie in the top
    rectangle of one item directly below (edges included), or strictly inside the convex hull of all
    its contact rectangles. Weights are not shared between supporters and nothing from further up
    counts: a rule of thumb, not the exact equilibrium.
    """

    title = "SME"
    Parameters = NoParameters
    built_on: ClassVar[Mapping[str, int]] = {"contacts": CONTACTS}
    packages = ("numba", "numpy")

    @property
    def traits(self) -> frozenset[Trait]:
        """See :attr:`Method.traits`."""
        return frozenset((Trait.STEPWISE, Trait.CENTRES_OF_MASS))

    def prepare(self, item_count: int = 0) -> None:
        """See :meth:`Method.prepare`: compile."""
        judge_one_item(self)

    def _judge(self, layout: Layout, watch: Stopwatch) -> Finding:
        step, culprit, carried = kernels.sme.first_unsupported(
            layout.lower, layout.upper, layout.weights, layout.mass_offsets, layout.floor.corners
        )
        return STABLE if step == len(layout) else _finding(step, culprit, carried=carried)

    def evaluate(self, batch: LayoutBatch) -> BatchVerdicts:
        """See :meth:`Method.evaluate`."""
        return BatchVerdicts.of_steps(
            batch,
            kernels.sme.first_unsupported_of_many(
                batch.lower, batch.upper, batch.weights, batch.mass_offsets, batch.floors,
                batch.starts,
            ),
        )  # fmt: skip

    def begin(self, layout: GrowingLayout) -> Loader:
        """A loader that checks the new item and the items that carry it."""
        return _SmeLoader(layout)


class _SmeLoader(Loader):
    def __init__(self, layout: GrowingLayout) -> None:
        super().__init__(layout)
        self._scene = _Scene(layout.supports)

    def place(self, watch: Stopwatch) -> Finding:
        step = len(self.layout) - 1
        self._scene.add(self.layout)
        culprit = self._scene.unsupported_at(step)
        return STABLE if culprit is None else self._scene.finding(step, culprit)

    def go_back(self, count: int) -> None:
        self._scene.cut(count)

    def fork(self, layout: GrowingLayout) -> _SmeLoader:
        other = _SmeLoader(layout)
        other._scene.add(layout)
        return other


def _finding(step: int, culprit: int, *, carried: bool) -> Finding:
    lies = "the resultant of its load lies outside its support"
    return Finding(step, culprit, reason=lies if carried else "nothing supports it")


class _Scene:
    """A layout as lists in the plane (x, z): faster than arrays for a few items a step."""

    def __init__(self, supports: Supports) -> None:
        self._supports = supports
        self._floor = INFINITE
        self._weights: list[float] = []
        self._centres: list[Point] = []
        self._low: list[Point] = []
        self._high: list[Point] = []

    def add(self, layout: Arrangement) -> None:
        """Take in the items of a layout that are not there yet."""
        new = slice(len(self._weights), None)
        lower, upper = layout.lower[new], layout.upper[new]
        centres = 0.5 * (lower + upper) + layout.mass_offsets[new]
        self._floor = layout.floor
        self._weights += layout.weights[new].tolist()
        self._centres += [(x, z) for x, _, z in centres.tolist()]
        self._low += [(x, z) for x, _, z in lower.tolist()]
        self._high += [(x, z) for x, _, z in upper.tolist()]

    def cut(self, count: int) -> None:
        """Forget all items but the first ``count``."""
        for values in (self._weights, self._centres, self._low, self._high):
            del values[count:]

    def unsupported_at(self, step: int) -> int | None:
        """The first item at or below item ``step`` that is not supported, or None.

        All items before it are placed and were supported. So only it and what carries it need be
        asked: further down every load is the same as at the last check.
        """
        carriers = [item for item in self._supports.carriers(step) if item < step]
        for item in (step, *reversed(carriers)):
            if not self._supports.on_floor[item] and not self._supported(item, step):
                return item
        return None

    def finding(self, step: int, culprit: int) -> Finding:
        """Finding on an item that is not supported."""
        return _finding(step, culprit, carried=bool(self._supports.below[culprit]))

    def _top(self, carrier: int) -> tuple[Point, Point]:
        """Corners of the top face of an item, or of the floor."""
        if carrier == FLOOR:
            return self._floor.low, self._floor.high
        return self._low[carrier], self._high[carrier]

    def _supported(self, item: int, step: int) -> bool:
        weight = self._weights[item]
        x, z = (weight * c for c in self._centres[item])
        for other in self._supports.above[item]:
            if other <= step:
                weight += self._weights[other]
                x += self._weights[other] * self._centres[other][0]
                z += self._weights[other] * self._centres[other][1]
        x, z = x / weight, z / weight
        patches = [p for p in self._supports.below[item] if p.below <= step]
        for patch in patches:
            (x0, z0), (x1, z1) = self._top(patch.below)
            if x0 - ROUNDING <= x <= x1 + ROUNDING and z0 - ROUNDING <= z <= z1 + ROUNDING:
                return True
        corners = []
        for _, _, x0, z0, x1, z1 in patches:
            corners += [(x0, z0), (x0, z1), (x1, z0), (x1, z1)]
        return strictly_inside_hull((x, z), corners, ROUNDING)
