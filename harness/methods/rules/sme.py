"""The authors' force-based rule; the exact solution is
:mod:`steadyload.methods.equilibrium.equilibrium`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from steadyload.core.whole import CARRIED
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
from steadyload.statics.given import given, given_many


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
    built_on: ClassVar[Mapping[str, int]] = {"contacts": CONTACTS}
    packages = ("numba", "numpy")

    @property
    def traits(self) -> frozenset[Trait]:
        """See :attr:`Method.traits`."""
        return frozenset((Trait.STEPWISE, Trait.CENTRES_OF_MASS))

    def _judge(self, layout: Layout, watch: Stopwatch) -> Finding:
        _, step, culprit, carried = given(layout).judge(CARRIED, 0.0)
        return STABLE if step == len(layout) else _finding(step, culprit, carried=bool(carried))

    def evaluate(self, batch: LayoutBatch) -> BatchVerdicts:
        """See :meth:`Method.evaluate`."""
        _, steps, culprits, carried = given_many(batch).judge(CARRIED, 0.0)
        return BatchVerdicts.of_steps(
            batch,
            steps,
            finding=lambda k: _finding(int(steps[k]), int(culprits[k]), carried=bool(carried[k])),
        )

    def begin(self, layout: GrowingLayout) -> Loader:
        """A loader that checks the new item and the items that carry it."""
        return RuleLoader(
            layout,
            CARRIED,
            lambda step, culprit, carried: _finding(step, culprit, carried=bool(carried)),
        )


def _finding(step: int, culprit: int, *, carried: bool) -> Finding:
    lies = "the resultant of its load lies outside its support"
    return Finding(step, culprit, reason=lies if carried else "nothing supports it")
