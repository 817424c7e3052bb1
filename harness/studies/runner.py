"""Methods x layouts -> results: split into units, judged over processes, resumable."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from harness.atomic import write_atomically
from harness.layouts.formats import Format, write_layouts
from harness.layouts.model import Layout
from harness.methods.method import Method, Status, Verdict
from harness.methods.registry import make_method
from harness.studies.definition import StudyDefinition
from harness.studies.executors import run_units
from harness.studies.results import (
    SCHEMA_VERSION,
    ResultsError,
    code_fingerprint,
    load_manifest,
    provenance,
    result_row,
    write_shard,
)


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit of work: one method, some cases, and the shard their rows go to."""

    method: str
    cases: tuple[tuple[str, Layout], ...]
    repetitions: int
    shard: Path


def judge(method: Method, layout: Layout) -> Verdict:
    """Like :meth:`Method.judge`, but an unexpected exception becomes a verdict ``error``."""
    try:
        return method.judge(layout)
    except Exception as error:
        reason = f"{type(error).__name__}: {error}"
        return Verdict(item_count=len(layout), status=Status.ERROR, reason=reason)


def judge_unit(unit: Unit) -> int:
    """Judge a unit's cases and write its shard; returns the number of rows.

    The first case is judged once more beforehand, so that no reported time holds imports, first
    connections or compilation.
    """
    method = make_method(unit.method)
    judge(method, unit.cases[0][1])
    rows = [
        result_row(layout, scenario, method, repetition, judge(method, layout))
        for repetition in range(unit.repetitions)
        for scenario, layout in unit.cases
    ]
    write_shard(unit.shard, rows)
    return len(rows)


def run_study(
    study: StudyDefinition,
    directory: Path,
    *,
    workers: int = 1,
    rerun: bool = False,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> int:
    """Run what is missing of a study; returns the number of rows computed now.

    Shards that are already there are kept when they were made by the same method, layouts and
    code; everything else counts as missing.

    Args:
        study: what to compare.
        directory: the run folder; made when it does not exist.
        workers: processes; 1 judges in this one.
        rerun: compute everything anew.
        progress: called with rows done and rows in all, first with what is already there.

    Raises:
        ResultsError: the folder holds another study, or something else.
        LayoutError, StudyError: see :meth:`StudyDefinition.layouts`.
    """
    layouts = study.layouts()
    cases = study.cases(layouts)
    _claim(directory, study)
    (directory / "results").mkdir(parents=True, exist_ok=True)
    units = list(_units(study, cases, directory / "results"))
    wanted = {unit.shard for unit in units}
    for shard in (directory / "results").glob("*.parquet"):
        if rerun or shard not in wanted:
            shard.unlink()
    for unfinished in (directory / "results").glob(".*.parquet.*"):
        unfinished.unlink()
    manifest = _manifest(study, layouts, len(cases))
    _write_manifest(directory, manifest)
    write_layouts(directory / "layouts.json", layouts, Format.NATIVE)

    total = sum(len(u.cases) * u.repetitions for u in units)
    missing = [unit for unit in units if not unit.shard.exists()]
    computed = 0
    present = total - sum(len(u.cases) * u.repetitions for u in missing)
    progress(present, total)
    for rows in run_units(judge_unit, missing, workers=workers):
        computed += rows
        progress(present + computed, total)
    _write_manifest(directory, {**manifest, "finished": _now(), "rows": total})
    return computed


def _units(study: StudyDefinition, cases: list[tuple[str, Layout]], folder: Path) -> Iterator[Unit]:
    code = code_fingerprint()
    for method in study.methods:
        for start in range(0, len(cases), study.shard_size):
            part = tuple(cases[start : start + study.shard_size])
            identity = [method, study.repetitions, SCHEMA_VERSION, code]
            identity += [[s, lay.name, lay.content_hash()] for s, lay in part]
            digest = hashlib.sha256(json.dumps(identity).encode()).hexdigest()[:20]
            yield Unit(method, part, study.repetitions, folder / f"{digest}.parquet")


def _claim(directory: Path, study: StudyDefinition) -> None:
    """Refuse a folder that is not this study's: nothing of another's is ever overwritten."""
    if directory.exists() and not directory.is_dir():
        raise ResultsError(f"{directory}: is not a folder")
    if not directory.exists() or not any(directory.iterdir()):
        return
    name = load_manifest(directory).get("study", {}).get("name")
    if name != study.name:
        raise ResultsError(f"{directory}: holds the study {name!r}; choose another folder")


def _manifest(study: StudyDefinition, layouts: list[Layout], cases: int) -> dict[str, Any]:
    definition = {
        "name": study.name,
        "methods": list(study.methods),
        "scenarios": [str(s) for s in study.scenarios],
        "seed": study.seed,
        "max_items": study.max_items,
        "limit": study.limit,
        "snap_gap": study.snap_gap,
        "repetitions": study.repetitions,
        "files": [file.name for file in study.files],
    }
    data = hashlib.sha256("".join(lay.content_hash() for lay in layouts).encode()).hexdigest()
    return {
        "schema_version": SCHEMA_VERSION,
        "study": definition,
        "study_hash": hashlib.sha256(json.dumps(definition).encode()).hexdigest()[:16],
        "data_hash": data[:16],
        "layouts": len(layouts),
        "cases": cases,
        **provenance(),
        "started": _now(),
        "finished": None,
    }


def _write_manifest(directory: Path, manifest: dict[str, Any]) -> None:
    write_atomically(directory / "manifest.json", json.dumps(manifest, indent=1) + "\n")


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
