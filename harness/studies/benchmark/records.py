"""Records for the page of a labelled set."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from steadyload.statistics.estimate import Estimate


@dataclass(frozen=True, slots=True)
class ClassCount:
    """One item class: item lists, distinct geometries, items a layout, share of stable cases."""

    item_class: int
    instances: int
    layouts: int
    items: Estimate
    stable: Estimate


@dataclass(frozen=True, slots=True)
class SplitCount:
    """One split in one scenario; ``split`` is None for labelled cases of no split."""

    split: str | None
    scenario: str
    instances: int
    cases: int
    stable: int


@dataclass(frozen=True, slots=True)
class NaturalStable:
    """Share of layouts that can be loaded, before anything is balanced, in one scenario.

    ``packings``: likewise where a geometry counts as often as a heuristic gave it.
    ``criterion_paper``: likewise under the other criterion; ``other_label``: share of cases whose
    failing step differs between the two. ``published``: the paper's share, None where it has none.
    """

    scenario: str
    stable: Estimate
    packings: Estimate
    criterion_paper: Estimate | None
    other_label: Estimate | None
    published: float | None


@dataclass(frozen=True, slots=True)
class FailureReason:
    """Reasons for which loadings fail: shares of the unstable cases of a scenario."""

    reason: str
    shares: Mapping[str, Estimate]


@dataclass(frozen=True, slots=True)
class Firmness:
    """Confidence of the labels of a split in one scenario: its mean and the share of robust labels.

    ``parts`` is the mean agreement by reason of doubt.
    """

    split: str
    scenario: str
    confidence: Estimate
    robust: Estimate
    parts: Mapping[str, Estimate]


@dataclass(frozen=True, slots=True)
class MethodAgreement:
    """Agreement of one further method with the labels of the test split, by scenario and pooled.

    ``robust`` counts robust labels alone; None for the ensemble that defines them.
    """

    reason: str
    judge: str
    by_scenario: Mapping[str, Estimate]
    pooled: Estimate
    robust: Estimate | None
    earlier: int
    later: int
    without_verdict: int


@dataclass(frozen=True, slots=True)
class RobustDispute:
    """A robust label that an engine disagrees with.

    ``corner`` [cm] and ``angle`` [degrees]: how far the reference moved at the step at which the
    two part; ``margin`` [cm]: of the equilibrium there. ``said``: the failing step by each engine.
    """

    layout: str
    scenario: str
    item_count: int
    label: str
    said: Mapping[str, str]
    step: int
    corner: float
    angle: float
    margin: float | None


@dataclass(frozen=True, slots=True)
class BenchmarkSummary:
    """Everything the page of a labelled set shows.

    ``item_counts``: layouts by number of items. ``scores``: by scenario, cases by failing step's
    share of the items in ten bins, the last for stable ones.
    """

    layouts: int
    cases: int
    instances: int
    without_label: int
    classes: tuple[ClassCount, ...]
    splits: tuple[SplitCount, ...]
    natural: tuple[NaturalStable, ...]
    item_counts: Mapping[int, int]
    scores: Mapping[str, tuple[int, ...]]
    reasons: tuple[FailureReason, ...]
    firmness: tuple[Firmness, ...]
    judges: tuple[MethodAgreement, ...]
    disputes: tuple[RobustDispute, ...]
