"""Methods x layouts -> results: split into units, judged over processes, resumable."""

from __future__ import annotations

import fcntl
import hashlib
import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from engines.registry import installed_versions
from harness.atomic import write_atomically
from harness.layouts.formats import Format, write_layouts
from harness.layouts.model import Layout
from harness.methods.method import Method, Status, Verdict, judge
from harness.methods.registry import make_method
from harness.studies.definition import StudyDefinition
from harness.studies.envelope_use import envelope_use
from harness.studies.executors import IN_THIS_PROCESS, run_units
from harness.studies.labels import (
    Material,
    has_labels,
    labelled_material,
    own_material,
    write_labels,
)
from harness.studies.results import (
    SCHEMA_VERSION,
    ResultsError,
    is_whole,
    judged_by,
    load_manifest,
    provenance,
    result_row,
    write_shard,
)

Row = dict[str, Any]
"""A row of :data:`harness.studies.results.SCHEMA`."""


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit of work: one method, what it is to judge, and the shard the rows go to.

    A judgement is a repetition, a scenario and a layout; a row each.
    """

    method: str
    judgements: tuple[tuple[int, str, Layout], ...]
    shard: Path
    timeout: float | None = None

    def __len__(self) -> int:
        return len(self.judgements)

    def without(self, done: int) -> Unit:
        """The unit without its first ``done`` judgements."""
        return replace(self, judgements=self.judgements[done:])

    def describe(self, part: int) -> str:
        """A judgement for people."""
        _, scenario, layout = self.judgements[part]
        return f"{self.method} on layout {layout.name!r} ({scenario})"


def judge_unit(unit: Unit) -> Iterator[Row]:
    """Prepare a unit's method, then judge: a row of the results for every judgement, in turn.

    The first layout is judged once beforehand, so that no reported time holds imports, compilation
    or first connections.
    """
    method = make_method(unit.method)
    method.prepare(max(len(layout) for _, _, layout in unit.judgements))
    return _rows(method, unit)


def _rows(method: Method, unit: Unit) -> Iterator[Row]:
    judge(method, unit.judgements[0][2], unit.timeout)
    for repetition, scenario, layout in unit.judgements:
        verdict = judge(method, layout, unit.timeout)
        yield result_row(layout, scenario, method, repetition, verdict)


def _crashed(unit: Unit, part: int, reason: str) -> Row:
    """The row of a judgement that ends the process it is made in."""
    repetition, scenario, layout = unit.judgements[part]
    verdict = Verdict(item_count=len(layout), status=Status.CRASHED, reason=reason)
    return result_row(layout, scenario, make_method(unit.method), repetition, verdict)


def run_study(
    study: StudyDefinition,
    directory: Path,
    *,
    workers: int = IN_THIS_PROCESS,
    rerun: bool = False,
    resume: bool = False,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> int:
    """Run what is missing of a study; returns the number of rows computed now.

    Shards that are already there are kept when they were made by the same method, layouts, code
    and engine versions; everything else counts as missing. Shards of other runs stay where they
    are and are not read.

    Args:
        study: what to compare.
        directory: the run folder; made when it does not exist.
        workers: processes beside this one, in which an engine may crash: that costs one row of
            status ``crashed``. 0 judges in this process, and a crash ends it.
        rerun: compute everything anew.
        resume: there must be a run to go on with; without it, one is begun where there is none.
        progress: called with rows done and rows in all, first with what is already there.

    Raises:
        ResultsError: the folder holds another study or something else, or another run is at work
            in it, or there is no run to resume.
        EngineNotInstalledError: a method's engine is missing.
        LayoutError, StudyError: see :meth:`StudyDefinition.layouts`.
        BenchmarkError: see :func:`harness.studies.labels.labelled_material`.
        WorkerDiedError: see :func:`harness.studies.executors.run_units`.
    """
    if resume and not (directory / "manifest.json").exists():
        raise ResultsError(f"{directory}: holds no run to resume")
    for spec in study.methods:
        make_method(spec).prepare()
    material = own_material(study) if study.benchmark is None else labelled_material(study)
    _claim(directory, study)
    with locked(directory):
        units = list(_units(study, material.cases, directory / "results"))
        missing = [unit for unit in units if rerun or not is_whole(unit.shard)]
        total = sum(map(len, units))
        present = total - sum(map(len, missing))
        progress(present, total)
        manifest = _manifest(study, material, [unit.shard.stem for unit in units], total)
        if not missing and _is_finished(directory, manifest):
            return 0
        for unit in missing:
            unit.shard.unlink(missing_ok=True)
        for unfinished in (directory / "results").glob(".*.parquet.*"):
            unfinished.unlink()
        _write_manifest(directory, manifest)
        write_layouts(directory / "layouts.json", material.layouts, Format.NATIVE)
        write_labels(directory, material.labels)
        computed = 0
        for unit, rows in run_units(judge_unit, missing, workers=workers, crashed=_crashed):
            write_shard(unit.shard, rows)
            computed += len(rows)
            progress(present + computed, total)
        _write_manifest(directory, {**manifest, "finished": _now()})
    return computed


def _units(study: StudyDefinition, cases: list[tuple[str, Layout]], folder: Path) -> Iterator[Unit]:
    """The study in parts; a shard's name is a hash of all that its rows depend on."""
    for method in study.methods:
        chosen = make_method(method)
        versions = installed_versions(chosen.spec.engine or "")
        made_by = [SCHEMA_VERSION, judged_by(chosen), versions]
        for start in range(0, len(cases), study.shard_size):
            part = tuple(cases[start : start + study.shard_size])
            identity = [method, study.repetitions, study.timeout, *made_by]
            identity += [[s, lay.name, lay.content_hash()] for s, lay in part]
            digest = hashlib.sha256(json.dumps(identity).encode()).hexdigest()[:20]
            judgements = tuple(
                (repetition, scenario, layout)
                for repetition in range(study.repetitions)
                for scenario, layout in part
            )
            yield Unit(method, judgements, folder / f"{digest}.parquet", study.timeout)


