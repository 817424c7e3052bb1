"""What the page of loading sessions shows."""

from __future__ import annotations

from dataclasses import dataclass

from steadyload.methods.naming import MethodKey
from steadyload.statistics.estimate import Estimate


@dataclass(frozen=True, slots=True)
class PlacementCost:
    """What a placement costs when so many items are loaded.

    Attributes:
        items: the last of the items that are taken together.
        placement: CPU time of a placement in a session [ms], a median.
        whole: CPU time of judging the whole layout instead [ms]; None where not measured.
    """

    items: int
    placement: float
    whole: float | None


@dataclass(frozen=True, slots=True)
class SessionCurve:
    """One method while one scene is loaded.

    Attributes:
        scene: its name.
        exponent: the cost of a placement grows as this power of the items loaded; None where the
            curve is too short to tell.
    """

    method: MethodKey
    scene: str
    points: tuple[PlacementCost, ...]
    exponent: float | None


@dataclass(frozen=True, slots=True)
class PackingGain:
    """What packing heuristics pack when one method rejects placements.

    Attributes:
        method: that rejects; None: nothing is rejected.
        stable: share of the bins that the judge can load.
        score: mean score of a bin by the judge.
        bins: bins an item list.
        left_out: items that were accepted nowhere.
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
    """What was packed, and who judged what came of it.

    Attributes:
        title: which item lists.
        item_lists, items: how many, and how many items each.
        heuristics: names.
        judge: a spec.
        gains: a method each.
    """

    title: str
    item_lists: int
    items: int
    heuristics: tuple[str, ...]
    judge: str
    gains: tuple[PackingGain, ...]
