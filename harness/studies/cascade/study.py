"""A cascade compared with its stages and other methods, on cases on which nothing was fitted."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from steadyload.atomic import manifest_text, verified_manifest, write_atomically
from steadyload.errors import nearest
from steadyload.layouts.benchmark import UNLEARNT, Part
from steadyload.layouts.benchmark.dataset import set_named
from steadyload.methods.cascade import Cascade
from steadyload.methods.registry import make_method
from steadyload.reading import MAX_STORED_BYTES, content_of, json_of
from steadyload.runs.costs import CostKind, CostSource
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.evaluation import evaluate
from steadyload.runs.labels import labelled_material, load_labels
from steadyload.runs.provenance import source_line
from steadyload.runs.runner import run_study
from steadyload.runs.timing import machine_load
from steadyload.studies.cascade.summary import CascadeStudy, fitted, stages
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
"""Methods that a cascade is compared with."""

_TURN = 150
"""Cases that a method judges before it is the next one's turn. Turns are long, because a switch of
methods costs time.
"""

_LOAD = "load.json"
_WHILE_JUDGING = "load of the machine"

_log = logging.getLogger("steadyload")

Progress = Callable[[int, int], None]


def cascade_study(
    engine: str,
    work: Path,
    *,
    others: Iterable[str] = (),
    directory: str = "",
    part: str = Part.TEST,
    limit: int | None = None,
    thresholds: str = "",
    beside: Iterable[str] = BESIDE,
    workers: int = 1,
    progress: Progress = lambda done, total: None,
) -> CascadeStudy:
    """Judge a part of the labelled set, methods in turns.

    An interrupted study is resumed; methods that were judged keep their times.

    Args:
        engine: of the cascade.
        work: folder of the run folders.
        others: specs of further methods.
        directory: of the labelled set, see :func:`steadyload.layouts.benchmark.dataset.set_named`.
        part: of the labelled set, one that no stage has learnt from.
        limit: largest number of cases a scenario; None for all.
        thresholds: file of thresholds; empty for those that come with the package.
        beside: specs of the methods that the cascade is compared with, ``{engine}`` for the engine.
        workers: processes beside this one; with 0 or 1 times are taken in one process.
        progress: called with rows done and rows in all.

    Raises:
        TuningError: the part is one on which methods are trained or tuned.
        ThresholdsError: no thresholds for the engine, or ones fitted with other methods.
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
        benchmark_directory=set_named(directory),
        limit=limit,
        shard_size=_TURN,
    )
    load = _judged(study, work, workers, progress)
    source = CostSource(CostKind.IN_TURNS, load=load)
    evaluation = evaluate(work / "run", source=source, by_scenario=False)
    labels = load_labels(work / "run")
    own_spec = str(cascade.spec)
    return CascadeStudy(
        part=f"{directory} {part}".strip(),
        fitted_there=part != Part.TEST and directory in _fitted_on(cascade.thresholds.made_by),
        cases=len(labels),
        item_lists=labels["instance"].nunique(),
        methods=tuple(evaluation.row(spec, against=own_spec) for spec in study.methods),
        budgets={own_spec: cascade.thresholds.default, **swept},
        **stages(cascade, list(labelled_material(study).cases(work / "run")), labels),
        ladders=tuple(fitted(budget, ladder) for budget, ladder in ladders.items()),
        confidence=float(cascade.thresholds.made_by["confidence"]),
        cost_source=evaluation.cost_source,
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
    """Judge the missing cases; returns the load of the machine while times were taken."""
    file = work / _LOAD
    before = machine_load()
    if run_study(study, work / "run", workers=workers, progress=progress):
        after = machine_load()
        found = None if before is None or after is None else max(before, after)
        write_atomically(file, manifest_text({_WHILE_JUDGING: found}))
        return found
    return _kept_load(file)


def _kept_load(file: Path) -> float | None:
    """The load that was written down; unknown where it was not, or is damaged."""
    if not file.exists():
        return None
    try:
        found = json_of(content_of(file, MAX_STORED_BYTES))
        load = verified_manifest(found)[_WHILE_JUDGING] if isinstance(found, dict) else found
        if isinstance(load, bool) or not isinstance(load, int | float | None):
            raise ValueError
    except (LookupError, RecursionError, ValueError):
        _log.warning("%s: is damaged; the load of the machine is not known", file)
        return None
    return load


def _lines(made_by: Mapping[str, Any]) -> dict[str, str]:
    """Provenance of thresholds, as a page shows it."""
    sets = ", ".join(name or "the large set" for name in _fitted_on(made_by))
    return {
        "thresholds fitted by": source_line(made_by),
        "thresholds fitted on": f"{sets}; cases {made_by['cases']}",
    }


def _fitted_on(made_by: Mapping[str, Any]) -> list[str]:
    """The labelled sets that thresholds were fitted on, as they are named; empty: the large one."""
    return [made_by.get("directory") or "", *made_by["data"]]
