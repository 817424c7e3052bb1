"""Study of engines: their agreement, and the effect and cost of each option."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import pandas as pd

from steadyload.engines.registry import engines_here, world_class
from steadyload.methods.contract.method import Status
from steadyload.methods.registry import make_method
from steadyload.progress import NamedProgress, silent
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.pool import Executor
from steadyload.runs.results import load_results
from steadyload.runs.runner import run_study
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share
from steadyload.statistics.placed import items_placed_by_case

BASE = "t_max=0.3,eps_t=10,eps_r=10,friction=0.5,between_steps=reseat"
"""Untuned parameters: time, thresholds and friction of the reference simulation, nothing else."""

FREQUENCIES = (60, 90, 120, 240, 480)

OPTIONS: dict[str, tuple[str, str]] = {
    "lateral shrink 0.01 mm": ("samples=1", "samples=1,shrink=0.01mm"),
    "lateral shrink 0.1 mm": ("samples=1", "samples=1,shrink=0.1mm"),
    "10 samples a placement instead of 1": ("samples=1", "samples=10"),
    "stop at rest, 0.01 m/s": ("samples=10", "samples=10,rest_speed=0.01"),
    "stop at rest, 0.03 m/s": ("samples=10", "samples=10,rest_speed=0.03"),
    "early exit at twice the threshold (adams)": (
        "criterion=adams,samples=10", "criterion=adams,samples=10,early_exit=2",
    ),
    "10 solver iterations": ("samples=1", "samples=1,solver_iterations=10"),
    "local scope": ("samples=1", "samples=1,scope=local"),
    "local scope, shrink 0.01 mm, stop at rest 0.01 m/s": (
        "samples=10", "samples=10,scope=local,shrink=0.01mm,rest_speed=0.01",
    ),
    "carry instead of reseat": ("samples=1", "samples=1,between_steps=carry"),
}  # fmt: skip
"""Option -> (parameters without it, parameters with it)."""

_OPTION_FREQUENCY = 240
_SHARD = 25


@dataclass(frozen=True, slots=True)
class EngineAgreement:
    """Agreement between engines at one frequency [Hz]; ``cpu`` in ms a layout."""

    frequency: int
    stable: Mapping[str, Estimate]
    cpu: Mapping[str, Estimate]
    agreement: Mapping[tuple[str, str], Estimate]


@dataclass(frozen=True, slots=True)
class OptionEffect:
    """Effect of an option on one engine.

    ``changed``: share of layouts with another failing step. ``ratio``: CPU time with the option
    over that without. ``cpu``: with it, in ms a layout.
    """

    option: str
    engine: str
    changed: Estimate
    ratio: float
    cpu: Estimate


@dataclass(frozen=True)
class Drawn:
    """Generated layouts: how many, the seed that they are drawn with, and their largest size."""

    count: int
    seed: int
    most_items: int | None = None


@dataclass(frozen=True, slots=True)
class _Answers:
    """Verdicts of a method on all layouts (failing step, J when stable, or status), and CPU ms."""

    said: list[int | str]
    cpu: list[float]
    items: list[int]


def _ask(
    name: str,
    specs: Sequence[str],
    drawn: Drawn,
    work: Path,
    workers: int | Executor,
    progress: NamedProgress,
) -> list[_Answers]:
    """Answers of all methods, judged where they are missing; methods take turns at some layouts."""
    asked = [str(make_method(spec).spec) for spec in specs]
    definition = StudyDefinition(
        f"engines, {name}",
        tuple(dict.fromkeys(asked)),
        generated=drawn.count,
        seed=drawn.seed,
        max_items=drawn.most_items,
        shard_size=_SHARD,
    )
    run_study(definition, work / name, workers=workers, progress=lambda *of: progress(name, *of))
    columns = ["layout", "method", "status", "failing_step", "item_count", "cpu_total"]
    rows = load_results(work / name, columns).sort_values("layout")
    by_method = {spec: _answers(own) for spec, own in rows.groupby("method")}
    return [by_method[spec] for spec in asked]


def _answers(rows: pd.DataFrame) -> _Answers:
    items = rows["item_count"].tolist()
    steps = items_placed_by_case(rows["failing_step"], rows["item_count"]).tolist()
    done = (rows["status"] == str(Status.DONE)).tolist()
    said = [step if ok else why for step, ok, why in zip(steps, done, rows["status"], strict=True)]
    return _Answers(said, (1e3 * rows["cpu_total"]).tolist(), items)


def engine_agreement(
    drawn: Drawn,
    work: Path,
    frequencies: Sequence[int] = FREQUENCIES,
    *,
    workers: int | Executor = 1,
    progress: NamedProgress = silent,
) -> list[EngineAgreement]:
    """Share of equal failing steps between every two 3-D engines, by frequency, with costs.

    Args:
        drawn: the layouts.
        work: folder of the run folder; an interrupted run is resumed.
        frequencies: substeps a second.
        workers: see :func:`steadyload.runs.runner.run_study`.
        progress: called with what is done, the rows done and those to be done.
    """
    engines = _spatial_engines()
    pairs = [(frequency, engine) for frequency in frequencies for engine in engines]
    specs = [f"simulation@{e}:{BASE},frequency={f},samples=1" for f, e in pairs]
    answers = _ask("agreement", specs, drawn, work, workers, progress)
    every = dict(zip(pairs, answers, strict=True))
    return [_agreement(f, {e: every[f, e] for e in engines}) for f in frequencies]


def _agreement(frequency: int, found: Mapping[str, _Answers]) -> EngineAgreement:
    return EngineAgreement(
        frequency=frequency,
        stable={
            e: share([s == n for s, n in zip(a.said, a.items, strict=True)])
            for e, a in found.items()
        },
        cpu={e: mean(a.cpu) for e, a in found.items()},
        agreement={
            (a, b): share(_equal(found[a].said, found[b].said)) for a, b in combinations(found, 2)
        },
    )


def option_effects(
    drawn: Drawn,
    work: Path,
    *,
    workers: int | Executor = 1,
    progress: NamedProgress = silent,
) -> list[OptionEffect]:
    """Effect of each option on verdicts and CPU time, per engine that does not ignore it.

    Args: as those of :func:`engine_agreement`.
    """
    asked = [
        (title, engine, *_without_and_with(engine, without, given))
        for title, (without, given) in OPTIONS.items()
        for engine in _spatial_engines()
        if not ("solver_iterations" in given and _ignores(engine, "solver_iterations"))
    ]
    specs = [spec for *_, without, given in asked for spec in (without, given)]
    answers = iter(_ask("options", specs, drawn, work, workers, progress))
    return [_effect(title, engine, next(answers), next(answers)) for title, engine, *_ in asked]


def _without_and_with(engine: str, without: str, given: str) -> tuple[str, str]:
    """Specs without an option and with it."""
    base = f"simulation@{engine}:{BASE},frequency={_OPTION_FREQUENCY}"
    start = base.replace(",between_steps=reseat", "") if "carry" in given else base
    return f"{base},{without}", f"{start},{given}"


def _effect(title: str, engine: str, before: _Answers, after: _Answers) -> OptionEffect:
    changed = share([not e for e in _equal(before.said, after.said)])
    return OptionEffect(title, engine, changed, sum(after.cpu) / sum(before.cpu), mean(after.cpu))


def _spatial_engines() -> list[str]:
    return [e for e in engines_here() if world_class(e).capabilities.dimensions == 3]


def _ignores(engine: str, setting: str) -> bool:
    return world_class(engine).capabilities.settings[setting].support == "ignored"


def _equal(first: Sequence[int | str], second: Sequence[int | str]) -> list[bool]:
    """Mask of cases with the same failing step; a missing verdict equals nothing."""
    return [a == b and isinstance(a, int) for a, b in zip(first, second, strict=True)]
