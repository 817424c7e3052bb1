"""Gain of packing heuristics by a loading session that rejects unstable placements."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from itertools import chain

from steadyload.layouts.model.layout import Layout
from steadyload.layouts.packing.heuristics import HEURISTICS, Heuristic
from steadyload.layouts.packing.packing import ITEM_CLASSES, make_instance
from steadyload.methods.contract.method import Verdict
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.methods.session.stable_packing import pack_stably
from steadyload.reports.columns import column, fixed, milliseconds, percent, row, significant
from steadyload.runs.provenance import made_by
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share
from steadyload.studies.kit import Asked, Lab

VERSION = 1
"""Version of the packing: raised when the same methods come to other bins."""

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
"""Judges the bins that were packed."""

ITEM_LISTS = 5
"""Item lists of each class."""

PACKED_BY = HEURISTICS[:40:5]
"""Heuristics with all eight space rules and all five placement rules, with the first bin rule."""

ITEM_COUNT = 20
"""Number of items of a list: the most that a layout of the labelled set has."""

_SEED = 21


_two_digits = partial(significant, digits=2)


@row
class PackingGain:
    """Results of packing heuristics when one method rejects placements, or nobody does.

    The last three are None where nothing is rejected.
    """

    title: str = column("rejected by")
    stable: Estimate = column("stable %", percent, "share of bins, by the task's judge")
    score: Estimate = column("mean score %", percent, "of a bin, by the same method")
    bins: Estimate = column("bins a list", lambda bins: fixed(bins.value, 2))
    cpu: Estimate = column("ms an item", milliseconds, "of packing, judgements included")
    left_out: int = column("left out", about="items that were not accepted at any place")
    asked: float | None = column("judged an item", _two_digits)
    rejected: float | None = column("rejected an item", _two_digits)
    judging: Estimate | None = column("of this judging", milliseconds)
    method: MethodKey | None


@row
class PackingTask:
    """A packing task and its results.

    ``judge``: spec of the method that judges the packed bins. ``gains``: one for each method.
    """

    title: str
    item_lists: int
    items: int
    heuristics: Sequence[str]
    judge: str
    gains: Sequence[PackingGain]

    @property
    def nobody(self) -> PackingGain | None:
        """The results where nothing is rejected."""
        return next((gain for gain in self.gains if gain.method is None), None)

    @property
    def best(self) -> PackingGain | None:
        """Those of the method by which most bins are stable."""
        own = [gain for gain in self.gains if gain.method]
        return max(own, key=lambda gain: gain.stable.value, default=None)


@dataclass(frozen=True, slots=True)
class Packing:
    """One item list packed by one heuristic: what :class:`PackingGain` is computed of.

    Attributes:
        item_list: its number.
        stable, scores: of each bin, by the method that judges.
        left_out: items that were not accepted at any place.
        placements, rejected: number of those judged, and of these that were rejected.
        seconds: CPU time of packing.
        judging: of this, the judgements.
    """

    item_list: int
    stable: Sequence[bool]
    scores: Sequence[float]
    left_out: int
    placements: int
    rejected: int
    seconds: float
    judging: float


@dataclass(frozen=True, slots=True)
class Packings:
    """Every item list of a class, packed by every heuristic."""

    packings: Sequence[Packing]


@cache
def _judging(judge: str) -> Callable[[Layout], Verdict]:
    """Verdicts of a method, computed once for every geometry: many heuristics pack alike."""
    method, known = make_method(judge), dict[str, Verdict]()
    method.prepare(ITEM_COUNT)

    def verdict(layout: Layout) -> Verdict:
        key = layout.content_hash()
        if key not in known:
            known[key] = method.judge(layout)
        return known[key]

    return verdict


class PackingUnit(
    Asked[Packings],
    what="gain for packing",
    version=VERSION,
    seed=_SEED,
    **{"item count": ITEM_COUNT},
):
    """Packing of item lists of a class by all heuristics while one method rejects placements.

    Attributes:
        item_class: of the lists.
        method: spec of the method that rejects; empty: nothing is rejected.
        judge: spec of the method that judges the packed bins.
        instances: number of item lists.
        heuristics: numbers of the heuristics.
        made_by: versions of both methods.
    """

    item_class: int
    method: str
    judge: str
    instances: int
    heuristics: tuple[int, ...]
    made_by: Mapping[str, Mapping[str, str]]

    def describe(self, part: int) -> str:
        """Description of the packing for messages."""
        who = self.method or "nobody"
        return f"class {self.item_class}, {who} rejects"

    def measure(self) -> Packings:
        """Pack, and judge the bins."""
        verdict = _judging(self.judge)
        method = make_method(self.method) if self.method else None
        if method is not None:
            method.prepare(ITEM_COUNT)
        packings = []
        for number in range(self.instances):
            instance = make_instance(self.item_class, number, seed=_SEED, item_count=ITEM_COUNT)
            for heuristic in map(Heuristic.numbered, self.heuristics):
                found = pack_stably(instance, heuristic, method)
                judged = [verdict(layout) for layout in found.layouts]
                packings.append(
                    Packing(
                        item_list=instance.number,
                        stable=[one.stable for one in judged],
                        scores=[one.score or 0.0 for one in judged],
                        left_out=found.left_out,
                        placements=found.placements,
                        rejected=found.rejected,
                        seconds=found.seconds,
                        judging=found.judging,
                    )
                )
        return Packings(packings)


def packing_gains(
    lab: Lab,
    specs: Sequence[str] = REJECTING,
    *,
    judge: str = JUDGE,
    instances: int = ITEM_LISTS,
    heuristics: Sequence[Heuristic] = PACKED_BY,
) -> list[PackingTask]:
    """Pack item lists of all classes with every method that rejects, and without any.

    Args:
        lab: what was packed and judged in its folder is not done again.
        specs: methods that reject placements.
        judge: method that judges the packed bins.
        instances: number of item lists of each class.
        heuristics: that pack each of them.

    Raises:
        SpecError: no such method.
        ResultsError: another run is at work in the folder.
    """
    made = {spec: made_by(make_method(spec)) for spec in (*specs, judge)}
    numbers = tuple(heuristic.number for heuristic in heuristics)
    units = [
        PackingUnit(
            item_class, spec, judge, instances, numbers,
            {name: made[name] for name in (spec, judge) if name},
        )
        for item_class in ITEM_CLASSES
        for spec in ("", *specs)
    ]  # fmt: skip
    found, _ = lab.measure(units, Packings, folder="packed")
    names, rows = tuple(heuristic.name for heuristic in heuristics), iter(found)
    return [
        PackingTask(
            f"Class {item_class}", instances, ITEM_COUNT, names, judge,
            tuple(_gain(spec, next(rows).packings) for spec in ("", *specs)),
        )
        for item_class in ITEM_CLASSES
    ]  # fmt: skip


def _gain(spec: str, packings: Sequence[Packing]) -> PackingGain:
    of_packings = [one.item_list for one in packings]
    of_bins = [one.item_list for one in packings for _ in one.stable]
    items = ITEM_COUNT * len(packings)
    key = method_key(make_method(spec)) if spec else None
    return PackingGain(
        title=key.title if key else "nobody",
        stable=share(list(chain(*(one.stable for one in packings))), of_bins),
        score=mean(list(chain(*(one.scores for one in packings))), of_bins),
        bins=mean([len(one.stable) for one in packings], of_packings),
        cpu=mean([1e3 * one.seconds / ITEM_COUNT for one in packings], of_packings),
        left_out=sum(one.left_out for one in packings),
        asked=sum(one.placements for one in packings) / items if key else None,
        rejected=sum(one.rejected for one in packings) / items if key else None,
        judging=mean([1e3 * one.judging / ITEM_COUNT for one in packings], of_packings)
        if key
        else None,
        method=key,
    )
