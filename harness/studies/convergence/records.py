"""Results of the convergence study of the reference."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from steadyload.statistics.estimate import Estimate


@dataclass(frozen=True, slots=True)
class ConvergenceRow:
    """A changed reference, or another method, compared with the reference itself.

    ``changed``: share of layouts with another label; ``changed_stable`` of those that the reference
    calls stable, ``changed_unstable`` of the others. ``earlier``, ``later``: layouts that fail at
    an earlier or later step. ``cpu``, ``slowest`` in ms a layout. ``value``: position on an axis.
    """

    group: str
    title: str
    spec: str
    value: float | None
    changed: Estimate
    changed_stable: Estimate
    changed_unstable: Estimate
    earlier: int
    later: int
    cpu: Estimate
    slowest: float
    without_verdict: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class LabelDispute:
    """A layout on which another method differs: failing steps, ``stable`` or a status.

    ``displacement`` [cm] and ``rotation`` [degrees] are those of the reference at its failing step.
    ``changes_under`` names those changes of the reference, of ``tried`` ones, that change the
    label, too.
    """

    layout: str
    item_count: int
    label: str
    displacement: float | None
    rotation: float | None
    said: Mapping[str, str]
    tried: int
    changes_under: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Convergence:
    """Convergence of the reference's labels.

    ``any_change``: share of layouts whose label changes under any change of the numerics.
    ``by_size``: CPU time of the reference in ms a layout, by number of items.
    """

    items: Estimate
    stable: Estimate
    reference: ConvergenceRow
    variants: tuple[ConvergenceRow, ...]
    engines: tuple[ConvergenceRow, ...]
    opinions: tuple[ConvergenceRow, ...]
    any_change: Estimate
    by_size: tuple[tuple[str, Estimate], ...]
    disputes: tuple[LabelDispute, ...]
