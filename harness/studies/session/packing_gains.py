"""Gain of packing heuristics by a loading session that rejects unstable placements."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from steadyload.layouts.heuristics import HEURISTICS, Heuristic
from steadyload.layouts.model import Layout
from steadyload.layouts.packing import ITEM_CLASSES, Instance, make_instance
from steadyload.methods.method import Method, Verdict
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share
from steadyload.studies.session.stable_packing import StablePacking, pack_stably

Progress = Callable[[str], None]

REJECTING = (
    "fbs",
    "pbs0.7",
    "sme",
    "equilibrium",
    "equilibrium:time=0.3",
    "lstm_1",
    "ps_opt@mujoco",
)
"""Methods that reject placements."""

JUDGE = "label@reference"
"""Method that judges the packed bins; none of those that reject placements."""

PACKED_BY = HEURISTICS[:40:5]
"""Heuristics with all eight space rules and all five placement rules, with the first bin rule."""

ITEM_COUNT = 20
"""Number of items of a list: the most that a layout of the labelled set has."""

_SEED = 21


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


def packing_gains(
    specs: Sequence[str] = REJECTING,
    *,
    judge: str = JUDGE,
    instances: int = 5,
    heuristics: Sequence[Heuristic] = PACKED_BY,
    progress: Progress = lambda what: None,
) -> list[PackingTask]:
    """Pack item lists of all classes with every method that rejects, and without any.

    Args:
        specs: methods that reject placements.
        judge: method that judges the packed bins.
        instances: number of item lists of each class.
        heuristics: that pack each of them.
        progress: called with a description of the current work.

    Raises:
        SpecError: no such method.
    """
    methods = [None, *map(make_method, specs)]
    verdicts = _Verdicts(make_method(judge))
    tasks = []
    for item_class in ITEM_CLASSES:
        lists = [
            make_instance(item_class, number, seed=_SEED, item_count=ITEM_COUNT)
            for number in range(instances)
        ]
        gains = []
        for method in methods:
            rejecting = "nobody rejects" if method is None else f"{method.spec} rejects"
            progress(f"class {item_class}, {rejecting}")
            gains.append(_gain(method, lists, heuristics, verdicts))
        names = tuple(h.name for h in heuristics)
        tasks.append(
            PackingTask(f"Class {item_class}", instances, ITEM_COUNT, names, judge, tuple(gains))
        )
    return tasks


class _Verdicts:
    """Verdicts of a method, computed once for every geometry: many heuristics pack alike."""

    def __init__(self, judge: Method) -> None:
        self._judge = judge
        self._known: dict[str, Verdict] = {}
        judge.prepare(ITEM_COUNT)

    def of(self, layout: Layout) -> Verdict:
        key = layout.content_hash()
        if key not in self._known:
            self._known[key] = self._judge.judge(layout)
        return self._known[key]


def _gain(
    method: Method | None,
    instances: Sequence[Instance],
    heuristics: Sequence[Heuristic],
    verdicts: _Verdicts,
) -> PackingGain:
    if method is not None:
        method.prepare(ITEM_COUNT)
    packed: list[tuple[int, StablePacking]] = [
        (instance.number, pack_stably(instance, heuristic, method))
        for instance in instances
        for heuristic in heuristics
    ]
    judged = [(number, verdicts.of(layout)) for number, p in packed for layout in p.layouts]
    of_bins, of_packings = [number for number, _ in judged], [number for number, _ in packed]
    items = ITEM_COUNT * len(packed)
    return PackingGain(
        method=None if method is None else method_key(method),
        stable=share([v.stable for _, v in judged], of_bins),
        score=mean([v.score or 0.0 for _, v in judged], of_bins),
        bins=mean([len(p.layouts) for _, p in packed], of_packings),
        left_out=sum(p.left_out for _, p in packed),
        asked=sum(p.placements for _, p in packed) / items,
        rejected=sum(p.rejected for _, p in packed) / items,
        cpu=mean([1e3 * p.seconds / ITEM_COUNT for _, p in packed], of_packings),
        judging=mean([1e3 * p.judging / ITEM_COUNT for _, p in packed], of_packings),
    )
