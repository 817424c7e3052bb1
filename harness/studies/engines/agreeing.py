"""Agreement of engines, and the effect and cost of each option."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

from steadyload.engines.registry import capabilities
from steadyload.engines.world import Support
from steadyload.methods.registry import make_method
from steadyload.reports.columns import column, milliseconds, percent, row, significant
from steadyload.runs.able import spatial_engines
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.evaluation import Evaluation, evaluate
from steadyload.runs.runner import run_study
from steadyload.statistics.estimate import Estimate
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


@row
class Pair:
    """Share of layouts on which two engines name the same failing step, by frequency [Hz]."""

    engines: tuple[str, str] = column(form=" and ".join, left=True)
    same: Mapping[int, Estimate] = column("{} Hz", percent)


@row
class Untuned:
    """Share of layouts that are stable on an engine and CPU ms a layout, by frequency [Hz]."""

    engine: str = column()
    stable: Mapping[int, Estimate] = column("{} Hz", percent)
    cpu: Mapping[int, Estimate] = column("{} Hz", milliseconds)


@row
class Agreement:
    """Agreement between every two engines, and verdicts and costs of each."""

    pairs: Sequence[Pair]
    engines: Sequence[Untuned]

    @property
    def finest(self) -> int:
        """The highest frequency."""
        return max(self.pairs[0].same)

    @property
    def alike(self) -> list[Estimate]:
        """Shares at the highest frequency, from the least up."""
        return sorted((pair.same[self.finest] for pair in self.pairs), key=lambda one: one.value)

    @property
    def points(self) -> list[Mapping[str, Any]]:
        """Points of the chart: both engines of a pair with the other one."""
        return [
            {"engine": own.engine, "other": other, "frequency": frequency, "same": same}
            for own in self.engines
            for pair in self.pairs
            if own.engine in pair.engines
            for other in {*pair.engines} - {own.engine}
            for frequency, same in pair.same.items()
        ]

    @property
    def matrix(self) -> list[Mapping[str, Any]]:
        """Those at the highest frequency."""
        return [point for point in self.points if point["frequency"] == self.finest]


@row
class OptionEffect:
    """Effect of an option, by engine that does not ignore it.

    Attributes:
        changed: share of layouts with another failing step.
        ratio: CPU time with the option over that without.
    """

    option: str = column()
    changed: Mapping[str, Estimate] = column("{}", percent)
    ratio: Mapping[str, float] = column("{}", significant)


@dataclass(frozen=True)
class Drawn:
    """Generated layouts: how many, the seed that they are drawn with, and their largest size."""

    count: int
    seed: int
    most_items: int | None = None


def _judged(lab: Lab, name: str, specs: Iterable[str], drawn: Drawn) -> Evaluation:
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
    return evaluate(lab.work / name)


def engine_agreement(lab: Lab, drawn: Drawn, frequencies: Sequence[int] = FREQUENCIES) -> Agreement:
    """Share of equal failing steps between every two 3-D engines, by frequency, with costs.

    Args:
        lab: where it runs.
        drawn: the layouts.
        frequencies: substeps a second.
    """
    engines = spatial_engines()
    specs = {
        (engine, f): str(make_method(f"simulation@{engine}:{BASE},frequency={f},samples=1").spec)
        for f in frequencies
        for engine in engines
    }
    found = _judged(lab, "agreement", specs.values(), drawn)
    said, rows = found.judged.said, {at: found.row(spec) for at, spec in specs.items()}
    return Agreement(
        [
            Pair((a, b), {f: agreement(said, specs[a, f], specs[b, f]) for f in frequencies})
            for a, b in combinations(engines, 2)
        ],
        [
            Untuned(
                engine,
                {f: rows[engine, f].fully_stable for f in frequencies},
                {f: rows[engine, f].cpu for f in frequencies},
            )
            for engine in engines
        ],
    )


def option_effects(lab: Lab, drawn: Drawn) -> list[OptionEffect]:
    """Effect of each option on verdicts and CPU time, per engine that does not ignore it.

    Args: as those of :func:`engine_agreement`.
    """
    specs = {
        title: {
            engine: without_and_with(engine, *parameters)
            for engine in spatial_engines()
            if "solver_iterations" not in parameters[1]
            or capabilities(engine).settings["solver_iterations"].support != Support.IGNORED
        }
        for title, parameters in OPTIONS.items()
    }
    asked = [spec for own in specs.values() for both in own.values() for spec in both]
    found = _judged(lab, "options", asked, drawn)
    return [
        OptionEffect(
            title,
            {engine: share(~same(found.judged.said, *both)) for engine, both in own.items()},
            {e: found.cost_ratio(given, without).value for e, (without, given) in own.items()},
        )
        for title, own in specs.items()
    ]


def without_and_with(engine: str, without: str, given: str) -> tuple[str, str]:
    """Specs at 240 Hz without an option and with it, of a line of :data:`OPTIONS`."""
    base = f"simulation@{engine}:{BASE},frequency=240"
    start = base.replace(",between_steps=reseat", "") if "carry" in given else base
    return str(make_method(f"{base},{without}").spec), str(make_method(f"{start},{given}").spec)
