"""Would an item stand on a growing layout? One place at a time, or many places in one call.

Each rule has two functions: ``place_...`` puts on the next item if it stands, and
``stands_...`` looks at many positions of it and changes nothing. Both ask the same function, so
that they agree to the last bit. The arrays are those of :mod:`steadyload.statics.kernels.growing`.

``place_...`` returns how it ended (:data:`STANDS`, :data:`FAILS`, :data:`UNRESOLVED`,
:data:`OUTSIDE`, :data:`OVERLAPS`, :data:`FULL`), the item that fails, and a number that belongs to
the rule. ``stands_...`` writes how each position ends to ``endings`` (K,), from position ``first``
on, and returns the first position that it came not to, for want of room.
"""

from __future__ import annotations

from typing import Any

from steadyload.statics.kernels.balance import balance_after
from steadyload.statics.kernels.base_support import covered
from steadyload.statics.kernels.compiled import compiled
from steadyload.statics.kernels.constants import FAILS, FLOOR, FULL, ROUNDING, STANDS
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


@compiled
def place_supported(
    vectors: Any, weights: Any, centres: Any, blocks: Any, links: Any, patches: Any, presses: Any,
    changes: Any, cells: Any, counts: Any, limits: Any, alpha: float,
) -> Any:  # fmt: skip
    """Put on the item if a share of its base is supported; the number is the share."""
    grown = opened(
        vectors, weights, centres, blocks, links, patches, presses, changes, cells, counts, limits
    )
    ended, below, above = touching(grown)
    share = 0.0
    if ended == STANDS:
        ended, share = _supported(grown, below, alpha)
    if ended == STANDS:
        join(grown, below, above)
        keep(grown)
    return ended, counts[ITEMS], share


@compiled
def stands_supported(
    vectors: Any, weights: Any, centres: Any, blocks: Any, links: Any, patches: Any, presses: Any,
    changes: Any, cells: Any, counts: Any, limits: Any, alpha: float, positions: Any, endings: Any,
    first: int,
) -> int:  # fmt: skip
    """See :func:`place_supported`."""
    grown = opened(
        vectors, weights, centres, blocks, links, patches, presses, changes, cells, counts, limits
    )
    for k in range(first, len(positions)):
        for axis in range(3):
            grown.box[axis] = positions[k, axis]
        ended, below, _ = touching(grown)
        if ended == FULL:
            return k
        if ended == STANDS:
            ended, _ = _supported(grown, below, alpha)
        endings[k] = ended
    return len(positions)


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
def place_sme(
    vectors: Any, weights: Any, centres: Any, blocks: Any, links: Any, patches: Any, presses: Any,
    changes: Any, cells: Any, counts: Any, limits: Any,
) -> Any:  # fmt: skip
    """Put on the item if static mechanical equilibrium holds; the number is 1 where something is
    below the item that fails.
    """
    grown = opened(
        vectors, weights, centres, blocks, links, patches, presses, changes, cells, counts, limits
    )
    ended, below, above = touching(grown)
    if ended != STANDS:
        return ended, -1, 0.0
    join(grown, below, above)
    item = _unsupported(grown)
    if item < 0:
        keep(grown)
        return STANDS, -1, 0.0
    carried = 1.0 if grown.contacts.ends[item] > grown.contacts.starts[item] else 0.0
    part(grown)
    return FAILS, item, carried


@compiled
def stands_sme(
    vectors: Any, weights: Any, centres: Any, blocks: Any, links: Any, patches: Any, presses: Any,
    changes: Any, cells: Any, counts: Any, limits: Any, positions: Any, endings: Any, first: int,
) -> int:  # fmt: skip
    """See :func:`place_sme`."""
    grown = opened(
        vectors, weights, centres, blocks, links, patches, presses, changes, cells, counts, limits
    )
    for k in range(first, len(positions)):
        for axis in range(3):
            grown.box[axis] = positions[k, axis]
        ended, below, above = touching(grown)
        if ended == FULL:
            return k
        if ended == STANDS:
            join(grown, below, above)
            if _unsupported(grown) >= 0:
                ended = FAILS
            part(grown)
        endings[k] = ended
    return len(positions)


@compiled
def _unsupported(grown: Growing) -> int:
    """The item that is not supported after the last one, -1 where none is."""
    return unsupported_at(
        grown.counts[ITEMS] - 1, grown.contacts, grown.centres, grown.weights, grown.lower,
        grown.upper, grown.limits[6:11],
    )  # fmt: skip


@compiled
def place_balanced(
    vectors: Any, weights: Any, centres: Any, blocks: Any, links: Any, patches: Any, presses: Any,
    changes: Any, cells: Any, counts: Any, limits: Any,
) -> Any:  # fmt: skip
    """Put on the item if vertical forces balance all items then; the number means nothing."""
    grown = opened(
        vectors, weights, centres, blocks, links, patches, presses, changes, cells, counts, limits
    )
    ended, below, above = touching(grown)
    if ended != STANDS:
        return ended, -1, 0.0
    join(grown, below, above)
    ended, item, items = _balance(grown)
    if ended == STANDS:
        replace_presses(grown, items)
        keep(grown)
    else:
        part(grown)
    return ended, item, 0.0


@compiled
def stands_balanced(
    vectors: Any, weights: Any, centres: Any, blocks: Any, links: Any, patches: Any, presses: Any,
    changes: Any, cells: Any, counts: Any, limits: Any, positions: Any, endings: Any, first: int,
) -> int:  # fmt: skip
    """See :func:`place_balanced`."""
    grown = opened(
        vectors, weights, centres, blocks, links, patches, presses, changes, cells, counts, limits
    )
    for k in range(first, len(positions)):
        for axis in range(3):
            grown.box[axis] = positions[k, axis]
        ended, below, above = touching(grown)
        if ended == FULL:
            return k
        if ended == STANDS:
            join(grown, below, above)
            ended, _, _ = _balance(grown)
            part(grown)
        endings[k] = ended
    return len(positions)


@compiled
def _balance(grown: Growing) -> Any:
    """See :func:`steadyload.statics.kernels.balance.balance_after`, of the last item."""
    return balance_after(
        grown.counts[ITEMS] - 1, grown.contacts, grown.meets, grown.centres, grown.weights,
        grown.lower, grown.upper, grown.moves, grown.presses, grown.changed,
    )  # fmt: skip
