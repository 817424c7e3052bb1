"""Reasons for which plans fail at a step, by the contacts of the box that is placed then."""

from __future__ import annotations

from enum import StrEnum

from steadyload.core.constants import FAILS
from steadyload.layouts.model.footing import gaps, largest
from steadyload.layouts.model.layout import Layout
from steadyload.statics.balance import solve


class Cause(StrEnum):
    """Why a load fails when a box is placed; the first that applies.

    ``nothing``: no box and no floor carries it. ``out``: it is out of balance on what carries it,
    were that firm. ``below``: what carries it could, and is out of balance with it. ``balanced``:
    vertical contact forces balance everything, and something moves all the same.
    """

    NOTHING = "nothing under it"
    OUT = "centre of mass out over its supports"
    BELOW = "something below gives way"
    BALANCED = "in balance"


def cause_of(layout: Layout, step: int) -> Cause:
    """The cause of a failure."""
    loaded = layout.first(step + 1)
    supports = loaded.supports
    if supports.on_floor[step]:
        return Cause.BALANCED
    below = supports.below[step]
    if not below:
        return Cause.NOTHING
    if solve(loaded, [step], below).ended == FAILS:
        return Cause.OUT
    group = supports.joined(step, floor=False)
    patches = [patch for item in group for patch in supports.below[item]]
    if solve(loaded, group, patches).ended == FAILS:
        return Cause.BELOW
    return Cause.BALANCED


def widest_gap(layout: Layout) -> float:
    """How far the box highest above what lies below it hangs in the air [cm]; 0 where none does."""
    gap = largest(gaps(layout))
    return 0.0 if gap is None else gap.height
