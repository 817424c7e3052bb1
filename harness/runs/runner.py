"""Methods x layouts -> results: split into units, judged by any executor, resumable.

Layouts, units and rows are iterated and never held all at once, so that a study may have any
number of them. Only the names of shards and of layouts grow with it.
"""

from __future__ import annotations

import hashlib
import json
import logging
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from steadyload.atomic import (
    checksum,
    clear_unfinished,
    is_unfinished,
    manifest_text,
    not_a_link,
    write_atomically,
)
from steadyload.layouts.benchmark import Benchmark
from steadyload.methods.contract.method import Method
from steadyload.progress import Progress, silent
from steadyload.runs.blocks import (
    Block,
    BlockStore,
    BlockUnit,
    block_unit,
    blocks_of,
    handed_out,
    judged_in_blocks,
    judging_blocks,
    write_copy,
)
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.envelope_use import EnvelopeCount
from steadyload.runs.kept_only import NotKeptError, refuse_unless_kept
from steadyload.runs.labels import (
    LABELS_FILE,
    Case,
    Material,
    as_labels,
    labelled_material,
    own_material,
)
from steadyload.runs.pool import IN_THIS_PROCESS, Executor, PartLimit
from steadyload.runs.provenance import provenance
from steadyload.runs.results import (
    LAYOUTS_FILE,
    SCHEMA_VERSION,
    load_manifest,
    result_store,
)
from steadyload.runs.store import (
    ResultsError,
    Store,
    Survey,
    checksum_of,
    is_whole,
    locked,
)
from steadyload.runs.units import (
    SHARD_SIZE,
    Row,
    Unit,
    crashed_row,
    hard_limit,
    judge_unit,
    made_now,
    study_units,
    usual_size,
)

_log = logging.getLogger("steadyload")

_FRESH = f".{LAYOUTS_FILE}"
"""Name of the copy of the layouts until it is complete."""

_MADE = ("git", "versions", "machine", "started", "finished")
"""Entries of a manifest on when its verdicts were made, and with what."""

_SINGLE_FILES = (_FRESH, "manifest.json", LABELS_FILE)


def run_study(
    study: StudyDefinition,
    directory: Path,
    *,
    benchmark: Benchmark | None = None,
    workers: int | Executor = IN_THIS_PROCESS,
    rerun: bool = False,
    resume: bool = False,
    limit: PartLimit[Unit, Row] | None = None,
    progress: Progress = silent,
) -> int:
    """Compute the missing rows of a study; returns the number of rows computed now.

    Existing shards are kept when they were made by the same method, layouts, code and engine
    versions; everything else counts as missing. Shards of other runs stay in the folder and are
    not read.

    Args:
        study: the definition of the study.
        directory: the run folder; made when it does not exist.
        benchmark: the labelled set of a study on a part of one; None reads that of the definition.
        workers: processes beside this one, or an executor, in which an engine may crash: that costs
            one row of status ``crashed``, and a judgement that hangs beyond the study's timeout one
            of status ``timeout``. 0 judges in this process, and a crash ends it.
        rerun: compute everything anew.
        resume: require an existing run; without it, a new one is begun where there is none.
        limit: hard limit of a judgement; None for that of the study's timeout.
        progress: called with rows done and rows in all, first with the existing ones.

    Raises:
        ResultsError: the folder holds another study or something else, or another run is at work
            in it, or there is no run to resume.
        EngineNotInstalledError: a method's engine is missing.
        LayoutError, StudyError: see :meth:`StudyDefinition.layouts`.
        BenchmarkError: see :func:`steadyload.runs.labels.labelled_material`.
        NotKeptError: see :func:`steadyload.runs.kept_only.kept_only`.
        OtherCodeError: a process that is to judge states other versions than this one.
        WorkerDiedError: see :func:`steadyload.runs.pool.run_units`.
    """
    if resume and not (directory / "manifest.json").exists():
        raise ResultsError(f"{directory}: holds no run to resume")
    judges = [method.anew() for method in study.made]
    for method in judges:
        method.prepare()
    if study.benchmark is None:
        material = own_material(study)
    else:
        material = labelled_material(study, benchmark)
    _claim(directory, study)
    with locked(directory):
        limit = limit or hard_limit(study.timeout)
        return _run(study, judges, material, directory, workers, rerun, limit, progress)


