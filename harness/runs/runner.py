"""Methods x layouts -> results: split into units, judged wherever, resumable.

Nothing here holds all layouts, units or rows: they come in turn, so that a study may have any
number. What grows with it are the names of shards and of layouts.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from steadyload.atomic import write_atomically
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model import Layout
from steadyload.methods.registry import make_method
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.envelope_use import EnvelopeCount
from steadyload.runs.executors import IN_THIS_PROCESS, Executor, run_units
from steadyload.runs.labels import (
    Case,
    Material,
    has_labels,
    labelled_material,
    own_material,
    write_labels,
)
from steadyload.runs.provenance import provenance
from steadyload.runs.results import (
    SCHEMA_VERSION,
    ResultsError,
    is_whole,
    load_manifest,
    write_shard,
)
from steadyload.runs.units import Unit, crashed_row, judge_unit, made_now, study_units

_KEPT = "layouts.json"


def run_study(
    study: StudyDefinition,
    directory: Path,
    *,
    workers: int | Executor = IN_THIS_PROCESS,
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
        workers: processes beside this one, or an executor, in which an engine may crash: that costs
            one row of status ``crashed``. 0 judges in this process, and a crash ends it.
        rerun: compute everything anew.
        resume: there must be a run to go on with; without it, one is begun where there is none.
        progress: called with rows done and rows in all, first with what is already there.

    Raises:
        ResultsError: the folder holds another study or something else, or another run is at work
            in it, or there is no run to resume.
        EngineNotInstalledError: a method's engine is missing.
        LayoutError, StudyError: see :meth:`StudyDefinition.layouts`.
        BenchmarkError: see :func:`steadyload.runs.labels.labelled_material`.
        OtherCodeError: a process that is to judge has other code or packages than this one.
        WorkerDiedError: see :func:`steadyload.runs.executors.run_units`.
    """
    if resume and not (directory / "manifest.json").exists():
        raise ResultsError(f"{directory}: holds no run to resume")
    for spec in study.methods:
        make_method(spec).prepare()
    material = own_material(study) if study.benchmark is None else labelled_material(study)
    _claim(directory, study)
    with locked(directory):
        return _run(study, material, directory, workers, rerun, progress)


def _run(
    study: StudyDefinition,
    material: Material,
    directory: Path,
    workers: int | Executor,
    rerun: bool,
    progress: Callable[[int, int], None],
) -> int:
    results, layouts = directory / "results", directory / f".{_KEPT}"
    for unfinished in (*directory.glob(f".{_KEPT}*"), *results.glob(".*.parquet.*")):
        unfinished.unlink()
    made_by = made_now(study.methods)
    survey = _Survey(EnvelopeCount(study.methods), of_cases=material.about is not None)
    write_layouts(layouts, survey.kept(material.layouts), Format.NATIVE)
    for unit in study_units(study, survey.judged(material.cases(layouts)), results, made_by):
        survey.add(unit, missing=rerun or not is_whole(unit.shard))
    progress(survey.present, survey.rows)
    manifest = _manifest(study, material, survey)
    if not survey.missing and _is_finished(directory, manifest):
        layouts.unlink()
        return 0
    for name in survey.missing:
        (results / f"{name}.parquet").unlink(missing_ok=True)
    _write_manifest(directory, manifest)
    layouts.replace(directory / _KEPT)
    write_labels(directory, material.labels)
    computed = 0
    units = study_units(study, material.cases(directory / _KEPT), results, made_by)
    missing = (unit for unit in units if unit.shard.stem in survey.missing)
    for unit, rows in run_units(judge_unit, missing, workers=workers, crashed=crashed_row):
        write_shard(unit.shard, rows)
        computed += len(rows)
        progress(survey.present + computed, survey.rows)
    _write_manifest(directory, {**manifest, "finished": _now()})
    return computed


@dataclass
class _Survey:
    """What is to be known of a study before it begins, from going through it once."""

    envelope: EnvelopeCount
    of_cases: bool
    """Whether the hash of the data is one of cases, rather than of layouts: scenarios follow from a
    study's own layouts, but a labelled set has its own cases."""
    shards: list[str] = field(default_factory=list)
    missing: set[str] = field(default_factory=set)
    rows: int = 0
    present: int = 0
    layouts: int = 0
    digest: Any = field(default_factory=hashlib.sha256)

    def kept(self, layouts: Iterable[Layout]) -> Iterator[Layout]:
        """The layouts, while they go by."""
        for layout in layouts:
            self.layouts += 1
            if not self.of_cases:
                self.digest.update(layout.content_hash().encode())
            yield layout

    def judged(self, cases: Iterable[Case]) -> Iterator[Case]:
        """The cases, while they go by."""
        for scenario, layout in cases:
            self.envelope.add(layout)
            if self.of_cases:
                self.digest.update(layout.content_hash().encode())
            yield scenario, layout

    def add(self, unit: Unit, *, missing: bool) -> None:
        """Take note of a unit."""
        name = unit.shard.stem
        self.shards.append(name)
        self.rows += len(unit)
        if missing:
            self.missing.add(name)
        else:
            self.present += len(unit)


def _claim(directory: Path, study: StudyDefinition) -> None:
    """Make the folder, or refuse one that is not this study's."""
    if directory.exists() and not directory.is_dir():
        raise ResultsError(f"{directory}: is not a folder")
    if (directory / "manifest.json").exists():
        name = load_manifest(directory)["study"]["name"]
        if name != study.name:
            raise ResultsError(f"{directory}: holds the study {name!r}; choose another folder")
    elif directory.exists() and any(map(_is_foreign, directory.iterdir())):
        raise ResultsError(f"{directory}: holds something that is no study; choose another folder")
    (directory / "results").mkdir(parents=True, exist_ok=True)


def _is_foreign(found: Path) -> bool:
    """Not what an interrupted beginning leaves."""
    return found.name not in ("results", ".lock") and not found.name.startswith(f".{_KEPT}")


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


def _manifest(study: StudyDefinition, material: Material, survey: _Survey) -> dict[str, Any]:
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
    return {
        "schema_version": SCHEMA_VERSION,
        "study": definition,
        "study_hash": hashlib.sha256(json.dumps(definition).encode()).hexdigest()[:16],
        "data_hash": survey.digest.hexdigest()[:16],
        "layouts": survey.layouts,
        "rows": survey.rows,
        "shards": survey.shards,
        **({} if material.about is None else {"labels": material.about}),
        "envelope": survey.envelope.use,
        **provenance(),
        "started": _now(),
        "finished": None,
    }


def _write_manifest(directory: Path, manifest: dict[str, Any]) -> None:
    write_atomically(directory / "manifest.json", json.dumps(manifest, indent=1) + "\n")


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
