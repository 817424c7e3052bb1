"""Labels of the reference compared with those of changed references and of other methods."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import SimpleNamespace

import numpy as np
import pandas as pd

from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.methods.contract.method import Status
from steadyload.methods.registry import make_method
from steadyload.reports.columns import (
    cell,
    column,
    counts,
    general,
    markdown,
    milliseconds,
    names,
    percent,
    row,
    significant,
)
from steadyload.runs import frames as v
from steadyload.runs.costs import CostKind, CostSource
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share
from steadyload.studies.convergence.judging import (
    BASE,
    ENGINES,
    ITEM_LIST,
    LOOKED_AT,
    SECONDS,
    VARIANTS,
    canonical,
)

STABLE = "stable"
_STIFFNESS = "stiffness [N/m]"
_NUMERICAL = frozenset(
    {
        "tolerance [m]", _STIFFNESS, "damping time [s]", "depth of full damping [m]",
        "stiction speed [m/s]", "longest step [s]",
    }
)  # fmt: skip
_FINE = 480.0
"""Frequency [Hz] from which engines are shown beside a disputed label."""

_SOFT = 1e8
"""Below this stiffness [N/m] a change is one of the model, not of its numerics."""


@row
class Measured:
    """A quantity of the reference."""

    what: str = column(" ")
    measured: str = column(left=False)


def _moved(movement: tuple[float, float] | None) -> str:
    return cell(movement and "{:.1f} cm, {:.1f} deg".format(*movement))


@row
class LabelDispute:
    """A case on which another method differs: failing steps, ``stable`` or a status."""

    layout: str = column(form=markdown)
    scenario: str = column()
    item_count: int = column("items")
    label: str = column("reference", left=False)
    moved: tuple[float, float] | None = column(
        form=_moved, about="cm and degrees, of the reference at its failing step"
    )
    said: Mapping[str, str] = column("{}")
    changes_under: Sequence[str] = column(
        "label changes under", names, "changes of the reference that change the label, too"
    )


class Found(SimpleNamespace):
    """All that the page shows."""

    reference: Sequence[Measured]
    disputes: Sequence[LabelDispute]
    made_with: Mapping[str, str]


def compare(
    made_with: Mapping[str, str],
    everything: pd.DataFrame,
    sweep: pd.DataFrame,
    opinions: pd.DataFrame | None = None,
    *,
    asked: str = "within",
) -> Found:
    """The comparison of the results of :func:`.convergence_studies`, whose methods have their names
    without the question ``asked``; methods that have not judged are left out.
    """
    said, swept = _answers(everything), _answers(sweep)
    tried = [one for one in VARIANTS if one.spec in said.columns or one.spec in swept.columns]
    on_all, on_fewer = _compared(everything), _compared(sweep)
    variants = pd.DataFrame(
        [(on_all if own.decisive else on_fewer).loc[own.spec] for own in tried]
    ).assign(
        group=[own.group for own in tried],
        title=[own.title for own in tried],
        value=[own.value for own in tried],
    )
    soft = np.array([_compliant(own.group, own.value) for own in tried])
    numbers = variants["value"].notna().groupby(variants["group"]).transform("sum")
    several = variants[variants["value"].notna() & (numbers > 1)]
    across = min(4, several["group"].nunique())
    specs = [make_method(text).spec for text in ENGINES if canonical(text) in said.columns]
    rates = [float(dict(spec.values)["frequency"]) for spec in specs]
    engines = on_all.loc[list(map(str, specs))].assign(
        group=[str(spec.engine) for spec in specs],
        title=[f"{spec.engine} at {rate:g} Hz" for spec, rate in zip(specs, rates, strict=True)],
        note=[general(rate) for rate in rates],
        equal=lambda own: own["label_changed"].map(
            lambda e: Estimate(1.0 - e.value, 1.0 - e.high, 1.0 - e.low, e.n)
        ),
    )
    slow = pd.DataFrame()
    if opinions is not None:
        slow = _compared(opinions).drop(BASE)  # those that began
        slow = slow.assign(title=slow.index)
    numerical = [
        own.spec
        for own in tried
        if own.group in _NUMERICAL and not _compliant(own.group, own.value)
    ]
    both = swept.join(said[[c for c in said.columns if c not in swept.columns]])
    base = everything[everything["method"] == BASE]
    lists = _lists(everything)
    any_change = share(_changed(both, numerical), lists.loc[both.index].to_numpy())
    default = on_all.loc[BASE]
    return Found(
        reference=[
            Measured("cases", str(default.label_changed.n)),
            Measured("items a layout", milliseconds(mean(base["item_count"], base[ITEM_LIST]))),
            Measured(
                "stable %",
                percent(share((said[BASE] == STABLE).to_numpy(), lists.loc[said.index].to_numpy())),
            ),
            Measured("CPU ms a layout", milliseconds(default.cpu)),
            Measured("slowest, ms", significant(default.slowest)),
            *(Measured(f"CPU ms, {band}", milliseconds(time)) for band, time in _by_size(base)),
            Measured("without verdict", counts(default.lost if default.notna().lost else {})),
            Measured(
                f"label changes under any other numerics %, n = {any_change.n}", percent(any_change)
            ),
        ],
        compliant=variants[soft],
        others=variants[~soft],
        swept=several.to_dict("records"),
        across=across,
        size=(2.6 * across, 2.5 * -(-several["group"].nunique() // across)),
        engines=engines,
        agreeing=engines.to_dict("records"),
        opinions=slow,
        any_change=any_change,
        item_lists=lists.nunique(),
        disputes=_disputes(said, both, base),
        made_with=made_with,
        asked=asked,
        costs=CostSource(CostKind.ONE_PROCESS).explained(),
        seconds=SECONDS,
    )


def _compliant(group: str, value: float | None) -> bool:
    return group == _STIFFNESS and value is not None and value < _SOFT


def _answers(results: pd.DataFrame) -> pd.DataFrame:
    """Verdict of every method (column) on every case: failing step, ``stable``, or a status."""
    step = results["failing_step"].astype(object).where(results["failing_step"].notna(), STABLE)
    text = step.map(str).where(results["status"] == str(Status.DONE), results["status"])
    frame = results.assign(said=text)
    return frame.pivot(index=KEYS, columns="method", values="said")


def _lists(results: pd.DataFrame) -> pd.Series:
    """The item list of every case."""
    return results.drop_duplicates(KEYS).set_index(KEYS)[ITEM_LIST]


def _compared(results: pd.DataFrame) -> pd.DataFrame:
    """By method, how its labels differ from those of the reference on the cases of a run.

    ``label_changed``, ``stable_changed``, ``unstable_changed``: share with another label of the
    cases that no time limit ended, of all and of those that the reference calls so; ``earlier``,
    ``later``: cases that fail at such a step; ``cpu``, ``slowest`` [ms].
    """
    said = _answers(results)
    frame = said.melt(ignore_index=False, value_name="said").reset_index()
    label = pd.Series(said[BASE].loc[pd.MultiIndex.from_frame(frame[KEYS])].to_numpy())
    frame = frame.assign(
        cluster=_lists(results).loc[pd.MultiIndex.from_frame(frame[KEYS])].to_numpy(),
        changed=frame["said"] != label,
        earlier=_step(frame["said"]) < _step(label),
        later=(label != STABLE) & (_step(frame["said"]) > _step(label)),
        is_stable=label == STABLE,
    )
    # Some have not been judged in a study that is not finished.
    frame = frame[frame["said"].notna() & label.notna() & (frame["said"] != Status.TIMEOUT)]
    own = results.assign(cpu=1e3 * results["cpu_total"], cluster=results[ITEM_LIST])
    lost = own[own["status"] != Status.DONE].groupby("method")["status"]
    methods = list(results["method"].unique())
    directions = frame.groupby("method")[["earlier", "later"]].sum()
    return pd.DataFrame(
        {
            "label_changed": v.share(frame, "changed", ["method"]),
            "stable_changed": v.share(frame[frame["is_stable"]], "changed", ["method"]),
            "unstable_changed": v.share(frame[~frame["is_stable"]], "changed", ["method"]),
            "earlier": directions["earlier"],
            "later": directions["later"],
            "cpu": v.mean(own, "cpu", ["method"]),
            "slowest": own.groupby("method")["cpu"].max(),
            "lost": lost.agg(lambda own: own.value_counts().to_dict()),
        },
        index=methods,
    )


def _step(said: pd.Series) -> pd.Series:
    """Failing steps as numbers; a stable layout fails after all others, a missing verdict never."""
    return pd.to_numeric(said.where(said != STABLE, "1000000"), errors="coerce")


def _changed(said: pd.DataFrame, specs: Sequence[str]) -> np.ndarray:
    return said[list(specs)].ne(said[BASE], axis=0).any(axis=1).to_numpy()


def _by_size(base: pd.DataFrame) -> list[tuple[str, Estimate]]:
    """CPU time of the reference by number of items."""
    bands = ((1, 5), (6, 10), (11, 15), (16, 20))
    parts = {f"{a} to {b} items": base[base["item_count"].between(a, b)] for a, b in bands}
    return [
        (band, mean(1e3 * part["cpu_total"], part[ITEM_LIST]))
        for band, part in parts.items()
        if len(part)
    ]


def _disputes(said: pd.DataFrame, swept: pd.DataFrame, base: pd.DataFrame) -> list[LabelDispute]:
    """Every case on which a method of :data:`LOOKED_AT` differs, and its label's changes."""
    base = base.set_index(KEYS)
    specs = [spec for spec in map(canonical, LOOKED_AT) if spec in said.columns]
    fine = {
        f"{method.engine} {values['frequency']} Hz": str(method)
        for method in (make_method(text).spec for text in ENGINES)
        if str(method) in said.columns
        and float((values := dict(method.values))["frequency"]) >= _FINE
    }
    disputes = []
    for case in said.index[_changed(said, specs)]:
        layout, scenario = map(str, case)
        label = said.loc[case, BASE]
        table = swept if case in swept.index else said
        moved = base.loc[case, ["displacement_cm", "rotation_deg"]]
        tried = [one for one in VARIANTS if one.spec in table.columns]
        disputes.append(
            LabelDispute(
                layout=layout,
                scenario=scenario,
                item_count=int(base.loc[case, "item_count"]),
                label=label,
                moved=None if moved.isna().any() else (float(moved.iloc[0]), float(moved.iloc[1])),
                said={title: said.loc[case, spec] for title, spec in fine.items()},
                changes_under=[one.title for one in tried if table.loc[case, one.spec] != label]
                or [f"none of {len(tried)}"],
            )
        )
    return disputes
