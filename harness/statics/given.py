"""Layouts as the C library takes them."""

from __future__ import annotations

from weakref import WeakKeyDictionary

from steadyload.core.whole import Given, GivenMany
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.layout import Arrangement, Layout

_LAYOUTS: WeakKeyDictionary[Layout, Given] = WeakKeyDictionary()
"""Where the arrays of layouts are: to find that out takes longer than most judgements."""


def given(layout: Arrangement) -> Given:
    """A layout, or one that grows as it is now."""
    if not isinstance(layout, Layout):  # its arrays change
        return _given(layout)
    found = _LAYOUTS.get(layout)
    if found is None:
        found = _LAYOUTS[layout] = _given(layout)
    return found


def _given(layout: Arrangement) -> Given:
    return Given(
        layout.lower, layout.upper, layout.weights, layout.mass_offsets, layout.floor.corners
    )


def given_many(batch: LayoutBatch) -> GivenMany:
    """The layouts of a batch."""
    return GivenMany(
        batch.starts, batch.lower, batch.upper, batch.weights, batch.mass_offsets, batch.floors
    )
