"""Geometry-based rules: full and partial base support (Section 2.1 of the paper)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from steadyload.core.constants import ROUNDING, STANDS, SUPPORTED
from steadyload.core.constants import VERSION as CORE
from steadyload.core.library import Finding as Found
from steadyload.core.library import finding
from steadyload.engines.quantities import quantity
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.contacts import FLOOR, Contacts
from steadyload.layouts.model.contacts import VERSION as CONTACTS
from steadyload.layouts.model.growing import GrowingLayout
from steadyload.layouts.model.layout import FloatArray, Layout
from steadyload.methods.contract.declared import Trait
from steadyload.methods.contract.method import (
    STABLE,
    BatchVerdicts,
    Finding,
    Loader,
    Method,
    StepScorer,
    Stopwatch,
)
from steadyload.methods.contract.spec import NoParameters
from steadyload.methods.rules.rule_loading import RuleLoader


@dataclass(frozen=True)
class _PartialSupport:
    alpha: float = quantity(
        0.7, "share of the base that must rest on the floor or on top faces", least=0.0, most=1.0
    )


class PartialBaseSupport(Method):
    """PBS: an item is stable when a share ``alpha`` of its base is supported from below.

    The support of an item is the area that its base shares with top faces of items placed before
    it, and with the floor, divided by the area of its base. Nothing placed later changes it, so the
    failing step is the first item with too little.
    """

    title = "PBS"
    Parameters: ClassVar[type[Any]] = _PartialSupport
    built_on: ClassVar[Mapping[str, int]] = {"core": CORE, "contacts": CONTACTS}

    @property
    def traits(self) -> frozenset[Trait]:
        """See :attr:`Method.traits`."""
        return frozenset((Trait.STEPWISE, Trait.BASE_SUPPORT))

    @property
    def _alpha(self) -> float:
        return self.parameters.alpha

    def steps(self, layout: Layout, watch: Stopwatch) -> StepScorer:
        """See :meth:`Method.steps`."""
        return _SupportedSteps(_support(layout, layout.contacts), 1.0 - self._alpha)

    def _judge(self, layout: Layout, watch: Stopwatch) -> Finding:
        found = layout.given.judge(SUPPORTED, self._alpha)
        return STABLE if found.ended == STANDS else self._too_little(found)

    def evaluate(self, batch: LayoutBatch) -> BatchVerdicts:
        """See :meth:`Method.evaluate`."""
        found = batch.given.judge(SUPPORTED, self._alpha)
        return BatchVerdicts.of_steps(
            batch, found["step"], finding=lambda k: self._too_little(finding(found, k))
        )

    def begin(self, layout: GrowingLayout) -> Loader:
        """A loader that checks the new item and the items it stands on."""
        return RuleLoader(layout, SUPPORTED, self._too_little, self._alpha)

    def _too_little(self, found: Found) -> Finding:
        return Finding(
            failing_step=found.step,
            moved_item=found.step,
            reason=f"{found.number:.1%} of its base is supported; required: {self._alpha:.1%}",
        )


class _SupportedSteps(StepScorer):
    """The score is the largest share of a base without support, of all items placed by then: what
    stands on full bases alone stands wherever centres of mass lie.
    """

    def __init__(self, support: FloatArray, decision_threshold: float) -> None:
        # An area is a sum of products: full support may be less by rounding.
        hanging = np.maximum(1.0 - support, 0.0)
        hanging[hanging < ROUNDING] = 0.0
        self._risks: list[float] = np.maximum.accumulate(hanging).tolist()
        self.decision_threshold = decision_threshold

    def step_score(self, step: int) -> float:
        return self._risks[step]


class FullBaseSupport(PartialBaseSupport):
    """FBS: the whole base must be supported, that is PBS with alpha = 1."""

    title = "FBS"
    Parameters = NoParameters

    @property
    def _alpha(self) -> float:
        return 1.0


def _support(layout: Layout, contacts: Contacts) -> FloatArray:
    """The share of every base that rests on the floor or on items placed before, shape (J,)."""
    before, floor = contacts.below < contacts.above, contacts.below == FLOOR
    on_items, on_floor = (
        np.bincount(contacts.above[of], contacts.areas[of], len(layout))
        for of in (before & ~floor, floor)
    )
    areas = on_items + on_floor
    sides = layout.upper - layout.lower
    found: FloatArray = np.where(contacts.on_floor, 1.0, areas / (sides[:, 0] * sides[:, 2]))
    return found
