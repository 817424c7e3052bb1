"""Geometry-based rules: full and partial base support (Section 2.1 of the paper)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from harness.layouts.contacts import find_contacts
from harness.layouts.model import Layout
from harness.methods.method import STABLE, Finding, Method, Stopwatch
from harness.methods.spec import quantity

_ROUNDING = 1e-9


@dataclass(frozen=True)
class _NoParameters:
    pass


@dataclass(frozen=True)
class _PartialSupport:
    alpha: float = quantity(
        0.7, "share of the base that must rest on the floor or on top faces", least=0.0, most=1.0
    )


class PartialBaseSupport(Method):
    """PBS: an item is stable when a share ``alpha`` of its base is supported from below.

    The support of an item is the area that its base shares with top faces of items placed before
    it, divided by the area of its base; the floor supports in full. Nothing placed later changes
    it, so the failing step is the first item with too little.
    """

    Parameters: ClassVar[type[Any]] = _PartialSupport

    @property
    def _alpha(self) -> float:
        return self.parameters.alpha

    def _judge(self, layout: Layout, watch: Stopwatch) -> Finding:
        contacts = find_contacts(layout)
        placed_before = np.triu(contacts.areas(), k=1).sum(axis=0)
        sides = layout.upper - layout.lower
        support = np.where(contacts.on_floor, 1.0, placed_before / (sides[:, 0] * sides[:, 2]))
        failed = np.flatnonzero(support < self._alpha - _ROUNDING)
        if not len(failed):
            return STABLE
        step = int(failed[0])
        return Finding(
            failing_step=step,
            moved_item=step,
            reason=f"{support[step]:.1%} of its base is supported; required: {self._alpha:.1%}",
        )


class FullBaseSupport(PartialBaseSupport):
    """FBS: the whole base must be supported, that is PBS with alpha = 1."""

    Parameters = _NoParameters

    @property
    def _alpha(self) -> float:
        return 1.0
