"""Shares of failing plans that stand once they are changed, by way and packer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from types import SimpleNamespace

import pandas as pd

from steadyload.layouts.benchmark.dataset import Benchmark
from steadyload.layouts.sizes import FEWER, SIZES, binned
from steadyload.runs import frames as v
from steadyload.runs.labels import made_with
from steadyload.statics.load_margin import CLOSE_CALL
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share
from steadyload.studies.packed_plans import PACKER_TITLES
from steadyload.studies.repair.confirming import ENGINES, REFERENCES, SECONDS, SOFT, STIFF
from steadyload.studies.repair.plans import SEARCH_SECONDS, AllTried, Answers, Tried
from steadyload.studies.repair.ways import Way

ALL = "all"
"""Plans of all packers together, each once."""

GROUPS = ("repaired plans", "controls")
"""Plans that independent judges judge."""

FIRM = 0.95
"""A plan with at least this chance to stand stands firmly."""


class Found(SimpleNamespace):
    """All that the page shows."""

    tried: Sequence[Tried]
    made_with: Mapping[str, str]


def summarise(benchmark: Benchmark, found: AllTried) -> Found:
    """Shares and amounts by way and packer; every interval resamples published instances."""
    tried, answers = _frame(found.tried), found.answers
    shares = _shares(tried)
    together, independent = shares.loc[ALL], _independent(answers)
    until = [
        {
            "way": way,
            "out": sorted(own["out"][own["stands"]]),
            "moved": sorted(100.0 * (own["moved"] / own["boxes"])[own["stands"]]),
            "plans": len(own),
        }
        for way, own in tried.groupby("way", sort=False)
    ]
    most_out = max(tried["out"][tried["stands"]], default=0.0)
    return Found(
        plans=tried["plan"].nunique(),
        labelled=found.labelled,
        instances=tried["cluster"].nunique(),
        fewest=tried["boxes"].min(),
        most=tried["boxes"].max(),
        judges=list(tried["judge"].unique()),
        all=together.reset_index(),
        by_packer=shares.drop(ALL).reset_index(),
        shares=shares.reset_index(),
        leave=together.loc[Way.LEAVE],
        keep=together.loc[Way.KEEP],
        costs=_costs(tried),
        independent=independent.reset_index(),
        by_reference=independent.loc[STIFF],
        firm=_firm(answers),
        soft=_soft([one for one in answers if one.repaired]),
        soft_controls=_soft([one for one in answers if not one.repaired]),
        unfinished=sum(len(one.references) < len(REFERENCES) for one in answers),
        until=until,
        moving=[each for each in until if each["way"] != Way.AGAIN],
        most_out=(0.0, 10.0 * (1 + most_out // 10)),
        not_installed=found.not_installed,
        search_s=SEARCH_SECONDS,
        seconds=SECONDS,
        made_with={**made_with(benchmark), **found.made_with},
        tried=found.tried,
    )


def _frame(tried: Sequence[Tried]) -> pd.DataFrame:
    """A row a plan and way; ``out``: boxes that are left out, in per cent of all."""
    found = pd.DataFrame(
        asdict(one.changed)
        | {
            "way": one.way,
            "stands": one.changed.stands,
            "boxes": len(one.plan.layout),
            "volume": float(one.plan.layout.sizes.prod(axis=1).sum()),
            "packers": one.plan.packers,
            "cluster": one.plan.instance,
        }
        for one in tried
    ).astype({"moved": float, "distance_cm": float, "retimed": float})
    return found.assign(
        out=100.0 * found["left_out"] / found["boxes"],
        volume_out=found["volume_left_out"] * found["volume"],
        none_out=found["stands"] & (found["left_out"] == 0),
        unchanged=found["outcome"] == "unchanged",
        timeouts=found["stopped"] == "time",
    )


def _shares(tried: pd.DataFrame) -> pd.DataFrame:
    """By packer, all first, and way; amounts are of plans that stand then."""
    parts = (
        tried[[title in own for own in tried["packers"]]].assign(packer=title)
        for title in PACKER_TITLES.values()
    )
    frame, by = pd.concat([tried.assign(packer=ALL), *parts]), ["packer", "way"]
    standing, rows = frame[frame["stands"]], frame.groupby(by, sort=False)
    found = {
        "stands": v.share(frame, "stands", by),
        "none_out": v.share(frame, "none_out", by),
        "boxes_out": v.ratio(standing, "left_out", "boxes", by),
        "volume_out": v.ratio(standing, "volume_out", "volume", by),
        "moved_median": standing.groupby(by)["moved"].median(),
        "moved": v.mean(standing, "moved", by),
        "moved_by": v.ratio(standing[standing["moved"] > 0], "distance_cm", "moved", by),
        "retimed": v.mean(standing, "retimed", by),
        "unchanged": rows["unchanged"].sum(),
        "timeouts": rows["timeouts"].sum(),
        "failed": rows.size() - rows["unchanged"].sum(),
        "repaired": rows["stands"].sum(),
    }
    return pd.DataFrame(found, rows.size().index)


def _costs(tried: pd.DataFrame) -> pd.DataFrame:
    """CPU seconds by number of boxes, all first, and way."""
    place, names = binned(tried["boxes"], (FEWER, *SIZES))
    sized = tried.assign(boxes=[names[bin_] for bin_ in place]).iloc[place.argsort(kind="stable")]
    rows = pd.concat([tried.assign(boxes=ALL), sized]).groupby(["boxes", "way"], sort=False)
    seconds = rows["seconds"]
    found = {
        "cases": seconds.size(), "median": seconds.median(), "ninety": seconds.quantile(0.9),
        "worst": seconds.max(),
    }  # fmt: skip
    return pd.DataFrame(found).reset_index()


def _independent(answers: Sequence[Answers]) -> pd.DataFrame:
    """By judge: repaired plans and controls that it has come to; no answer is no yes."""
    said = pd.DataFrame(
        [
            (title, one.repaired, judged.stands, not judged.is_known, one.plan.instance)
            for one in answers
            for title, judged in {**one.engines, **one.references}.items()
        ],
        columns=["judge", "repaired", "stands", "unknown", "cluster"],
    )
    judges, found = pd.Index([*ENGINES, *REFERENCES], name="judge"), {}
    for group, repaired in (("repaired", True), ("control", False)):
        own = said[said["repaired"] == repaired]
        rows = own.groupby("judge")["unknown"]
        found[f"cases:{group}"] = rows.size().reindex(judges, fill_value=0)
        found[f"stands:{group}"] = v.share(own, "stands", ["judge"])
        found[f"unknown:{group}"] = rows.sum().reindex(judges, fill_value=0)
    return pd.DataFrame(found, judges)


def _firm(answers: Sequence[Answers]) -> pd.DataFrame:
    """Margins of plans, and chances to stand where each centre of mass is off by 5 mm (s.d.)."""
    frame = pd.DataFrame(
        [asdict(one.firmness) | {"cluster": one.plan.instance} for one in answers],
        columns=["margin_cm", "as_planned", "chance", "cluster"],
        index=pd.Index([GROUPS[not one.repaired] for one in answers], name="group"),
    ).astype({"margin_cm": float, "as_planned": bool, "chance": float})
    frame = frame.assign(close=frame["margin_cm"] < CLOSE_CALL, firm=frame["chance"] >= FIRM)
    rows, planned = frame.groupby("group", sort=False), frame[frame["as_planned"]]
    found = {
        "cases": rows.size(),
        "as_planned": rows["as_planned"].sum(),
        "margin_median": planned.groupby("group")["margin_cm"].median(),
        "close": v.share(planned, "close", ["group"]),
        "p_stands": v.mean(planned, "chance", ["group"]),
        "firm": v.share(planned, "firm", ["group"]),
    }
    return pd.DataFrame(found, rows.size().index).reset_index()


def _soft(own: Sequence[Answers]) -> Estimate:
    """Plans that fall by the softer reference, of those that stand by the stiffer one."""
    both = (one for one in own if len(one.references) == len(REFERENCES))
    stood = [one for one in both if one.references[STIFF].stands]
    return share(
        [not one.references[SOFT].stands for one in stood], [one.plan.instance for one in stood]
    )


def as_csv(tried: Sequence[Tried]) -> str:
    """All plans in all ways, a line each; what is not known is empty."""
    lines = [
        {
            "packers": "; ".join(one.plan.packers),
            "plan": changed.plan,
            "boxes": len(one.plan.layout),
            "way": changed.way,
            "outcome": changed.outcome,
            "judge": changed.judge,
            "failing_step_before": changed.step_before,
            "boxes_left_out": changed.left_out if changed.stands else None,
            "volume_left_out_share": f"{changed.volume_left_out:.4f}" if changed.stands else None,
            "boxes_moved": changed.moved,
            "distance_cm": None if changed.distance_cm is None else f"{changed.distance_cm:.1f}",
            "boxes_loaded_at_another_time": changed.retimed,
            "order_alone": changed.by_order_alone if changed.stands else None,
            "cpu_s": f"{changed.seconds:.3f}",
            "stopped": changed.stopped,
        }
        for one in tried
        for changed in [one.changed]
    ]
    return pd.DataFrame(lines, dtype=object).to_csv(index=False, lineterminator="\n")
