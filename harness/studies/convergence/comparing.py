"""Labels of the reference compared with those of changed references and of other methods."""

from __future__ import annotations

from collections import Counter
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
class Compared:
    """A changed reference, or another method, compared with the reference itself."""

    group: str
    title: str = column()
    spec: str
    value: float | None = column(about="position on an axis")
    changed: Estimate = column(
        "changed %", percent, "share with another label of the cases that no time limit ended"
    )
    changed_stable: Estimate = column("of stable %", percent, "of those that the reference holds")
    changed_unstable: Estimate = column("of unstable %", percent)
    earlier: int = column(about="cases that fail at an earlier step")
    later: int = column()
    cpu: Estimate = column("CPU ms", milliseconds)
    slowest: float = column("slowest ms", significant)
    without_verdict: Mapping[str, int] = column("without verdict", counts, notable=True)

    @property
    def equal(self) -> Estimate:
        """Share of cases with the same label."""
        changed = self.changed
        return Estimate(1.0 - changed.value, 1.0 - changed.high, 1.0 - changed.low, changed.n)

    @property
    def note(self) -> str:
        """The position as text."""
        return general(self.value)


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
    variants: Sequence[Compared]
    engines: Sequence[Compared]
    opinions: Sequence[Compared]
    disputes: Sequence[LabelDispute]
    compliant: list[Compared]
    others: list[Compared]
    swept: list[Compared]
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
    said = _answers(everything)
    swept = _answers(sweep)
    tried = [v for v in VARIANTS if v.spec in said.columns or v.spec in swept.columns]
    variants = [
        _row(v.group, v.title, v.spec, v.value, said if v.decisive else swept,
             everything if v.decisive else sweep)
        for v in tried
    ]  # fmt: skip
    engines = []
    for spec in (make_method(text).spec for text in ENGINES if canonical(text) in said.columns):
        frequency = float(dict(spec.values)["frequency"])
        title = f"{spec.engine} at {frequency:g} Hz"
        engines.append(_row(str(spec.engine), title, str(spec), frequency, said, everything))
    slow = []
    if opinions is not None:
        judges = [m for m in opinions["method"].unique() if m != BASE]  # those that began
        slow = [_row("", m, m, None, _answers(opinions), opinions) for m in judges]
    numerical = [
        v.spec for v in tried if v.group in _NUMERICAL and not _compliant(v.group, v.value)
    ]
    both = swept.join(said[[c for c in said.columns if c not in swept.columns]])
    base = everything[everything["method"] == BASE]
    lists = _lists(everything)
    any_change = share(_changed(both, numerical), lists.loc[both.index].to_numpy())
    default = _row("", "default", BASE, None, said, everything)
    numbered = [own for own in variants if own.value is not None]
    groups = Counter(own.group for own in numbered)
    swept_groups = [group for group, count in groups.items() if count > 1]
    across = min(4, len(swept_groups))
    return Found(
        reference=[
            Measured("cases", str(default.changed.n)),
            Measured("items a layout", milliseconds(mean(base["item_count"], base[ITEM_LIST]))),
            Measured(
                "stable %",
                percent(share((said[BASE] == STABLE).to_numpy(), lists.loc[said.index].to_numpy())),
            ),
            Measured("CPU ms a layout", milliseconds(default.cpu)),
            Measured("slowest, ms", significant(default.slowest)),
            *(Measured(f"CPU ms, {band}", milliseconds(time)) for band, time in _by_size(base)),
            Measured("without verdict", counts(default.without_verdict)),
            Measured(
                f"label changes under any other numerics %, n = {any_change.n}", percent(any_change)
            ),
        ],
        variants=variants,
        compliant=[own for own in variants if _compliant(own.group, own.value)],
        others=[own for own in variants if not _compliant(own.group, own.value)],
        swept=[own for own in numbered if own.group in swept_groups],
        across=across,
        size=(2.6 * across, 2.5 * -(-len(swept_groups) // across)),
        engines=engines,
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


def _row(
    group: str,
    title: str,
    spec: str,
    value: float | None,
    said: pd.DataFrame,
    results: pd.DataFrame,
) -> Compared:
    judged = said[[BASE, spec]].notna().all(axis=1)  # not in a study that is not finished
    answered = said[judged & (said[spec] != str(Status.TIMEOUT))]
    base, other = answered[BASE], answered[spec]
    changed, stable = (base != other).to_numpy(), (base == STABLE).to_numpy()
    own = results[results["method"] == spec]
    lists = _lists(results).loc[answered.index].to_numpy()
    return Compared(
        group=group,
        title=title,
        spec=spec,
        value=value,
        changed=share(changed, lists),
        changed_stable=share(changed[stable], lists[stable]),
        changed_unstable=share(changed[~stable], lists[~stable]),
        later=int(((base != STABLE) & (_step(other) > _step(base))).sum()),
        earlier=int((_step(other) < _step(base)).sum()),
        cpu=mean(1e3 * own["cpu_total"], own[ITEM_LIST]),
        slowest=float(1e3 * own["cpu_total"].max()),
        without_verdict=own[own["status"] != str(Status.DONE)]["status"].value_counts().to_dict(),
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
        tried = [v for v in VARIANTS if v.spec in table.columns]
        disputes.append(
            LabelDispute(
                layout=layout,
                scenario=scenario,
                item_count=int(base.loc[case, "item_count"]),
                label=label,
                moved=None if moved.isna().any() else (float(moved.iloc[0]), float(moved.iloc[1])),
                said={title: said.loc[case, spec] for title, spec in fine.items()},
                changes_under=[v.title for v in tried if table.loc[case, v.spec] != label]
                or [f"none of {len(tried)}"],
            )
        )
    return disputes
