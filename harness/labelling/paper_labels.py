"""Labels of the files' cases, made as those of the labelled sets are; a shard at a time.

A label belongs to the content of a case, whatever its name. Those of the package's own options come
with it, in :data:`SHIPPED`; what is missing is made by ``label@reference`` in a
:class:`steadyload.runs.store.Store`, and an interrupted run is resumed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import islice
from pathlib import Path

import pandas as pd
import pyarrow as pa

from steadyload.atomic import write_atomically
from steadyload.labelling.building.paper_files import Case, PaperFiles
from steadyload.labelling.label_rows import CASE_SECONDS, LABEL
from steadyload.layouts.benchmark import Benchmark
from steadyload.layouts.benchmark.dataset import row_of, stored_offsets
from steadyload.layouts.benchmark.parts import Part
from steadyload.layouts.benchmark.tables import CASES, OPINIONS, as_parquet, read_parquet
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.scenarios import Scenario
from steadyload.methods.contract.method import Status
from steadyload.progress import Progress, silent
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.pool import Executor, PartLimit
from steadyload.runs.results import SCHEMA
from steadyload.runs.store import Store, locked, parquet
from steadyload.runs.units import (
    Unit,
    crashed_row,
    judge_unit,
    made_now,
    study_units,
    timed_out_row,
)

SHIPPED = Path(__file__).parent / "paper_labels.parquet"

LABELS = pa.schema(
    [
        pa.field("content", pa.int64(), nullable=False),
        pa.field("failing_step", pa.int16()),
    ]
)
"""A row a labelled case. ``content``: see :func:`content_of`. ``failing_step``: counted from 0,
null for a stable layout."""

_SHARD = 48
_DIGITS = 15
"""Hexadecimal digits of a hash that a whole number of 64 bits holds in any case."""

Labels = Mapping[int, int | None]
"""The failing step by content of the case, None for a stable one; without the unlabelled ones."""


def content_of(layout: Layout) -> int:
    """A number for everything that the label of a case depends on."""
    return int(layout.content_hash()[:_DIGITS], 16)


def shipped_labels(path: Path = SHIPPED) -> dict[int, int | None]:
    """The labels that come with the package.

    Raises:
        BenchmarkError: the file is damaged or of another schema.
    """
    return _by_content(read_parquet(path, LABELS)) if path.exists() else {}


def ship_labels(labels: Labels, path: Path = SHIPPED) -> None:
    """Write labels into the package; equal labels give equal bytes."""
    rows = sorted(labels.items())
    frame = pd.DataFrame(rows, columns=LABELS.names).astype({"failing_step": "Int16"})
    write_atomically(path, as_parquet(frame, LABELS))


def _by_content(frame: pd.DataFrame) -> dict[int, int | None]:
    steps = [None if pd.isna(step) else int(step) for step in frame["failing_step"]]
    return dict(zip(map(int, frame["content"]), steps, strict=True))


def label_files(
    files: PaperFiles,
    work: Path,
    *,
    known: Labels | None = None,
    workers: int | Executor = 1,
    progress: Progress = silent,
) -> Labels:
    """Labels of all cases of some files, made as far as they are missing; some end without one.

    Args:
        files: of which every distinct case is labelled, in the order of their turns.
        work: folder of the shards.
        known: labels that are there already; None for those of the package.
        workers: see :func:`steadyload.runs.runner.run_study`.
        progress: called with the cases done and those of all shards.

    Raises:
        ResultsError: another run is at work in the folder.
        WorkerDiedError: see :func:`steadyload.runs.pool.run_units`.
    """
    found = dict(shipped_labels() if known is None else known)
    units = [
        unit
        for unit in label_units(files)
        if any(content_of(layout) not in found for _, _, layout in unit.judgements)
    ]
    if units:
        with locked(work):
            store = Store(work / "labels", parquet(SCHEMA))
            store.complete(
                units,
                judge_unit,
                crashed=crashed_row,
                limit=PartLimit(CASE_SECONDS, timed_out_row),
                workers=workers,
                progress=progress,
            )
        for unit in units:
            found.update(_labelled(unit, store.read(unit.key)))
    return found


def label_units(files: PaperFiles) -> Iterator[Unit]:
    """Units of work of all cases; those that come first and the others are never in one unit.

    They do not depend on which labels are known, so that shards stay valid when some are shipped.
    """
    definition = StudyDefinition("labels", (LABEL,))
    made = made_now(definition.made)
    for scenario, rows in files.in_turns():
        cases = ((scenario, files.case(row, scenario)) for row in rows)
        for part in _parts(cases):
            yield from study_units(definition, part, made, _SHARD)


def _parts(cases: Iterable[Case]) -> Iterator[tuple[Case, ...]]:
    ahead = iter(cases)
    while part := tuple(islice(ahead, _SHARD)):
        yield part


def _labelled(unit: Unit, rows: pd.DataFrame) -> Iterator[tuple[int, int | None]]:
    """The labels of a shard by content, of the cases that have one."""
    statuses, steps = rows["status"], rows["failing_step"]
    for (_, _, layout), status, step in zip(unit.judgements, statuses, steps, strict=True):
        if status == Status.DONE:
            yield content_of(layout), None if pd.isna(step) else int(step)


def labelled_cases(files: PaperFiles, labels: Labels) -> pd.DataFrame:
    """A row a file and scenario that is labelled, twins included.

    Columns: those of the table of files; ``row``, the file's number; ``scenario``; ``name``, of the
    layout of the case; ``content``, of it; ``failing_step``, the label. Twins share name and
    content in S1.
    """
    parts = []
    for scenario in map(str, Scenario):
        name = files.table["geometry" if scenario == Scenario.S1 else "file"]
        first = files.distinct(scenario, name.index)
        contents = [content_of(files.case(row, scenario)) for row in first]
        content = name.map(dict(zip(name[first], contents, strict=True)))
        own = files.table.assign(row=name.index, scenario=scenario, name=name, content=content)
        known = own[content.isin(list(labels))]
        steps = [labels[int(one)] for one in known["content"]]
        parts.append(known.assign(failing_step=pd.array(steps, dtype="Int16")))
    return pd.concat(parts, ignore_index=True)


def case_layouts(files: PaperFiles, cases: pd.DataFrame) -> list[Layout]:
    """The layouts of some cases, in their order; twins of S1 share one."""
    keys = list(zip(cases["scenario"], cases["name"], strict=True))
    rows = dict(zip(keys, cases["row"], strict=True))
    made = {key: files.case(row, key[0]) for key, row in rows.items()}
    return [made[key] for key in keys]


def set_of(files: PaperFiles, cases: pd.DataFrame) -> Benchmark:
    """Some labelled cases as a set, each once; all are of its test."""
    cases = cases.drop_duplicates(["name", "scenario"]).reset_index(drop=True)
    layouts = case_layouts(files, cases)
    about = zip(layouts, cases["instance"], cases["item_class"], strict=True)
    rows = {
        layout.name: row_of(layout, instance, int(number), (layout.name,))
        for layout, instance, number in about
    }
    table = cases.assign(
        layout=cases["name"],
        offsets=list(map(stored_offsets, layouts)),
        split=str(Part.TEST),
        rank=cases.groupby("scenario").cumcount(),
        status="done",
    ).reindex(columns=[*CASES.names, "instance"])
    opinions = pd.DataFrame(columns=OPINIONS.names)
    return Benchmark(
        pd.DataFrame(rows.values()).set_index("layout"), table, opinions, {"origin": "files"}
    )
