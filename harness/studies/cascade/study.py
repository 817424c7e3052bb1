"""A cascade on cases that nothing was fitted on, beside its stages and other methods."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from steadyload.atomic import write_atomically
from steadyload.layouts.benchmark import UNLEARNT
from steadyload.layouts.model import Layout
from steadyload.methods.cascade import Cascade, Decision
from steadyload.methods.method import Method
from steadyload.methods.naming import method_key
from steadyload.methods.registry import make_method
from steadyload.methods.spec import nearest
from steadyload.methods.thresholds import Ladder
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.labels import labelled_material, load_labels
from steadyload.runs.provenance import source_line
from steadyload.runs.results import load_results
from steadyload.runs.runner import run_study
from steadyload.runs.timing import machine_load
from steadyload.statistics.metrics import share
from steadyload.studies.cascade.records import (
    CascadeStudy,
    Decided,
    FittedLadder,
    Held,
    HeldAgainst,
    StageShare,
)
from steadyload.studies.tuning.outcomes import PART, Outcomes
from steadyload.tuning import TuningError

BESIDE = (
    "fbs",
    "sme",
    "equilibrium",
    "lstm_1",
    "lstm_e",
    "equilibrium:time=0.3",
    "ps_opt@{engine}",
    "ps3@{engine}",
)
"""Methods that a cascade is held against."""

_TURN = 150
"""Cases that a method judges before it is the next one's turn. Whoever has just judged something
else pays for it: turns are long.
"""

_LOAD = "load.json"

Progress = Callable[[int, int], None]


def cascade_study(
    engine: str,
    work: Path,
    *,
    others: Iterable[str] = (),
    part: str = PART,
    limit: int | None = None,
    thresholds: str = "",
    beside: Iterable[str] = BESIDE,
    workers: int = 1,
    progress: Progress = lambda done, total: None,
) -> CascadeStudy:
    """Judge a part of the labelled set, methods in turns.

    An interrupted study goes on; a method that was judged keeps its times.

    Args:
        engine: of the cascade.
        work: folder of what is judged.
        others: specs of further methods.
        part: of the labelled set, one that no stage has learnt from.
        limit: only so many cases a scenario.
        thresholds: file of thresholds; empty for those that come with the package.
        beside: specs of the methods that the cascade is held against, ``{engine}`` for the engine.
        workers: processes beside this one; with 0 or 1 times are taken in one process.
        progress: called with rows done and rows in all.

    Raises:
        TuningError: the part is one that is learnt from.
        ThresholdsError: no thresholds for the engine, or ones fitted with other judges.
        as :func:`steadyload.runs.runner.run_study`.
    """
    if part not in UNLEARNT:
        raise TuningError(f"part is {part!r}; {nearest(part, UNLEARNT)}")
    own = f"thresholds={thresholds}" if thresholds else ""
    cascade = _cascade(engine, own)
    ladders = cascade.thresholds.ladders
    swept = {
        str(_cascade(engine, own, budget).spec): budget
        for budget in ladders
        if budget != cascade.thresholds.default
    }
    named = [spec.replace("{engine}", engine) for spec in beside]
    study = StudyDefinition(
        name="cascade",
        methods=tuple(dict.fromkeys([str(cascade.spec), *swept, *named, *others])),
        benchmark=part,
        benchmark_directory=cascade.thresholds.made_by.get("directory"),
        limit=limit,
        shard_size=_TURN,
    )
    load = _judged(study, work, workers, progress)
    outcomes, labels = Outcomes(work / "run"), load_labels(work / "run")
    results = load_results(work / "run")
    substeps = results.groupby("method")["substeps"].mean()
    budgets = {str(cascade.spec): cascade.thresholds.default, **swept}
    return CascadeStudy(
        part=str(part),
        cases=len(labels),
        item_lists=labels["instance"].nunique(),
        methods=tuple(
            _held(outcomes, spec, str(cascade.spec), budgets.get(spec), float(substeps[spec]))
            for spec in study.methods
        ),
        **_stages(cascade, list(labelled_material(study).cases(work / "run")), labels),
        ladders=tuple(_fitted(budget, ladder) for budget, ladder in ladders.items()),
        confidence=float(cascade.thresholds.made_by["confidence"]),
        load=load,
        made_by=_lines(cascade.thresholds.made_by),
    )


def _cascade(engine: str, own: str, budget: float | None = None) -> Cascade:
    values = [own] if own else []
    if budget is not None:
        values.append(f"budget={budget:g}")
    made = make_method(f"cascade@{engine}{':' if values else ''}{','.join(values)}")
    assert isinstance(made, Cascade)
    return made


def _judged(study: StudyDefinition, work: Path, workers: int, progress: Progress) -> float | None:
    """Judge what is missing; the load of the machine while times were taken."""
    file = work / _LOAD
    before = machine_load()
    if run_study(study, work / "run", workers=workers, progress=progress):
        after = machine_load()
        found = None if before is None or after is None else max(before, after)
        write_atomically(file, json.dumps(found))
        return found
    return json.loads(file.read_text()) if file.exists() else None


def _held(
    outcomes: Outcomes, spec: str, cascade: str, budget: float | None, substeps: float
) -> HeldAgainst:
    method = make_method(spec)
    found = outcomes.of(spec)
    return HeldAgainst(
        method=method_key(method),
        accuracy=found.accuracy,
        over=found.over,
        under=found.under,
        cpu=found.cpu,
        ahead=None if spec == cascade else outcomes.difference(cascade, spec),
        cost=None if spec == cascade else outcomes.cpu_ratio(cascade, spec),
        substeps=substeps,
        simulation=method.spec.engine is not None and budget is None,
        budget=budget,
    )


def _stages(
    cascade: Cascade, cases: list[tuple[str, Layout]], labels: pd.DataFrame
) -> dict[str, Any]:
    """Who decided what: every step, and every layout by the last stage that it needed."""
    cascade.prepare(max(len(layout) for _, layout in cases))
    stages = list(cascade.ladder.methods)
    rows, layouts = [], []
    for scenario, layout in cases:
        label = labels.loc[(layout.name, scenario)]
        safe = len(layout) if pd.isna(label["failing_step"]) else int(label["failing_step"])
        decisions = cascade.decisions(layout)
        numbers = [stages.index(decision.stage) for decision in decisions]
        rows += [
            (number, label["instance"], decision.step <= safe, _right(decision, safe))
            for number, decision in zip(numbers, decisions, strict=True)
        ]
        end = decisions[-1].step if decisions[-1].unstable else len(layout)
        layouts.append((max(numbers), label["instance"], end == safe))
    steps = pd.DataFrame(rows, columns=["stage", "list", "labelled", "right"])
    whole = pd.DataFrame(layouts, columns=["stage", "list", "right"])
    limits = [(stage.low, stage.high) for stage in cascade.ladder.stages] + [(None, None)]
    return {
        "stages": tuple(
            _share(number, method, limits[number], steps, whole)
            for number, method in enumerate(cascade.judges)
        ),
        "steps_a_layout": len(steps) / len(whole),
    }


def _right(decision: Decision, safe: int) -> bool:
    return decision.unstable == (decision.step == safe)


def _share(
    number: int,
    method: Method,
    limits: tuple[float | None, float | None],
    steps: pd.DataFrame,
    layouts: pd.DataFrame,
) -> StageShare:
    own = steps[(steps["stage"] == number) & steps["labelled"]]
    needed = layouts[layouts["stage"] == number]
    return StageShare(
        method_key(method),
        *limits,
        steps=share(np.asarray(steps["stage"] == number), steps["list"]),
        right=share(own["right"], own["list"]),
        layouts=share(np.asarray(layouts["stage"] == number), layouts["list"]),
        layouts_right=share(needed["right"], needed["list"]),
    )


def _fitted(budget: float, ladder: Ladder) -> FittedLadder:
    found = ladder.found
    return FittedLadder(
        budget=budget,
        stages=tuple((stage.method, stage.low, stage.high) for stage in ladder.stages),
        last=ladder.last,
        cases=found["cases"],
        item_lists=found["item_lists"],
        independent=found["independent"],
        allowed=found["allowed"],
        lost=found["lost"],
        gained=found["gained"],
        bound=found["bound"],
        sure_bound=found["sure_bound"],
        left_out=(found["left_out"]["lost"], found["left_out"]["cases"]),
        accuracy=found["accuracy"],
        accuracy_alone=found["alone"],
        cost=found["milliseconds"],
        cost_alone=found["milliseconds_alone"],
        decided=tuple(Decided(**entry) for entry in found["decided"]),
        elsewhere=tuple(Held(**entry) for entry in found["elsewhere"]),
    )


def _lines(made_by: Mapping[str, Any]) -> dict[str, str]:
    """What thresholds were fitted with, as a page shows it."""
    return {
        "thresholds fitted by": source_line(made_by),
        "thresholds fitted on": f"validation, cases {made_by['cases']}"
        + "".join(f", {path}" for path in made_by["data"]),
    }
