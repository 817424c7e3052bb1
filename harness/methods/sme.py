"""The authors' force-based rule; the exact question is :mod:`harness.methods.equilibrium`."""

from __future__ import annotations

from harness.layouts.contacts import Contacts, find_contacts
from harness.layouts.model import Layout
from harness.methods.method import STABLE, Finding, Method, Stopwatch, Trait
from harness.methods.plane import Point, strictly_inside_hull
from harness.methods.spec import NoParameters

_ROUNDING = 1e-9


class StaticMechanicalEquilibrium(Method):
    """SME: static mechanical equilibrium after Ramos et al. 2016, as the authors compute it.

    At every step the new item, and then everything below it, must be supported: the weighted mean
    of an item's centre of mass and those of the items directly on top of it must lie in the top
    rectangle of one item directly below (edges included), or strictly inside the convex hull of all
    its contact rectangles. Weights are not shared between supporters and nothing from further up
    counts: a rule of thumb, not the exact equilibrium.
    """

    Parameters = NoParameters

    @property
    def traits(self) -> frozenset[Trait]:
        """See :attr:`Method.traits`."""
        return frozenset((Trait.STEPWISE, Trait.CENTRES_OF_MASS))

    def _judge(self, layout: Layout, watch: Stopwatch) -> Finding:
        scene = _Scene(layout)
        for step in range(len(layout)):
            culprit = scene.unsupported_at(step)
            if culprit is not None:
                return Finding(
                    failing_step=step,
                    moved_item=culprit,
                    reason="the resultant of its load lies outside its support"
                    if scene.below[culprit]
                    else "nothing supports it",
                )
        return STABLE


class _Scene:
    """A layout as nested lists in the plane (x, z): faster than arrays for a few items a step."""

    def __init__(self, layout: Layout) -> None:
        contacts = find_contacts(layout)
        count = range(len(layout))
        carries = contacts.carries.tolist()
        self.on_floor: list[bool] = contacts.on_floor.tolist()
        self.below = [[i for i in count if carries[i][j]] for j in count]
        self.above = [[j for j in count if carries[i][j]] for i in count]
        centres = 0.5 * (layout.lower + layout.upper) + layout.mass_offsets
        self.weights: list[float] = layout.weights.tolist()
        self.centres: list[Point] = [(x, z) for x, _, z in centres.tolist()]
        self.low: list[Point] = [(x, z) for x, _, z in layout.lower.tolist()]
        self.high: list[Point] = [(x, z) for x, _, z in layout.upper.tolist()]
        self.contacts: Contacts = contacts

    def unsupported_at(self, step: int) -> int | None:
        """The first item at or below item ``step`` that is not supported, or None."""
        todo, seen = [step], {step}
        while todo:
            item = todo.pop()
            if self.on_floor[item]:
                continue
            supporters = [i for i in self.below[item] if i <= step]
            if not self._supported(item, step, supporters):
                return item
            todo.extend(i for i in supporters if i not in seen)
            seen.update(supporters)
        return None

    def _supported(self, item: int, step: int, supporters: list[int]) -> bool:
        weight = self.weights[item]
        x, z = (weight * c for c in self.centres[item])
        for other in self.above[item]:
            if other <= step:
                weight += self.weights[other]
                x += self.weights[other] * self.centres[other][0]
                z += self.weights[other] * self.centres[other][1]
        x, z = x / weight, z / weight
        for i in supporters:
            (x0, z0), (x1, z1) = self.low[i], self.high[i]
            if x0 - _ROUNDING <= x <= x1 + _ROUNDING and z0 - _ROUNDING <= z <= z1 + _ROUNDING:
                return True
        corners = []
        for i in supporters:
            (x0, z0) = self.contacts.corners_low[i, item].tolist()
            (x1, z1) = self.contacts.corners_high[i, item].tolist()
            corners += [(x0, z0), (x0, z1), (x1, z0), (x1, z1)]
        return strictly_inside_hull((x, z), corners, _ROUNDING)