def _claim(directory: Path, study: StudyDefinition) -> None:
    """Make the folder, or refuse one that is not this study's."""
    if directory.exists() and not directory.is_dir():
        raise ResultsError(f"{directory}: is not a folder")
    if (directory / "manifest.json").exists():
        name = load_manifest(directory)["study"]["name"]
        if name != study.name:
            raise ResultsError(f"{directory}: holds the study {name!r}; choose another folder")
    elif directory.exists() and {p.name for p in directory.iterdir()} - {"results", ".lock"}:
        raise ResultsError(f"{directory}: holds something that is no study; choose another folder")
    (directory / "results").mkdir(parents=True, exist_ok=True)


@contextmanager
def locked(directory: Path) -> Iterator[None]:
    """One run a folder at a time; the lock goes with the process, however that ends.

    Raises:
        ResultsError: another run is at work in it.
    """
    with (directory / ".lock").open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise ResultsError(f"{directory}: another run is at work in this folder") from None
        yield


def _is_finished(directory: Path, manifest: dict[str, Any]) -> bool:
    if not (directory / "manifest.json").exists():
        return False
    found = load_manifest(directory)
    # Labels may have changed under verdicts that have not.
    same = all(found.get(key) == manifest.get(key) for key in ("shards", "labels", "envelope"))
    complete = manifest.get("labels") is None or has_labels(directory)
    return same and complete and found["finished"] is not None


def _manifest(
    study: StudyDefinition, material: Material, shards: list[str], rows: int
) -> dict[str, Any]:
    definition = {
        "name": study.name,
        "methods": list(study.methods),
        "scenarios": [str(s) for s in study.scenarios],
        "seed": study.seed,
        "max_items": study.max_items,
        "limit": study.limit,
        "snap_gap": study.snap_gap,
        "repetitions": study.repetitions,
        "timeout": study.timeout,
        "files": [file.name for file in study.files],
        "generated": study.generated,
    }
    if study.benchmark is not None:
        definition["benchmark"] = str(study.benchmark)
    # Scenarios follow from a study's own layouts; a labelled set has its own cases.
    judged = material.layouts if material.about is None else [case for _, case in material.cases]
    data = hashlib.sha256("".join(lay.content_hash() for lay in judged).encode()).hexdigest()
    return {
        "schema_version": SCHEMA_VERSION,
        "study": definition,
        "study_hash": hashlib.sha256(json.dumps(definition).encode()).hexdigest()[:16],
        "data_hash": data[:16],
        "layouts": len(material.layouts),
        "rows": rows,
        "shards": shards,
        **({} if material.about is None else {"labels": material.about}),
        "envelope": envelope_use(study.methods, material.cases),
        **provenance(),
        "started": _now(),
        "finished": None,
    }


def _write_manifest(directory: Path, manifest: dict[str, Any]) -> None:
    write_atomically(directory / "manifest.json", json.dumps(manifest, indent=1) + "\n")


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
