"""Records for the page of loading sessions."""

from __future__ import annotations

from dataclasses import dataclass

from steadyload.methods.naming import MethodKey
from steadyload.statistics.estimate import Estimate


@dataclass(frozen=True, slots=True)
class PlacementCost:
    """Cost of a placement at a number of loaded items.

    Attributes:
        items: last of the consecutive items whose median is taken.
        placement: CPU time of a placement in a session [ms], a median.
        whole: CPU time of judging the whole layout instead [ms]; None where not measured.
    """

    items: int
    placement: float
    whole: float | None


@dataclass(frozen=True, slots=True)
class SessionCurve:
    """Costs of one method while one scene is loaded.

    Attributes:
        scene: its name.
        exponent: the cost of a placement grows as this power of the items loaded; None where the
            curve is too short for an estimate.
    """

    method: MethodKey
    scene: str
    points: tuple[PlacementCost, ...]
    exponent: float | None


@dataclass(frozen=True, slots=True)
class PackingGain:
    """Results of packing heuristics when one method rejects placements.

    Attributes:
        method: that rejects; None: nothing is rejected.
        stable: share of the bins that are stable by the task's ``judge``.
        score: mean score of a bin by the same method.
        bins: bins an item list.
        left_out: items that were not accepted at any place.
        asked, rejected: placements judged and rejected, an item.
        cpu: CPU time of packing, judgements included, an item [ms].
        judging: of this, the judgements [ms].
    """

    method: MethodKey | None
    stable: Estimate
    score: Estimate
    bins: Estimate
    left_out: int
    asked: float
    rejected: float
    cpu: Estimate
    judging: Estimate


@dataclass(frozen=True, slots=True)
class PackingTask:
    """A packing task and its results.

    Attributes:
        title: description of the item lists.
        item_lists, items: number of item lists, and of items in each.
        heuristics: names.
        judge: spec of the method that judges the packed bins.
        gains: one for each method.
    """

    title: str
    item_lists: int
    items: int
    heuristics: tuple[str, ...]
    judge: str
    gains: tuple[PackingGain, ...]
