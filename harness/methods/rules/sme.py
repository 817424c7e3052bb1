"""The authors' force-based rule; the exact solution is
:mod:`steadyload.methods.equilibrium.equilibrium`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from steadyload.core.constants import CARRIED, STANDS
from steadyload.core.constants import VERSION as CORE
from steadyload.core.library import Finding as Found
from steadyload.core.library import finding
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.contacts import VERSION as CONTACTS
from steadyload.layouts.model.growing import GrowingLayout
from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.declared import Trait
from steadyload.methods.contract.method import (
    STABLE,
    BatchVerdicts,
    Finding,
    Loader,
    Method,
    Stopwatch,
)
from steadyload.methods.contract.spec import NoParameters
from steadyload.methods.rules.rule_loading import RuleLoader


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
    built_on: ClassVar[Mapping[str, int]] = {"core": CORE, "contacts": CONTACTS}

    @property
    def traits(self) -> frozenset[Trait]:
        """See :attr:`Method.traits`."""
        return frozenset((Trait.STEPWISE, Trait.CENTRES_OF_MASS))

    def _judge(self, layout: Layout, watch: Stopwatch) -> Finding:
        found = layout.given.judge(CARRIED, 0.0)
        return STABLE if found.ended == STANDS else _unsupported(found)

    def evaluate(self, batch: LayoutBatch) -> BatchVerdicts:
        """See :meth:`Method.evaluate`."""
        found = batch.given.judge(CARRIED, 0.0)
        return BatchVerdicts.of_steps(
            batch, found["step"], finding=lambda k: _unsupported(finding(found, k))
        )

    def begin(self, layout: GrowingLayout) -> Loader:
        """A loader that checks the new item and the items that carry it."""
        return RuleLoader(layout, CARRIED, _unsupported)


def _unsupported(found: Found) -> Finding:
    lies = "the resultant of its load lies outside its support"
    reason = lies if found.number else "nothing supports it"
    return Finding(found.step, found.item, reason=reason)
