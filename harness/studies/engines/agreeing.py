"""Agreement of engines, and the effect and cost of each option."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import pandas as pd

from steadyload.engines.registry import engines_here, world_class
from steadyload.methods.contract.method import Status
from steadyload.methods.registry import make_method
from steadyload.reports.columns import column, milliseconds, percent, row, significant
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.results import load_results
from steadyload.runs.runner import run_study
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share
from steadyload.statistics.placed import items_placed_by_case
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

_OPTION_FREQUENCY = 240
_SHARD = 25


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


class Agreeing(NamedTuple):
    """A share of :class:`Pair` at a frequency, beside the other engine's."""

    engine: str
    other: str
    frequency: int
    same: Estimate


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
    def points(self) -> list[Agreeing]:
        """Points of the chart: both engines of a pair with the other one."""
        return [
            Agreeing(own.engine, other, frequency, same)
            for own in self.engines
            for pair in self.pairs
            if own.engine in pair.engines
            for other in {*pair.engines} - {own.engine}
            for frequency, same in pair.same.items()
        ]


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


@dataclass(frozen=True, slots=True)
class _Answers:
    """Verdicts of a method on all layouts (failing step, J when stable, or status), and CPU ms."""

    said: list[int | str]
    cpu: list[float]
    items: list[int]


def _ask(lab: Lab, name: str, specs: Sequence[str], drawn: Drawn) -> list[_Answers]:
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
    run_study(
        definition, lab.work / name, workers=lab.workers,
        progress=lambda *of: lab.progress(name, *of),
    )  # fmt: skip
    columns = ["layout", "method", "status", "failing_step", "item_count", "cpu_total"]
    rows = load_results(lab.work / name, columns).sort_values("layout")
    by_method = {spec: _answers(own) for spec, own in rows.groupby("method")}
    return [by_method[spec] for spec in asked]


def _answers(rows: pd.DataFrame) -> _Answers:
    items = rows["item_count"].tolist()
    steps = items_placed_by_case(rows["failing_step"], rows["item_count"]).tolist()
    done = (rows["status"] == str(Status.DONE)).tolist()
    said = [step if ok else why for step, ok, why in zip(steps, done, rows["status"], strict=True)]
    return _Answers(said, (1e3 * rows["cpu_total"]).tolist(), items)


def engine_agreement(lab: Lab, drawn: Drawn, frequencies: Sequence[int] = FREQUENCIES) -> Agreement:
    """Share of equal failing steps between every two 3-D engines, by frequency, with costs.

    Args:
        lab: where it runs.
        drawn: the layouts.
        frequencies: substeps a second.
    """
    engines = _spatial_engines()
    asked = [(frequency, engine) for frequency in frequencies for engine in engines]
    specs = [f"simulation@{e}:{BASE},frequency={f},samples=1" for f, e in asked]
    found = dict(zip(asked, _ask(lab, "agreement", specs, drawn), strict=True))

    def same(frequency: int, first: str, second: str) -> Estimate:
        return share(_equal(found[frequency, first].said, found[frequency, second].said))

    return Agreement(
        [
            Pair((a, b), {f: same(f, a, b) for f in frequencies})
            for a, b in combinations(engines, 2)
        ],
        [
            Untuned(
                engine,
                {f: share(_stable(found[f, engine])) for f in frequencies},
                {f: mean(found[f, engine].cpu) for f in frequencies},
            )
            for engine in engines
        ],
    )


def _stable(answers: _Answers) -> list[bool]:
    return [said == count for said, count in zip(answers.said, answers.items, strict=True)]


def option_effects(lab: Lab, drawn: Drawn) -> list[OptionEffect]:
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
    answers = iter(_ask(lab, "options", specs, drawn))
    both = {(title, engine): (next(answers), next(answers)) for title, engine, *_ in asked}
    return [
        OptionEffect(
            title,
            {e: share(_differ(*both[t, e])) for t, e in both if t == title},
            {e: _cost_ratio(*both[t, e]) for t, e in both if t == title},
        )
        for title in OPTIONS
    ]


def _differ(before: _Answers, after: _Answers) -> list[bool]:
    return [not equal for equal in _equal(before.said, after.said)]


def _cost_ratio(before: _Answers, after: _Answers) -> float:
    return sum(after.cpu) / sum(before.cpu)


def _without_and_with(engine: str, without: str, given: str) -> tuple[str, str]:
    """Specs without an option and with it."""
    base = f"simulation@{engine}:{BASE},frequency={_OPTION_FREQUENCY}"
    start = base.replace(",between_steps=reseat", "") if "carry" in given else base
    return f"{base},{without}", f"{start},{given}"


def _spatial_engines() -> list[str]:
    return [e for e in engines_here() if world_class(e).capabilities.dimensions == 3]


def _ignores(engine: str, setting: str) -> bool:
    return world_class(engine).capabilities.settings[setting].support == "ignored"


def _equal(first: Sequence[int | str], second: Sequence[int | str]) -> list[bool]:
    """Mask of cases with the same failing step; a missing verdict equals nothing."""
    return [a == b and isinstance(a, int) for a, b in zip(first, second, strict=True)]
