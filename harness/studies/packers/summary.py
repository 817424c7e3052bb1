"""Typed results on packers' plans: shares that stand, pairs of packers, causes, the worst plans."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd

from steadyload.layouts.benchmark.dataset import Benchmark
from steadyload.layouts.benchmark.tables import BenchmarkError
from steadyload.layouts.model import Layout
from steadyload.layouts.scenarios import Scenario
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share
from steadyload.statistics.paired import holm, sign_flip
from steadyload.studies.packers.causes import Cause, cause_of, widest_gap
from steadyload.studies.packers.plans import (
    CONTAINERS,
    CUSTOMERS,
    EURO_PALLETS,
    OTHERS,
    PACKER_TITLES,
    plans_of,
)

UNKNOWN = "not stated"


@dataclass(frozen=True, slots=True)
class PackerShares:
    """Plans of a packer for one kind of list, or for all: shares that stand by each question.

    ``boxes``: a plan. ``score``: share of boxes placed safely, by ``stands``. ``unsettled``: plans
    in which something still moves in the end; they are in ``within`` alone.
    """

    packer: str
    kind: str
    lists: int
    plans: int
    boxes: Estimate
    within: Estimate
    stands: Estimate
    score: Estimate
    unsettled: int


@dataclass(frozen=True, slots=True)
class ScenarioShares:
    """Share of plans that stand by scenario, of those with a label of ``stands`` in each."""

    packer: str
    plans: int
    stands: Mapping[str, Estimate]


@dataclass(frozen=True, slots=True)
class PackerPair:
    """Two packers on the same lists: shares of these on which one plan stands, the other does not.

    ``p``: of the paired sign-flip test, corrected for all pairs.
    """

    first: str
    second: str
    lists: int
    only_first: Estimate
    only_second: Estimate
    p: float


@dataclass(frozen=True, slots=True)
class PackerCauses:
    """Failing plans of a packer: shares by cause.

    ``own``: share of them in which the box that moves most is the one just placed.
    """

    packer: str
    plans: int
    causes: Mapping[Cause, Estimate]
    own: Estimate


@dataclass(frozen=True, slots=True)
class WorstPlan:
    """The plan of a packer with the smallest share of boxes placed safely; of equal ones the
    largest.

    ``drawn``: what is loaded at the failing step. ``displacement`` [cm], ``rotation`` [degrees]:
    the largest within 0.3 s of the placement; not a number where that is not stored. ``is_late``:
    too far only later.
    """

    packer: str
    layout: str
    step: int
    items: int
    moved_item: int | None
    displacement: float
    rotation: float
    is_late: bool
    drawn: Layout


@dataclass(frozen=True, slots=True)
class PackerCoverage:
    """Plans of a packer in the main scenario, by what is known of them.

    ``boxes_known``, ``boxes_new``: a plan, in the mean (None: there is no such plan). ``failed``:
    labelling came to no end. ``narrow``: share of plans in which a box is within 1 mm of its point
    of balance, at the failing step or anywhere in a load that stands. ``in_air``: share of the
    plans that stand in which a box has nothing under it, ``widest_gap`` how far above [cm].
    """

    packer: str
    plans: int
    known: int
    unlabelled: int
    failed: int
    boxes_known: float | None
    boxes_new: float | None
    narrow: Estimate
    in_air: Estimate
    widest_gap: float


@dataclass(frozen=True, slots=True)
class PackersSummary:
    """Everything the page of packers' plans shows; scenario S1 but for ``scenarios``.

    ``failed_by``: by packer the share of boxes placed at which each failing plan fails, and the
    number of plans. ``versions`` of packers, ``loading_order``, ``densities`` and ``turning`` are
    those of the set's manifest, ``screen`` the simulation that screened its labels, if any.
    """

    packers: tuple[PackerShares, ...]
    kinds: tuple[PackerShares, ...]
    scenarios: tuple[ScenarioShares, ...]
    pairs: tuple[PackerPair, ...]
    causes: tuple[PackerCauses, ...]
    all_causes: PackerCauses
    failed_by: Mapping[str, tuple[tuple[float, ...], int]]
    worst: tuple[WorstPlan, ...]
    coverage: tuple[PackerCoverage, ...]
    versions: Mapping[str, str]
    loading_order: str
    densities: str
    turning: str
    screen: str


def summarise(benchmark: Benchmark) -> PackersSummary:
    """Shares, pairs, causes and the worst plans of a set; every interval resamples instances.

    Raises:
        BenchmarkError: no plan of a packer has a label in S1 of whether it stands.
    """
    plans = plans_of(benchmark)
    main = plans[plans["scenario"] == str(Scenario.S1)]
    known = main[main["is_known"]]
    settled = known[known["settled"]].reset_index(drop=True)
    if settled.empty:
        raise BenchmarkError(
            "no plan of a packer in this set has a label of whether it stands; allowed: a set of "
            "benchmark build-real that is labelled, at least in part"
        )
    failing = settled[~settled["stands"]]
    causes = {
        row.layout: cause_of(benchmark.layout(row.layout, row.scenario), int(row.stands_step))
        for row in failing.drop_duplicates("layout").itertuples()
    }
    failing = failing.assign(cause=failing["layout"].map(causes))
    manifest = benchmark.manifest
    return PackersSummary(
        packers=tuple(_shares(packer, "all", own) for packer, own in _by_packer(known)),
        kinds=tuple(_kinds(known)),
        scenarios=tuple(_scenarios(plans)),
        pairs=tuple(_pairs(settled)),
        causes=tuple(_causes(packer, own) for packer, own in _by_packer(failing)),
        all_causes=_causes("all", failing),
        failed_by={
            packer: (tuple(own.loc[~own["stands"], "score"].sort_values()), len(own))
            for packer, own in _by_packer(settled)
        },
        worst=tuple(_worst(benchmark, own) for _, own in _by_packer(failing)),
        coverage=tuple(_coverage(benchmark, packer, own) for packer, own in _by_packer(main)),
        versions=manifest.get("packers", {}).get("versions", {}),
        loading_order=manifest.get("loading_order", UNKNOWN),
        densities=manifest.get("densities", UNKNOWN),
        turning=manifest.get("turning", UNKNOWN),
        screen=manifest.get("screen", ""),
    )


def _by_packer(plans: pd.DataFrame) -> Iterator[tuple[str, pd.DataFrame]]:
    for packer in PACKER_TITLES.values():
        own = plans[plans["packer"] == packer]
        if len(own):
            yield packer, own


def _shares(packer: str, kind: str, own: pd.DataFrame) -> PackerShares:
    labelled, settled = own[own["labelled"]], own[own["settled"]]
    return PackerShares(
        packer=packer,
        kind=kind,
        lists=own["list"].nunique(),
        plans=len(own),
        boxes=mean(own["items"], own["instance"]),
        within=share(labelled["within"], labelled["instance"]),
        stands=share(settled["stands"], settled["instance"]),
        score=mean(settled["score"], settled["instance"]),
        unsettled=int((own["stands_status"] == "unsettled").sum()),
    )


def _kinds(known: pd.DataFrame) -> Iterator[PackerShares]:
    for kind in (CONTAINERS, EURO_PALLETS, OTHERS, CUSTOMERS):
        for packer, own in _by_packer(known[known["kind"] == kind]):
            yield _shares(packer, kind, own)


def _scenarios(plans: pd.DataFrame) -> Iterator[ScenarioShares]:
    for packer, own in _by_packer(plans[plans["settled"]]):
        stands = own.pivot(index=["layout", "instance"], columns="scenario", values="stands")
        stands = stands.reindex(columns=[str(s) for s in Scenario]).dropna()
        instances = stands.index.get_level_values("instance")
        if len(stands):
            shares = {s: share(stands[s].astype(bool), instances) for s in stands.columns}
            yield ScenarioShares(packer, len(stands), shares)


def _pairs(settled: pd.DataFrame) -> list[PackerPair]:
    """All pairs of packers that packed at least one list both."""
    found = []
    for (first, one), (second, other) in combinations(_by_packer(settled), 2):
        columns = ["list", "instance", "stands"]
        both = one[columns].merge(other[columns], on=["list", "instance"], suffixes=("_a", "_b"))
        if len(both):
            a, b, lists = both["stands_a"], both["stands_b"], both["instance"]
            p = sign_flip(a.astype(int) - b.astype(int), lists)
            found.append((first, second, len(both), share(a & ~b, lists), share(b & ~a, lists), p))
    corrected = holm([pair[-1] for pair in found])
    return [PackerPair(*pair[:-1], p) for pair, p in zip(found, corrected, strict=True)]


def _causes(packer: str, failing: pd.DataFrame) -> PackerCauses:
    instances = failing["instance"]
    own = (failing["moved_item"] == failing["stands_step"]).fillna(False).astype(bool)
    return PackerCauses(
        packer=packer,
        plans=len(failing),
        causes={cause: share(failing["cause"] == cause, instances) for cause in Cause},
        own=share(own, instances),
    )


def _worst(benchmark: Benchmark, failing: pd.DataFrame) -> WorstPlan:
    order = failing.sort_values(["score", "items", "layout"], ascending=[True, False, True])
    row: Any = order.iloc[0]
    step, within = int(row["stands_step"]), row["failing_step"]
    layout = benchmark.layout(row["layout"], row["scenario"])
    return WorstPlan(
        packer=row["packer"],
        layout=row["layout"],
        step=step,
        items=row["items"],
        moved_item=None if pd.isna(row["moved_item"]) else int(row["moved_item"]),
        displacement=_at(row["corner_most"], step),
        rotation=_at(row["angle_most"], step),
        is_late=row["labelled"] and (pd.isna(within) or within > step),
        drawn=layout.first(step + 1),
    )


def _at(values: Any, step: int) -> float:
    """The value of a step, where one is stored."""
    return math.nan if values is None or step >= len(values) else float(values[step])


def _coverage(benchmark: Benchmark, packer: str, own: pd.DataFrame) -> PackerCoverage:
    known, new, settled = own[own["is_known"]], own[own["is_new"]], own[own["settled"]]
    standing = settled[settled["stands"]]
    cases = zip(standing["layout"], standing["scenario"], strict=True)
    gaps = [widest_gap(benchmark.layout(*case)) for case in cases]

    def boxes(plans: pd.DataFrame) -> float | None:
        return float(np.mean(plans["items"])) if len(plans) else None

    return PackerCoverage(
        packer=packer,
        plans=len(own),
        known=len(known),
        unlabelled=len(new),
        failed=len(own) - len(known) - len(new),
        boxes_known=boxes(known),
        boxes_new=boxes(new),
        narrow=share(settled["narrow"], settled["instance"]),
        in_air=share([gap > 0.0 for gap in gaps], standing["instance"]),
        widest_gap=max(gaps, default=0.0),
    )
