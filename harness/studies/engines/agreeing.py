"""Agreement of engines, and the effect and cost of each option."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations, permutations
from typing import Any

import pandas as pd

from steadyload.engines.registry import capabilities
from steadyload.engines.world import Support
from steadyload.methods.registry import make_method
from steadyload.reports import frames
from steadyload.runs import frames as v
from steadyload.runs.able import spatial_engines
from steadyload.runs.costs import CPU
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.judged import JudgedCases, load_judged
from steadyload.runs.runner import run_study
from steadyload.statistics.metrics import agreement, same, share
from steadyload.studies.kit import Lab

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


@dataclass(frozen=True)
class Drawn:
    """Generated layouts: how many, the seed that they are drawn with, and their largest size."""

    count: int
    seed: int
    most_items: int | None = None


def _judged(lab: Lab, name: str, specs: Iterable[str], drawn: Drawn) -> JudgedCases:
    """All methods, judged where that is missing; methods take turns at some layouts."""
    definition = StudyDefinition(
        f"engines, {name}",
        tuple(dict.fromkeys(specs)),
        generated=drawn.count,
        seed=drawn.seed,
        max_items=drawn.most_items,
        shard_size=25,
    )
    run_study(
        definition, lab.work / name, workers=lab.workers,
        progress=lambda *of: lab.progress(name, *of),
    )  # fmt: skip
    return load_judged(lab.work / name)


def engine_agreement(
    lab: Lab, drawn: Drawn, frequencies: Sequence[int] = FREQUENCIES
) -> dict[str, Any]:
    """Share of equal failing steps between every two 3-D engines, by frequency, with costs.

    Returns:
        ``pairs``: of engines, and ``engines``: columns a frequency. ``points``: of the chart, both
        engines of a pair with the other one; ``matrix``: those at the highest frequency,
        ``finest``. ``alike``: shares there, from the least up.
    """
    engines = spatial_engines()
    specs = {
        str(make_method(f"simulation@{engine}:{BASE},frequency={f},samples=1").spec): (engine, f)
        for f in frequencies
        for engine in engines
    }
    judged = _judged(lab, "agreement", specs, drawn)
    of = {at: spec for spec, at in specs.items()}
    same = {
        (a, b, f): agreement(judged.said, of[a, f], of[b, f])
        for a, b in combinations(engines, 2)
        for f in frequencies
    }
    points = [
        {
            "engine": own, "other": other, "frequency": f,
            "same": same.get((own, other, f)) or same[other, own, f],
        }
        for own, other in permutations(engines, 2)
        for f in frequencies
    ]  # fmt: skip
    pairs = pd.Series({(f"{a} and {b}", f): one for (a, b, f), one in same.items()}, dtype=object)
    order = {spec: number for number, spec in enumerate(specs)}
    rows = judged.results.sort_values("method", key=lambda own: own.map(order), kind="stable")
    at = pd.DataFrame([specs[spec] for spec in rows["method"]], rows.index, ["engine", "frequency"])
    rows = rows.assign(
        engine=at["engine"], frequency=at["frequency"], cluster=rows["layout"],
        stable=(rows["score"] == 1.0).fillna(False), cpu=1e3 * rows[CPU],
    )  # fmt: skip
    by, finest = ["engine", "frequency"], max(frequencies)
    return {
        "pairs": _across(pairs.rename_axis(["pair", "frequency"]), "same"),
        "stable": _across(v.share(rows, "stable", by), "stable_at"),
        "cpu": _across(v.mean(rows, "cpu", by), "cpu_at"),
        "points": points,
        "matrix": [point for point in points if point["frequency"] == finest],
        "finest": finest,
        "alike": sorted(
            (one for (_, _, f), one in same.items() if f == finest), key=lambda one: one.value
        ),
    }


def _across(found: pd.Series, name: str) -> pd.DataFrame:
    return frames.across(found, found.index.names[1], name).reset_index()


def option_effects(lab: Lab, drawn: Drawn) -> dict[str, pd.DataFrame]:
    """Effect of each option on verdicts and CPU time, per engine that does not ignore it.

    Returns:
        ``changed``: share of layouts with another failing step; ``ratio``: CPU time with the option
        over that without; columns an engine.
    """
    specs = {
        (title, engine): without_and_with(engine, *parameters)
        for title, parameters in OPTIONS.items()
        for engine in spatial_engines()
        if "solver_iterations" not in parameters[1]
        or capabilities(engine).settings["solver_iterations"].support != Support.IGNORED
    }
    judged = _judged(lab, "options", [spec for both in specs.values() for spec in both], drawn)
    cpu = judged.results.groupby("method")[CPU].mean()
    changed = {at: share(~same(judged.said, *both)) for at, both in specs.items()}
    ratio = {at: cpu[given] / cpu[without] for at, (without, given) in specs.items()}
    return {
        name: _across(pd.Series(found).rename_axis(["option", "engine"]), f"option_{name}")
        for name, found in (("changed", changed), ("ratio", ratio))
    }


def without_and_with(engine: str, without: str, given: str) -> tuple[str, str]:
    """Specs at 240 Hz without an option and with it, of a line of :data:`OPTIONS`."""
    base = f"simulation@{engine}:{BASE},frequency=240"
    start = base.replace(",between_steps=reseat", "") if "carry" in given else base
    return str(make_method(f"{base},{without}").spec), str(make_method(f"{start},{given}").spec)
