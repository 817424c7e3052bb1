"""The margin of balance of a whole loading, in little more than one pass of equilibrium."""

from __future__ import annotations

from typing import Any

from steadyload.statics.kernels.balance import balance_after, begin, replace_presses
from steadyload.statics.kernels.compiled import compiled
from steadyload.statics.kernels.constants import BALANCED
from steadyload.statics.kernels.contacts import draw_in

FINEST = 1e-3
"""A margin is known so closely [cm]."""


@compiled
def margin_as_planned(
    lower: Any, upper: Any, weights: Any, offsets: Any, floor: Any, most: float
) -> Any:
    """By how much all contact patches may be drawn in with every step still balanced.

    Each step is tried at the least margin of the steps before it, whose forces hold at every
    smaller margin, too; only a step that fails there is halved.

    Args:
        lower: see :mod:`steadyload.statics.kernels`.
        upper: likewise.
        weights: likewise.
        offsets: likewise.
        floor: likewise, shape (5,).
        most: the largest margin that is looked for [cm].

    Returns:
        How it ended (``BALANCED``, or how the first step ended that has no balance at all), the
        margin, the step at which it is smallest and the item that is the first to lose its balance
        there, -1 both where the margin is ``most``; the failing step and item where none balances.
    """
    held = begin(lower, upper, weights, offsets, floor, 0.0)
    contacts, meets, centres, moves = held.contacts, held.meets, held.centres, held.moves
    presses, changed = held.presses, held.changed
    whole = contacts.patches.copy()
    margin, at, first = most, -1, -1
    _redraw(contacts.patches, whole, margin)
    for step in range(len(lower)):
        if contacts.on_floor[step]:
            across = 0.5 * (upper[step, 0] - lower[step, 0]) - abs(offsets[step, 0])
            along = 0.5 * (upper[step, 2] - lower[step, 2]) - abs(offsets[step, 2])
            own = max(min(across, along), 0.0)
            if own < margin:
                margin, at, first = own, step, step
                _redraw(contacts.patches, whole, margin)
        ended, item, items = balance_after(
            step, contacts, meets, centres, weights, lower, upper, moves, presses, changed, False
        )
        if ended != BALANCED:
            low, high, first, at = 0.0, margin, item, step
            margin = 0.0
            while True:
                _redraw(contacts.patches, whole, margin)
                ended, item, items = balance_after(
                    step, contacts, meets, centres, weights, lower, upper, moves, presses, changed,
                    False,
                )  # fmt: skip
                if ended == BALANCED:
                    if high - margin <= FINEST:
                        break
                    low = margin
                elif margin == 0.0:
                    return ended, 0.0, step, item
                else:
                    high, first = margin, item
                # The last look is at a margin that holds, whose forces are kept.
                margin = 0.5 * (low + high) if high - low > FINEST else low
        replace_presses(items, step, contacts, presses, changed)
    return BALANCED, margin, at, first


@compiled
def _redraw(patches: Any, whole: Any, margin: float) -> None:
    patches[:] = whole
    draw_in(patches, margin)
