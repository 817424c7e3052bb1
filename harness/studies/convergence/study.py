"""Convergence study: the reference's labels under other numerics and models, and other methods."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from steadyload.methods.method import Status
from steadyload.methods.registry import make_method
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.pool import IN_THIS_PROCESS
from steadyload.runs.provenance import provenance_lines
from steadyload.runs.results import load_manifest, load_results
from steadyload.runs.runner import run_study
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share
from steadyload.studies.convergence.records import (
    Convergence,
    ConvergenceRow,
    LabelDispute,
)

BASE = "label@reference"
SEED = 7
SAMPLE = 50
"""Number of layouts for slow methods."""

SWEPT = 200
"""Number of layouts for the variants that are not :attr:`Variant.decisive`."""

_STIFFNESSES = (1e5, 1e6, 1e7, 3e7, 1e8, 3e8, 3e9, 1e10)
_STIFFNESS, _MOST_RATE = 1e9, 3e4
"""Of the default contacts [N/m, rad/s]. Both change together: one limits heavy items, one light."""


@dataclass(frozen=True, slots=True)
class Variant:
    """One change of the reference.

    ``value``: position on the axis of a plot, where it is a number. A ``decisive`` change is tried
    on all layouts, any other on the first :data:`SWEPT`.
    """

    group: str
    title: str
    changes: str
    value: float | None = None
    decisive: bool = False

    @property
    def spec(self) -> str:
        """The changed method."""
        return str(make_method(f"{BASE}:{self.changes}").spec)


def _sweep(
    group: str, parameter: str, values: Sequence[float], decisive: Sequence[float] = ()
) -> list[Variant]:
    return [
        Variant(group, f"{parameter} {v:g}", f"{parameter}={v!r}", v, v in decisive) for v in values
    ]


VARIANTS: tuple[Variant, ...] = (
    *_sweep("tolerance [m]", "tolerance", (1e-5, 1e-6, 1e-8), (1e-6, 1e-8)),
    *(
        Variant(
            "stiffness [N/m]",
            f"stiffness {k:g}",
            f"stiffness={k!r},most_rate={_MOST_RATE * math.sqrt(k / _STIFFNESS)!r}",
            k,
            k == 1e8,
        )
        for k in _STIFFNESSES
    ),
    *_sweep("damping time [s]", "damping_time", (3e-4, 1e-3, 1e-2)),
    *_sweep("depth of full damping [m]", "damping_depth", (1e-9, 1e-7, 1e-6)),
    *_sweep("stiction speed [m/s]", "stiction_speed", (1e-5, 1e-3)),
    *_sweep("longest step [s]", "most_time", (1e-3,)),
    *_sweep("position jitter [m]", "jitter", (1e-6, 1e-5, 1e-4)),
    *_sweep("lateral shrink [m]", "shrink", (1e-5, 1e-4)),
    *_sweep("friction", "friction", (0.4, 0.6)),
    Variant("friction", "dynamic friction 0.375", "dynamic_share=0.75"),
    *_sweep("time [s]", "t_max", (0.2, 0.27, 0.33, 0.6)),
    Variant("thresholds", "9 cm and 9 degrees", "eps_t=9,eps_r=9"),
    Variant("thresholds", "11 cm and 11 degrees", "eps_t=11,eps_r=11"),
    Variant("loading", "carry instead of reseat", "between_steps=carry"),
    Variant("loading", "criterion of the paper", "criterion=paper,early_exit=0"),
)
"""Every change of the reference in the study; groups are tables and plots."""

ENGINES: tuple[str, ...] = tuple(
    f"label@{engine}:frequency={frequency}"
    for engine, frequencies in (
        ("mujoco", (90, 240, 480, 1000)),
        ("bullet", (90, 240, 480, 1000)),
        ("dart", (90, 240, 480)),
    )
    for frequency in frequencies
)
"""Other methods under the label's criterion, on all layouts."""

OPINIONS: tuple[str, ...] = (
    "label@reference:integrator=radau,tolerance=1e-6",  # the engine's own are a hundredth of these
    "label@reference:contact=adams",
)
"""Slow methods, on a sample of the layouts."""

