"""Study of engines: their agreement, and the effect and cost of each option."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from steadyload.engines.registry import engines_here, world_class
from steadyload.layouts.model import Layout
from steadyload.methods.method import Status
from steadyload.methods.registry import make_method
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share

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

Progress = Callable[[str], None]


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


@dataclass(frozen=True, slots=True)
class _Answers:
    """Verdicts of a method on all layouts (failing step, J when stable, or status), and CPU ms."""

    said: list[int | str]
    cpu: list[float]


def _ask(specs: Sequence[str], layouts: Sequence[Layout]) -> list[_Answers]:
    """Verdicts of all methods, judging in turns, so that a disturbance affects all of them."""
    methods = [make_method(spec) for spec in specs]
    for method in methods:
        method.prepare(max(map(len, layouts)))
    answers = [_Answers([], []) for _ in methods]
    for layout in layouts:
        for method, answer in zip(methods, answers, strict=True):
            verdict = method.judge(layout)
            safe = len(layout) if verdict.failing_step is None else verdict.failing_step
            done = verdict.status is Status.DONE
            answer.said.append(safe if done else str(verdict.status))
            answer.cpu.append(1e3 * verdict.cpu.total)
    return answers


def engine_agreement(
    layouts: Sequence[Layout],
    frequencies: Sequence[int] = FREQUENCIES,
    *,
    progress: Progress = lambda what: None,
) -> list[EngineAgreement]:
    """Share of equal failing steps between every two 3-D engines, by frequency, with costs."""
    engines = _spatial_engines()
    rows = []
    for frequency in frequencies:
        progress(f"agreement at {frequency} Hz")
        specs = [f"simulation@{e}:{BASE},frequency={frequency},samples=1" for e in engines]
        found = dict(zip(engines, _ask(specs, layouts), strict=True))
        rows.append(
            EngineAgreement(
                frequency=frequency,
                stable={
                    e: share([s == len(lay) for s, lay in zip(a.said, layouts, strict=True)])
                    for e, a in found.items()
                },
                cpu={e: mean(a.cpu) for e, a in found.items()},
                agreement={
                    (a, b): share(_equal(found[a].said, found[b].said))
                    for a, b in combinations(engines, 2)
                },
            )
        )
    return rows


def option_effects(
    layouts: Sequence[Layout], *, progress: Progress = lambda what: None
) -> list[OptionEffect]:
    """Effect of each option on verdicts and CPU time, per engine that does not ignore it."""
    effects = []
    for title, (without, given) in OPTIONS.items():
        for engine in _spatial_engines():
            if "solver_iterations" in given and _ignores(engine, "solver_iterations"):
                continue
            start = f"simulation@{engine}:{BASE},frequency={_OPTION_FREQUENCY}"
            start = start.replace(",between_steps=reseat", "") if "carry" in given else start
            progress(f"{engine}: {title}")
            base = f"simulation@{engine}:{BASE},frequency={_OPTION_FREQUENCY},{without}"
            before, after = _ask([base, f"{start},{given}"], layouts)
            changed = share([not e for e in _equal(before.said, after.said)])
            ratio = sum(after.cpu) / sum(before.cpu)
            effects.append(OptionEffect(title, engine, changed, ratio, mean(after.cpu)))
    return effects


def _spatial_engines() -> list[str]:
    return [e for e in engines_here() if world_class(e).capabilities.dimensions == 3]


def _ignores(engine: str, setting: str) -> bool:
    return world_class(engine).capabilities.settings[setting].support == "ignored"


def _equal(first: Sequence[int | str], second: Sequence[int | str]) -> list[bool]:
    """Mask of cases with the same failing step; a missing verdict equals nothing."""
    return [a == b and isinstance(a, int) for a, b in zip(first, second, strict=True)]
