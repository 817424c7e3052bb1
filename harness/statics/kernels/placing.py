"""Would an item stand on a growing layout? One place at a time, or many places in one call.

:func:`place` puts on the next item if it stands by a rule, and :func:`stand` looks at many
positions of it and changes nothing. Both ask the same function, so that they agree to the last bit.
The arrays are a tuple of those of :class:`steadyload.statics.kernels.growing.Arrays`.
"""

from __future__ import annotations

from typing import Any

from steadyload.statics.kernels.balance import balance_after, is_near_its_edge
from steadyload.statics.kernels.base_support import covered
from steadyload.statics.kernels.compiled import compiled
from steadyload.statics.kernels.constants import FAILS, FLOOR, FULL, ROUNDING, STANDS
from steadyload.statics.kernels.contacts import draw_in
from steadyload.statics.kernels.growing import (
    ITEMS,
    PATCHES,
    Growing,
    join,
    keep,
    opened,
    part,
    replace_presses,
    touching,
)
from steadyload.statics.kernels.sme import unsupported_at

SUPPORTED, CARRIED, BALANCED = range(3)
"""Rules: a share of the base is supported; static mechanical equilibrium holds; vertical forces
balance all items."""


@compiled
def place(kept: Any, rule: int, alpha: float) -> Any:
    """Put on the next item if it stands.

    Args:
        kept: the arrays.
        rule: :data:`SUPPORTED` or another.
        alpha: of :data:`SUPPORTED` the share of the base that is required; of :data:`BALANCED` the
            margin by which the contact patches of this item are drawn in on every side [cm].

    Returns:
        How it ended (:data:`STANDS`, :data:`FAILS`, :data:`UNRESOLVED`, :data:`OUTSIDE`,
        :data:`OVERLAPS`, :data:`FULL`), the item that fails, and a number that belongs to the rule:
        the share of the base, or 1 where something is below the item that fails.
    """
    grown = opened(kept)
    ended, below, above = touching(grown)
    item, number = -1, 0.0
    if ended == STANDS and rule == SUPPORTED:
        item = grown.counts[ITEMS]
        ended, number = _supported(grown, below, alpha)
    elif ended == STANDS and rule == BALANCED and _is_near_its_edge(grown, alpha):
        ended, item = FAILS, grown.counts[ITEMS]
    if ended != STANDS:
        return ended, item, number
    join(grown, below, above)
    if rule == BALANCED:
        _draw_in_last(grown, alpha)
    if rule == CARRIED:
        item = _unsupported(grown)
        if item >= 0:
            ended = FAILS
            if grown.contacts.ends[item] > grown.contacts.starts[item]:
                number = 1.0
    elif rule == BALANCED:
        ended, item, items = _balance(grown)
        if ended == STANDS:
            replace_presses(grown, items)
    if ended == STANDS:
        keep(grown)
    else:
        part(grown)
    return ended, item, number


@compiled
def stand(kept: Any, rule: int, alpha: float, positions: Any, endings: Any, first: int) -> int:
    """Look at many positions of the next item; see :func:`place`.

    Args:
        kept: see there.
        rule: see there.
        alpha: see there.
        positions: lower corners [cm], shape (K, 3).
        endings: how each position ends is put there, shape (K,).
        first: the position to begin with.

    Returns:
        The first position that it came not to, for want of room.
    """
    grown = opened(kept)
    for k in range(first, len(positions)):
        for axis in range(3):
            grown.box[axis] = positions[k, axis]
        ended = ending(grown, rule, alpha)
        if ended == FULL:
            return k
        endings[k] = ended
    return len(positions)


@compiled
def ending(grown: Growing, rule: int, alpha: float) -> int:
    """How putting on the next item would end; see :func:`place`."""
    ended, below, above = touching(grown)
    if ended != STANDS:
        return int(ended)
    if rule == SUPPORTED:
        ended, _ = _supported(grown, below, alpha)
    elif rule == BALANCED and _is_near_its_edge(grown, alpha):
        ended = FAILS
    else:
        join(grown, below, above)
        if rule == BALANCED:
            _draw_in_last(grown, alpha)
        if rule == CARRIED:
            ended = FAILS if _unsupported(grown) >= 0 else STANDS
        else:
            ended, _, _ = _balance(grown)
        part(grown)
    return int(ended)


@compiled
def _supported(grown: Growing, below: int, alpha: float) -> Any:
    """Whether enough of a base is supported, and its share, of the item looked at last."""
    number, contacts, first = grown.counts[ITEMS], grown.contacts, grown.counts[PATCHES]
    if contacts.on_floor[number]:
        return STANDS, 1.0
    area, edge = 0.0, 0.0
    for k in range(first, first + below):
        x0, z0, x1, z1 = contacts.patches[k]
        if contacts.below[k] == FLOOR:
            edge = (x1 - x0) * (z1 - z0)
        else:
            area += (x1 - x0) * (z1 - z0)
    x0, z0 = grown.lower[number, 0], grown.lower[number, 2]
    x1, z1 = grown.upper[number, 0], grown.upper[number, 2]
    share = (area + edge) / ((x1 - x0) * (z1 - z0))
    patches = contacts.patches[first : first + below]
    if share >= alpha - ROUNDING or covered(x0, z0, x1, z1, patches):
        return STANDS, share
    return FAILS, share


@compiled
def _unsupported(grown: Growing) -> int:
    """The item that is not supported after the last one, -1 where none is."""
    return unsupported_at(
        grown.counts[ITEMS] - 1, grown.contacts, grown.centres, grown.weights, grown.lower,
        grown.upper, grown.limits[6:11],
    )  # fmt: skip


@compiled
def _is_near_its_edge(grown: Growing, margin: float) -> bool:
    """See :func:`.kernels.balance.is_near_its_edge`, of the item looked at last."""
    return margin > 0.0 and is_near_its_edge(
        grown.counts[ITEMS], grown.contacts, grown.lower, grown.upper, grown.offsets, margin
    )


@compiled
def _draw_in_last(grown: Growing, margin: float) -> None:
    """Draw in the contact patches of the item that was joined last."""
    if margin <= 0.0:
        return
    number, contacts = grown.counts[ITEMS] - 1, grown.contacts
    draw_in(contacts.patches[contacts.starts[number] : contacts.ends[number]], margin)
    for m in range(contacts.above_starts[number], contacts.above_ends[number]):
        draw_in(contacts.patches[grown.meets[m] : grown.meets[m] + 1], margin)


@compiled
def _balance(grown: Growing) -> Any:
    """See :func:`steadyload.statics.kernels.balance.balance_after`, of the last item."""
    return balance_after(
        grown.counts[ITEMS] - 1, grown.contacts, grown.meets, grown.centres, grown.weights,
        grown.lower, grown.upper, grown.moves, grown.presses, grown.changed, False,
    )  # fmt: skip