def _run(
    study: StudyDefinition,
    judges: Sequence[Method],
    material: Material,
    directory: Path,
    workers: int | Executor,
    rerun: bool,
    limit: PartLimit[Unit, Row] | None,
    progress: Progress,
) -> int:
    for name in _SINGLE_FILES:
        clear_unfinished(directory, name)
    fresh, kept = directory / _FRESH, directory / LAYOUTS_FILE
    made_by = made_now(judges)
    in_blocks = judged_in_blocks(study)
    singly = {spec: made for spec, made in made_by.items() if spec not in in_blocks}
    passing = _Passing(EnvelopeCount(judges), of_cases=material.about is not None)
    of_blocks: list[BlockUnit] = []

    def passed(blocks: Iterable[Block]) -> Iterator[Block]:
        for group, block in enumerate(blocks):
            passing.add(block)
            of_blocks.extend(
                block_unit(study, spec, made_by[spec], kept, group, block) for spec in in_blocks
            )
            yield block

    write_copy(fresh, passed(blocks_of(material.layouts)))
    labels = None if material.labels is None else as_labels(material.labels)
    cases = material.cases(fresh) if singly else ()
    blocks, rows = BlockStore(directory), result_store(directory)
    size = _cases_a_unit(directory, study, material, passing)
    block_survey = blocks.survey(of_blocks, rerun=rerun)
    row_survey = rows.survey(study_units(study, passing.judged(cases), singly, size), rerun=rerun)
    survey = block_survey | row_survey
    manifest = _manifest(study, material, passing, survey)
    if not survey.missing and (directory / "manifest.json").exists():
        found = load_manifest(directory)  # no verdict is of the present code or machine
        manifest |= {name: found[name] for name in _MADE if name in found}
    elif survey.present and (directory / "manifest.json").exists():
        manifest["machine"] = _machines(load_manifest(directory), manifest["machine"])
    manifest |= {"cases_a_unit": size, "files": {LAYOUTS_FILE: checksum_of(fresh)}}
    if labels is not None:
        manifest["files"][LABELS_FILE] = checksum(labels)
    if not survey.missing and _is_finished(directory, manifest):
        progress(survey.present, survey.parts)
        fresh.unlink()
        return 0

    def not_kept() -> Iterator[str]:
        singles = study_units(study, material.cases(fresh), singly, size)
        yield from (each.method for each in of_blocks if each.key in survey.missing)
        yield from (each.method for each in singles if each.key in survey.missing)

    try:
        refuse_unless_kept(directory, survey.parts - survey.present, survey.parts, not_kept)
    except NotKeptError:
        fresh.unlink()
        raise
    for key in survey.missing:
        rows.drop(key)
    _write_manifest(directory, {**manifest, "finished": None})
    fresh.replace(kept)
    if labels is None:  # an earlier run may have had some
        (directory / LABELS_FILE).unlink(missing_ok=True)
    else:
        write_atomically(directory / LABELS_FILE, labels)
    computed = 0

    def complete(store: Store[Any, Any], units: Iterable[Any], found: Survey, **how: Any) -> None:
        nonlocal computed
        before = computed
        computed += store.complete(
            units, workers=workers, survey=found, **how,
            progress=lambda at, _: progress(
                survey.present + before + at - found.present, survey.parts
            ),
        )  # fmt: skip

    by_row: dict[str, Any] = {"work": judge_unit, "crashed": crashed_row, "limit": limit}
    again: list[Unit] = []
    if of_blocks:
        how = judging_blocks(limit, again)
        complete(blocks, handed_out(of_blocks, workers), block_survey, **how)
    if again:
        complete(rows, again, Survey.of(again), **by_row)
    if singly:
        units = study_units(study, material.cases(kept), singly, size)
        complete(rows, units, row_survey, **by_row)
    _write_manifest(directory, {**manifest, "finished": manifest["finished"] or _now()})
    return computed


def _cases_a_unit(
    directory: Path, study: StudyDefinition, material: Material, passing: _Passing
) -> int:
    """Cases of a unit, on which the keys of shards depend.

    A run whose study does not say how many goes on as it was begun, also with more cases than then.
    """
    if study.shard_size is not None:
        return study.shard_size
    if (directory / "manifest.json").exists():
        return int(load_manifest(directory).get("cases_a_unit", SHARD_SIZE))
    if material.about is not None:
        return usual_size(material.about["cases"])
    return usual_size(passing.layouts * max(len(study.scenarios), 1))