SECOND_MODEL = "label@drake"
"""Another slow method, with a contact model of its own; optional."""

LOOKED_AT = ("label@mujoco:frequency=480", "label@bullet:frequency=480")
"""Methods whose every disagreement with the reference the page lists."""


def convergence_studies(
    layouts: int, sample: int = SAMPLE, opinions: Sequence[str] = OPINIONS
) -> dict[str, StudyDefinition]:
    """Definitions of the runs, by the name of their folder; all on the first of the same layouts.

    Args:
        layouts: number for the reference, its decisive variants and the other engines.
        sample: number for the slow methods; 0 leaves them out.
        opinions: the slow methods.
    """
    decisive = [v.spec for v in VARIANTS if v.decisive]
    other = [v.spec for v in VARIANTS if not v.decisive]
    parts = {
        "all": ([BASE, *decisive, *map(_canonical, ENGINES)], layouts, 30),
        "sweep": ([BASE, *other], min(SWEPT, layouts), 30),
    }
    if sample:
        parts["opinions"] = ([BASE, *map(_canonical, opinions)], sample, 5)
    return {
        name: StudyDefinition(name, tuple(methods), generated=count, seed=SEED, shard_size=size)
        for name, (methods, count, size) in parts.items()
    }


def run_convergence(
    directory: Path,
    *,
    layouts: int,
    sample: int = SAMPLE,
    opinions: Sequence[str] = OPINIONS,
    workers: int = IN_THIS_PROCESS,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Convergence:
    """Compute the missing rows in ``directory`` and summarise all.

    Args:
        directory: folder of the run folders; an interrupted run is resumed.
        layouts: see :func:`convergence_studies`.
        sample: likewise.
        opinions: likewise.
        workers: see :func:`steadyload.runs.runner.run_study`.
        progress: called with rows done and rows in all, of one folder after the other.

    Raises:
        EngineNotInstalledError: a method's engine is missing.
        ResultsError, WorkerDiedError: see :func:`steadyload.runs.runner.run_study`.
    """
    for spec in opinions:
        make_method(
            spec
        ).prepare()  # so that a missing library is reported at once, not after an hour
    frames = []
    for name, study in convergence_studies(layouts, sample, opinions).items():
        directory.mkdir(parents=True, exist_ok=True)
        run_study(study, directory / name, workers=workers, progress=progress)
        frames.append(load_results(directory / name))
    return convergence(*frames)


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
    for text in ENGINES:
        spec = make_method(text).spec
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


def made_with(directory: Path) -> dict[str, str]:
    """Provenance of the results in ``directory``, as a page shows it, separately by part."""
    lines: dict[str, str] = {}
    for folder in sorted(directory.glob("*/manifest.json")):
        manifest = load_manifest(folder.parent)
        study = manifest["study"]
        lines[f"{study['name']}: layouts"] = f"{study['generated']} generated, seed {study['seed']}"
        for key, text in provenance_lines(manifest).items():
            lines[f"{study['name']}: {key}"] = text
    return lines


def _canonical(text: str) -> str:
    return str(make_method(text).spec)


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
    rows = []
    for low, high in bands:
        part = base[base["item_count"].between(low, high)]
        if len(part):
            rows.append((f"{low} to {high} items", mean(1e3 * part["cpu_total"])))
    return rows


def _disputes(said: pd.DataFrame, swept: pd.DataFrame, base: pd.DataFrame) -> list[LabelDispute]:
    """Every layout on which a method of :data:`LOOKED_AT` differs, and its label's changes."""
    base = base.set_index("layout")
    specs = [_canonical(text) for text in LOOKED_AT]
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
                displacement=None if pd.isna(row["displacement"]) else float(row["displacement"]),
                rotation=None if pd.isna(row["rotation"]) else float(row["rotation"]),
                said={title: said.loc[layout, spec] for title, spec in fine.items()},
                tried=len(tried),
                changes_under=tuple(v.title for v in tried if table.loc[layout, v.spec] != label),
            )
        )
    return disputes
