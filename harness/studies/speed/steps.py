"""Shares of steps that a method decides with little work, and with much."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.declared import Trait
from steadyload.methods.contract.method import Method
from steadyload.statistics.metrics import ratio
from steadyload.studies.speed.records import StepShares


def step_shares(
    cases: str, spec: str, method: Method, layouts: Sequence[Layout]
) -> StepShares | None:
    """Shares over all steps of some layouts; None of none, and of a method that counts no steps.

    A method counts its steps if it has ``step_counts``: of a layout, how many steps were judged,
    for how many the forces found before were kept, and for how many the model of motion was asked.
    """
    counts = getattr(method, "step_counts", None)
    if counts is None or not layouts or Trait.MOVEMENT not in method.traits:
        return None
    steps, kept, asked = np.array([counts(layout) for layout in layouts]).T
    return StepShares(cases, spec, int(steps.sum()), ratio(kept, steps), ratio(asked, steps))
