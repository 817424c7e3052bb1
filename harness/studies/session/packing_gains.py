"""Gain of packing heuristics by a loading session that rejects unstable placements."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache

import pandas as pd

from steadyload.layouts.model.layout import Layout
from steadyload.layouts.packing.heuristics import HEURISTICS, Heuristic
from steadyload.layouts.packing.packing import ITEM_CLASSES, make_instance
from steadyload.methods.contract.method import Verdict
from steadyload.methods.registry import make_method
from steadyload.methods.session.stable_packing import pack_stably
from steadyload.runs.provenance import made_by
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


@dataclass(frozen=True, slots=True)
class Packing:
    """One item list packed by one heuristic: what gains are computed of.

    ``stable``, ``scores``: of each bin, by the method that judges. ``left_out``: items that were
    accepted nowhere. ``seconds``: CPU time of packing; ``judging``: of this, the judgements.
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

    ``method``: its spec; empty where nothing is rejected. ``judge``: spec of the method that judges
    the packed bins. ``made_by``: versions of both.
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
) -> pd.DataFrame:
    """Pack item lists of all classes with every method that rejects, and without any.

    Returns:
        Fields of :class:`Packing`, with ``item_class`` and ``method``, empty where nobody rejects.
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
    return pd.DataFrame(
        {"item_class": unit.item_class, "method": unit.method, **asdict(one)}
        for unit, own in zip(units, found, strict=True)
        for one in own.packings
    )
