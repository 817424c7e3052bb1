"""Where a plan loses its balance: the step, the box that gives way, and how far past which edge."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from steadyload.core.constants import BALANCED, EDGE, STANDS, UNRESOLVED
from steadyload.layouts.model.contacts import Patch
from steadyload.layouts.model.footing import Edge, Footing, edge_of, footing
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.naming import label_in
from steadyload.statics.balance import Solution, solve
from steadyload.statics.resolution import unresolved

_HALVINGS = 20
"""Of the length of a group, so that a metre is known to a micrometre."""


@dataclass(frozen=True, slots=True)
class BalanceLost:
    """The first step of a plan at which contact forces do not balance every box.

    Attributes:
        step: after which they do not, counted from 0.
        item: number of the box that gives way: the one that would start to move fastest.
        footing: of that box, under its own weight alone.
        loaded: other boxes stand on it by then.
        edge: past which its weight acts, together with that of what stands on it; None where its
            support has a hole or a notch there, where nothing is under it, and where no wider
            support of this box alone would balance the plan.
        beyond: how far outside its support this weight acts [cm]: the support would have to be
            wider by so much; None where no wider support of this box alone is enough.
    """

    step: int
    item: int
    footing: Footing
    loaded: bool = False
    edge: Edge | None = None
    beyond: float | None = None

    def sentence(self, layout: Layout, frame: Frame | None = None) -> str:
        """Why the box gives way: "the centre of mass of box 7 lies 5.0 cm past the edge of ...".

        Args:
            layout: the plan.
            frame: axes and unit of the sentence; None for ours.
        """
        box, frame = label_in(layout.items, self.item), frame or Frame()
        if self.footing.gap is not None:
            said = self.footing.gap.sentence(layout, frame)
        elif not self.loaded and self.footing.edge is not None:
            said = self.footing.sentence(layout, frame)
        elif self.beyond is None:
            said = f"contact forces do not balance {box}"
        else:
            weight = f"the weight of {box}" + " and of what stands on it" * self.loaded
            where = f"{frame.length(self.beyond, finely=True)} outside its support"
            if self.edge is not None:
                where = self.edge.sentence(layout, frame)
            said = f"{weight} acts {where}; {self.footing.share}"
        if self.step == self.item:
            return said
        return f"{said}; it gives way when {label_in(layout.items, self.step)} is placed"


def balance_lost(layout: Layout) -> BalanceLost | None:
    """The first loss of balance of a plan; None where contact forces balance every box.

    Forces are vertical and push; every box is at its planned place.

    Args:
        layout: the plan, in the order of loading.

    Raises:
        UnresolvedError: rounding hides whether forces balance, since weights differ too much.
    """
    ended, step, item, _ = layout.given.judge(BALANCED, 0.0)
    if ended == STANDS:
        return None
    placed = layout.first(step + 1)
    supports = placed.supports
    group = supports.joined(step, floor=False)
    if ended == UNRESOLVED:
        raise unresolved(layout.weights[group])
    found = BalanceLost(step, item, footing(placed, item), bool(supports.above[item]))
    patches = [patch for one in group for patch in supports.below[one]]
    if not supports.below[found.item]:
        return found
    return _with_distance(found, placed, group, patches)


def _with_distance(
    lost: BalanceLost, layout: Layout, group: Sequence[int], patches: Sequence[Patch]
) -> BalanceLost:
    """The same with how much wider the support of the box would have to be, and where."""

    def widened(by: float) -> Solution:
        return solve(layout, group, [_wider(p, by) if p.above == lost.item else p for p in patches])

    low = 0.0
    high = float(np.ptp((layout.lower[group], layout.upper[group]), axis=(0, 1))[::2].max())
    nearest = widened(high)
    if nearest.ended != STANDS:
        return lost
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        found = widened(middle)
        if found.ended == STANDS:
            high, nearest = middle, found
        else:
            low = middle
    own = [k for k, patch in enumerate(patches) if patch.above == lost.item]
    forces = nearest.forces[own]
    corners = np.array([_corners(_wider(patches[k], high)) for k in own])
    x, z = (forces[..., None] * corners).sum(axis=(0, 1)) / forces.sum()
    edge = edge_of([patches[k] for k in own], float(x), float(z))
    if edge is not None and not edge.beyond:
        edge = replace(edge, beyond=high)  # less than what counts as on the edge, and yet past it
    return BalanceLost(lost.step, lost.item, lost.footing, lost.loaded, edge, high)


def _wider(patch: Patch, by: float) -> Patch:
    x0, z0, x1, z1 = patch.x0 - by, patch.z0 - by, patch.x1 + by, patch.z1 + by
    return Patch(patch.below, patch.above, x0, z0, x1, z1)


def _corners(patch: Patch) -> list[tuple[float, float]]:
    """In the order of the forces of a :class:`Solution`, as they were solved for."""
    x0, z0, x1, z1 = patch.x0 - EDGE, patch.z0 - EDGE, patch.x1 + EDGE, patch.z1 + EDGE
    return [(x0, z0), (x0, z1), (x1, z0), (x1, z1)]
