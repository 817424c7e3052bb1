"""Layouts as the C library takes them."""

from __future__ import annotations

from steadyload.core.whole import Given, GivenMany
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.layout import Arrangement


def given(layout: Arrangement) -> Given:
    """A layout, looked at as it is now."""
    return Given(
        layout.lower, layout.upper, layout.weights, layout.mass_offsets, layout.floor.corners
    )


def given_many(batch: LayoutBatch) -> GivenMany:
    """The layouts of a batch."""
    return GivenMany(
        batch.starts, batch.lower, batch.upper, batch.weights, batch.mass_offsets, batch.floors
    )
