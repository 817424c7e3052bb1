"""Do engines agree, what does each option change, and what does it cost?"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations

import numpy as np

from engines.registry import engine_names, world_class
from harness.layouts.model import Layout
from harness.methods.method import Status
from harness.methods.registry import make_method
from harness.studies.metrics import mean, share
from reports.records import EngineAgreement, OptionEffect

BASE = "t_max=0.3,eps_t=10,eps_r=10,friction=0.5,between_steps=reseat"
"""Untuned: the reference simulation's time, thresholds and friction, nothing else."""

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


class _Judge:
    """Verdicts and CPU times, each method asked once."""

    def __init__(self, layouts: Sequence[Layout], progress: Progress) -> None:
        self.layouts, self.progress = layouts, progress
        self._known: dict[str, tuple[list[int | str], np.ndarray]] = {}

    def __call__(self, spec: str) -> tuple[list[int | str], np.ndarray]:
        """What the method said of every layout (failing step or status), and CPU ms of each."""
        if spec not in self._known:
            self.progress(spec)
            method = make_method(spec)
            method.prepare(max(map(len, self.layouts)))
            verdicts = method.judge_many(self.layouts)
            said: list[int | str] = []
            for verdict in verdicts:
                if verdict.status is not Status.DONE:
                    said.append(f"{verdict.status}")
                else:
                    safe = verdict.failing_step
                    said.append(verdict.item_count if safe is None else safe)
            self._known[spec] = said, np.array([1e3 * v.cpu.total for v in verdicts])
        return self._known[spec]


def engine_agreement(
    layouts: Sequence[Layout],
    frequencies: Sequence[int] = FREQUENCIES,
    *,
    progress: Progress = lambda what: None,
) -> list[EngineAgreement]:
    """Share of equal failing steps between every two 3-D engines, by frequency, with costs."""
    ask = _Judge(layouts, progress)
    engines = _spatial_engines()
    rows = []
    for frequency in frequencies:
        found = {e: ask(f"simulation@{e}:{BASE},frequency={frequency},samples=1") for e in engines}
        rows.append(
            EngineAgreement(
                frequency=frequency,
                stable={
                    e: share([s == len(lay) for s, lay in zip(said, layouts, strict=True)])
                    for e, (said, _) in found.items()
                },
                cpu={e: mean(cpu) for e, (_, cpu) in found.items()},
                agreement={
                    (a, b): share(_equal(found[a][0], found[b][0]))
                    for a, b in combinations(engines, 2)
                },
            )
        )
    return rows


def option_effects(
    layouts: Sequence[Layout], *, progress: Progress = lambda what: None
) -> list[OptionEffect]:
    """What each option changes in verdicts and CPU time, per engine that does not ignore it."""
    ask = _Judge(layouts, progress)
    effects = []
    for title, (without, given) in OPTIONS.items():
        for engine in _spatial_engines():
            if "solver_iterations" in given and _ignores(engine, "solver_iterations"):
                continue
            start = f"simulation@{engine}:{BASE},frequency={_OPTION_FREQUENCY}"
            start = start.replace(",between_steps=reseat", "") if "carry" in given else start
            before = ask(f"simulation@{engine}:{BASE},frequency={_OPTION_FREQUENCY},{without}")
            after = ask(f"{start},{given}")
            equal = _equal(before[0], after[0])
            ratio = float(after[1].sum() / before[1].sum())
            effects.append(
                OptionEffect(title, engine, share([not e for e in equal]), ratio, mean(after[1]))
            )
    return effects


def _spatial_engines() -> list[str]:
    return [e for e in engine_names() if world_class(e).capabilities.dimensions == 3]


def _ignores(engine: str, setting: str) -> bool:
    return world_class(engine).capabilities.settings[setting].support == "ignored"


def _equal(first: Sequence[int | str], second: Sequence[int | str]) -> list[bool]:
    """Case by case the same failing step; a missing verdict equals nothing."""
    return [a == b and isinstance(a, int) for a, b in zip(first, second, strict=True)]
