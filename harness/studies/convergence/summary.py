"""Typed results on the convergence of the reference's labels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from steadyload.methods.contract.method import Status
from steadyload.methods.registry import make_method
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share
from steadyload.studies.convergence.study import BASE, ENGINES, LOOKED_AT, VARIANTS, canonical

STABLE = "stable"
_NUMERICAL = frozenset(
    {
        "tolerance [m]", "stiffness [N/m]", "damping time [s]", "depth of full damping [m]",
        "stiction speed [m/s]", "longest step [s]",
    }
)  # fmt: skip
_FINE = 480.0
"""Frequency [Hz] from which engines are shown beside a disputed label."""

_SOFT = 1e8
"""Below this stiffness [N/m] a change is one of the model, not of its numerics."""


@dataclass(frozen=True, slots=True)
class ConvergenceRow:
    """A changed reference, or another method, compared with the reference itself.

    ``changed``: share of layouts with another label; ``changed_stable`` of those that the reference
    calls stable, ``changed_unstable`` of the others. ``earlier``, ``later``: layouts that fail at
    an earlier or later step. ``cpu``, ``slowest`` in ms a layout. ``value``: position on an axis.
    """

    group: str
    title: str
    spec: str
    value: float | None
    changed: Estimate
    changed_stable: Estimate
    changed_unstable: Estimate
    earlier: int
    later: int
    cpu: Estimate
    slowest: float
    without_verdict: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class LabelDispute:
    """A layout on which another method differs: failing steps, ``stable`` or a status.

    ``displacement_cm`` and ``rotation_deg`` are those of the reference at its failing step.
    ``changes_under`` names those changes of the reference, of ``tried`` ones, that change the
    label, too.
    """

    layout: str
    item_count: int
    label: str
    displacement_cm: float | None
    rotation_deg: float | None
    said: Mapping[str, str]
    tried: int
    changes_under: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Convergence:
    """Convergence of the reference's labels.

    ``any_change``: share of layouts whose label changes under any change of the numerics.
    ``by_size``: CPU time of the reference in ms a layout, by number of items.
    """

    items: Estimate
    stable: Estimate
    reference: ConvergenceRow
    variants: tuple[ConvergenceRow, ...]
    engines: tuple[ConvergenceRow, ...]
    opinions: tuple[ConvergenceRow, ...]
    any_change: Estimate
    by_size: tuple[tuple[str, Estimate], ...]
    disputes: tuple[LabelDispute, ...]


def convergence(
    everything: pd.DataFrame, sweep: pd.DataFrame, opinions: pd.DataFrame | None = None
) -> Convergence:
    """The summary of the results of :func:`convergence_studies`."""
    said = _answers(everything)
    swept = _answers(sweep)
    variants = [
        _row(v.group, v.title, v.spec, v.value, said if v.decisive else swept,
             everything if v.decisive else sweep)
        for v in VARIANTS
    ]  # fmt: skip
    engines = []
    for spec in (make_method(text).spec for text in ENGINES):
        frequency = float(dict(spec.values)["frequency"])
        title = f"{spec.engine} at {frequency:g} Hz"
        engines.append(_row(str(spec.engine), title, str(spec), frequency, said, everything))
    slow = []
    if opinions is not None:
        judges = [m for m in opinions["method"].unique() if m != BASE]  # those that began
        slow = [_row("", m, m, None, _answers(opinions), opinions) for m in judges]
    numerical = [
        v.spec
        for v in VARIANTS
        if v.group in _NUMERICAL
        and not (v.group == "stiffness [N/m]" and v.value is not None and v.value < _SOFT)
    ]
    both = swept.join(said[[c for c in said.columns if c not in swept.columns]])
    base = everything[everything["method"] == BASE]
    return Convergence(
        items=mean(base["item_count"]),
        stable=share((said[BASE] == STABLE).to_numpy()),
        reference=_row("", "default", BASE, None, said, everything),
        variants=tuple(variants),
        engines=tuple(engines),
        opinions=tuple(slow),
        any_change=share(_changed(both, numerical)),
        by_size=tuple(_by_size(base)),
        disputes=tuple(_disputes(said, both, base)),
    )


def _answers(results: pd.DataFrame) -> pd.DataFrame:
    """Verdict of every method (column) on every layout: failing step, ``stable``, or a status."""
    step = results["failing_step"].astype(object).where(results["failing_step"].notna(), STABLE)
    text = step.map(str).where(results["status"] == str(Status.DONE), results["status"])
    frame = results.assign(said=text)
    return frame.pivot(index="layout", columns="method", values="said")


def _row(
    group: str,
    title: str,
    spec: str,
    value: float | None,
    said: pd.DataFrame,
    results: pd.DataFrame,
) -> ConvergenceRow:
    answered = said[said[spec].notna() & said[BASE].notna()]  # of a study that is not finished
    base, other = answered[BASE], answered[spec]
    changed, stable = (base != other).to_numpy(), (base == STABLE).to_numpy()
    own = results[results["method"] == spec]
    return ConvergenceRow(
        group=group,
        title=title,
        spec=spec,
        value=value,
        changed=share(changed),
        changed_stable=share(changed[stable]),
        changed_unstable=share(changed[~stable]),
        later=int(((base != STABLE) & (_step(other) > _step(base))).sum()),
        earlier=int((_step(other) < _step(base)).sum()),
        cpu=mean(1e3 * own["cpu_total"]),
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
    return [(band, mean(1e3 * part["cpu_total"])) for band, part in parts.items() if len(part)]


def _disputes(said: pd.DataFrame, swept: pd.DataFrame, base: pd.DataFrame) -> list[LabelDispute]:
    """Every layout on which a method of :data:`LOOKED_AT` differs, and its label's changes."""
    base = base.set_index("layout")
    specs = [canonical(text) for text in LOOKED_AT]
    fine = {
        f"{method.engine} {values['frequency']} Hz": str(method)
        for method in (make_method(text).spec for text in ENGINES)
        if float((values := dict(method.values))["frequency"]) >= _FINE
    }
    disputes = []
    for layout in said.index[_changed(said, specs)]:
        label, row = said.loc[layout, BASE], base.loc[layout]
        table = swept if layout in swept.index else said
        tried = [v for v in VARIANTS if v.spec in table.columns]
        disputes.append(
            LabelDispute(
                layout=str(layout),
                item_count=int(row["item_count"]),
                label=label,
                displacement_cm=_number(row["displacement_cm"]),
                rotation_deg=_number(row["rotation_deg"]),
                said={title: said.loc[layout, spec] for title, spec in fine.items()},
                tried=len(tried),
                changes_under=tuple(v.title for v in tried if table.loc[layout, v.spec] != label),
            )
        )
    return disputes


def _number(value: float) -> float | None:
    return None if pd.isna(value) else float(value)
