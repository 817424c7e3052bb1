"""Is a box crushed while a load is built up? Its top may bear so much, and bears so much by now."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from steadyload.layouts.model.item import Item
from steadyload.layouts.model.layout import Arrangement, Layout
from steadyload.statics.bearing.crushed import Crushed
from steadyload.statistics.placed import items_placed


def first_crushed(
    layout: Layout,
    *,
    before: int | None = None,
    check_time: Callable[[], None] = lambda: None,
) -> Crushed | None:
    """The box that is crushed first while a load is built up, box by box; None where none is.

    After a step at which no forces balance the load, those that come nearest count.

    Args:
        layout: the plan, in the order of loading.
        before: a step; later ones are not looked at, nor is that. None for all.
        check_time: called now and then; what it raises ends the looks.
    """
    if not _limited(layout.items):
        return None
    from steadyload.statics.bearing.looks import Looks, Passing, Standing

    kept = layout.with_floor_kept()
    looks = Looks(kept, layout.items, kept.supports, check_time)
    standing = Standing(layout.items, looks.supports)
    passing = Passing(looks)
    for step in range(items_placed(before, len(layout))):
        check_time()
        standing.place(step)
        suspects = standing.suspects(step)
        if not suspects:
            continue
        group = standing.group(step)
        found = looks.crushed_at(step, group, passing.suspects(group, suspects))
        if found is not None:
            return found
    return None


def crushed_by_now(
    layout: Arrangement, items: Sequence[Item], check_time: Callable[[], None] = lambda: None
) -> Crushed | None:
    """The box that bears most beyond what it may since the last one was placed; None where none
    does.

    Args:
        layout: where the items are, one or more; it may still grow.
        items: with what they may bear; none was crushed before the last was placed.
        check_time: see :func:`first_crushed`.
    """
    if not _limited(items):
        return None
    from steadyload.statics.bearing.looks import Looks

    looks, last = Looks(layout, items, layout.supports, check_time), len(items) - 1
    group = looks.supports.joined(last)
    return looks.crushed_at(last, np.array(group), looks.suspects(group, last))


def _limited(items: Sequence[Item]) -> bool:
    return any(item.max_load is not None for item in items)