@dataclass
class _Passing:
    """Facts on a study's layouts that are collected in one pass before it begins."""

    envelope: EnvelopeCount
    of_cases: bool
    """True if the hash of the data covers cases rather than layouts: scenarios follow from a
    study's own layouts, but a labelled set has its own cases."""
    layouts: int = 0
    digest: Any = field(default_factory=hashlib.sha256)

    def add(self, block: Block) -> None:
        """Record some of the layouts."""
        self.layouts += len(block.batch)
        if not self.of_cases:
            self.digest.update(block.fingerprint.encode())

    def judged(self, cases: Iterable[Case]) -> Iterator[Case]:
        """The same cases, recorded as they are iterated."""
        for scenario, layout in cases:
            self.envelope.add(layout)
            if self.of_cases:
                self.digest.update(layout.content_hash().encode())
            yield scenario, layout


def _claim(directory: Path, study: StudyDefinition) -> None:
    """Make the folder, or refuse one that belongs to something else."""
    if directory.exists() and not directory.is_dir():
        raise ResultsError(f"{directory}: is not a folder")
    if (directory / "manifest.json").exists():
        name = _claimed_by(directory)
        if name is not None and name != study.name:
            raise ResultsError(f"{directory}: holds the study {name!r}; choose another folder")
    elif directory.exists() and any(map(_is_foreign, directory.iterdir())):
        raise ResultsError(f"{directory}: holds something that is no study; choose another folder")
    not_a_link(directory / "results").mkdir(parents=True, exist_ok=True)


def _claimed_by(directory: Path) -> str | None:
    """The name of the study that a folder holds; None where a damaged manifest was thrown away.

    Shards are found by their keys, so that only a folder with some is one that can be mended.
    """
    try:
        return str(load_manifest(directory)["study"]["name"])
    except ResultsError:
        shards = (directory / "results").glob("*.parquet")
        if not ((directory / LAYOUTS_FILE).is_file() and any(shards)):
            raise
    path = directory / "manifest.json"
    _log.warning("%s: is damaged; it is thrown away and made again", path)
    path.unlink()
    return None


def _is_foreign(found: Path) -> bool:
    """True if a file is not one that an interrupted start leaves behind."""
    begun = any(is_unfinished(found, name) for name in _SINGLE_FILES)
    return found.name not in ("results", ".lock", _FRESH) and not begun


def _is_finished(directory: Path, manifest: dict[str, Any]) -> bool:
    if not (directory / "manifest.json").exists():
        return False
    found = load_manifest(directory)
    # Labels may have changed under verdicts that have not.
    told = ("schema_version", "shards", "labels", "envelope", "files", "refused")
    if any(found.get(key) != manifest.get(key) for key in told):
        return False
    files = [is_whole(directory / name, total) for name, total in manifest["files"].items()]
    return all(files) and found["finished"] is not None


def _manifest(
    study: StudyDefinition, material: Material, passing: _Passing, survey: Survey
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
    if study.dialect.stated():
        definition["dialect"] = study.dialect.stated()
    definition |= {
        key: value
        for key, value in (("overhang", study.overhang), ("floor", study.floor))
        if value is not None
    }
    if study.benchmark is not None:
        definition["benchmark"] = str(study.benchmark)
    return {
        "schema_version": SCHEMA_VERSION,
        "study": definition,
        "study_hash": hashlib.sha256(json.dumps(definition).encode()).hexdigest()[:16],
        "data_hash": passing.digest.hexdigest()[:16],
        "layouts": passing.layouts,
        "rows": survey.parts,
        "shards": list(survey.keys),
        **({} if material.about is None else {"labels": material.about}),
        **({"refused": material.refused.stated()} if material.refused.count else {}),
        "envelope": passing.envelope.use,
        **provenance(),
        "started": _now(),
        "finished": None,
    }


def _machines(before: Mapping[str, Any], now: str) -> str:
    """The machines on which the verdicts of a folder were made, this one last."""
    known = [one for one in str(before.get("machine", "")).split("; ") if one and one != now]
    return "; ".join([*known, now])


def _write_manifest(directory: Path, manifest: dict[str, Any]) -> None:
    write_atomically(directory / "manifest.json", manifest_text(manifest))


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
