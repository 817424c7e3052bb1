"""Labels of large layouts for both questions, by screening, written into the tables of a set.

How a case is labelled: :mod:`steadyload.labelling.screened_loading`.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from steadyload.engines.registry import package_versions
from steadyload.labelling.building.splits import splits_of_manifest
from steadyload.labelling.label_rows import LABEL, case_row
from steadyload.labelling.screened_loading import (
    MOST_BY_ONE,
    SCREEN,
    SCREENS,
    ScreenedLoading,
    screens_of,
)
from steadyload.layouts.benchmark.dataset import KEYS, Benchmark, load_benchmark
from steadyload.layouts.benchmark.parts import Part
from steadyload.layouts.benchmark.tables import (
    CASES,
    LABELS,
    SCREENED,
    SCREENING,
    UNLABELLED,
    BenchmarkError,
    read_further,
    read_tables,
    write_further,
    write_tables,
)
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.question import Question
from steadyload.methods.contract.method import Status
from steadyload.methods.registry import make_method
from steadyload.methods.simulation import step_answers
from steadyload.progress import Progress, silent
from steadyload.runs.asked import AskedCases, asked
from steadyload.runs.pool import IN_THIS_PROCESS, PartLimit
from steadyload.runs.provenance import made_by, provenance
from steadyload.runs.store import Store, locked, parquet

VERSION = 1
"""Version of rows: raised when they come out differently."""

VERSION_BY_TWO = 1
"""The same for layouts that two simulations screen."""

CASE_SECONDS = 4 * 3600.0
"""Hard limit on the CPU time of a case."""

_TURNS = {Part.VALIDATION: 0, Part.TEST: 1, Part.TRAIN: 2}


class ScreenedUnit(AskedCases, what="both"):
    """Some cases to be labelled."""

    made_by: Mapping[str, str] = asked("made by")

    def describe(self, part: int) -> str:
        """Description of a case for messages."""
        return f"labels by screening of {super().describe(part)}"


def label_screened(
    directory: Path,
    *,
    most_items: int | None = None,
    workers: int = IN_THIS_PROCESS,
    progress: Progress = silent,
) -> int:
    """Label the unlabelled cases of a set for both questions; returns how many have labels now.

    Validation comes first, on which thresholds are fitted, then test, then training, each in an
    order that does not depend on the size of layouts: labels of an interrupted run are a sample of
    a part. Whatever is done when this ends, or is interrupted, is written into the tables, and is
    not done again; so is what the table ``begun`` of the set holds, see :func:`keep_begun`.

    Args:
        directory: of the set; its tables are written anew.
        most_items: only cases of at most so many items; None for all.
        workers: see :func:`steadyload.runs.runner.run_study`.
        progress: called with the cases done and those to be done.

    Raises:
        BenchmarkError: no labelled set, or one of ``benchmark build``, which is labelled and split
            in another way.
        ResultsError: another run is at work in the folder.
        WorkerDiedError: see :func:`steadyload.runs.pool.run_units`.
    """
    benchmark = load_benchmark(directory)
    if "splits" in benchmark.manifest:
        raise BenchmarkError(
            f"{directory}: was made by `benchmark build`; allowed: a set of large layouts, such as "
            f"`benchmark build-real` makes; for this one run steadyload benchmark label {directory}"
        )
    cases = benchmark.cases[benchmark.cases["status"] == UNLABELLED]
    if most_items is not None:
        cases = cases[cases["item_count"] <= most_items]
    turn = cases["split"].map(_TURNS.get).fillna(len(_TURNS))
    drawn = (cases["layout"] + " " + cases["scenario"]).map(lambda case: zlib.crc32(case.encode()))
    cases = cases.assign(turn=turn, drawn=drawn).sort_values(["turn", "drawn"], kind="stable")
    store = Store(directory / "screening", parquet(SCREENED))
    units = _units(benchmark, cases)
    with locked(directory):
        _take_up(directory, "begun", store, units)
        try:
            _complete(store, units, workers, progress)
        finally:
            done = [store.read(unit.key) for unit in units if unit.key in store]
            if done:
                _merge(directory, pd.concat(done, ignore_index=True))
    return int((read_tables(directory)[1]["status"] != UNLABELLED).sum())


def keep_begun(directory: Path, into: Path) -> int:
    """Keep the rows of cases that another set calls unlabelled in its table ``begun``.

    Nothing else of that set changes, and nobody but :func:`label_screened` reads that table, so
    that rows are kept before their part is whole. A run may be at work in the first folder.

    Args:
        directory: of the set that is being labelled.
        into: of the set, such as the package's own, of which ``directory`` is a copy.

    Returns:
        The number of rows that are kept there now.

    Raises:
        BenchmarkError: ``into`` is no labelled set, or the same folder.
        ResultsError: a row is damaged.
    """
    return _write_begun(into, _kept(into, "begun", directory, "screening"))


def keep_again(directory: Path, into: Path) -> int:
    """Keep the rows of labels that were made again in the table ``again`` of another set.

    :func:`label_again` on a copy of that set goes on from them.

    Args:
        directory: as of :func:`keep_begun`, which raises alike.
        into: likewise.

    Returns:
        The number of rows that are kept there now.
    """
    rows = _kept(into, "again", directory, "again")
    if len(rows):
        write_further(into, "again", rows.sort_values("key"), {"cases": len(rows)})
    return len(rows)


def _kept(into: Path, table: str, directory: Path, folder: str) -> pd.DataFrame:
    """The rows of a table of a set, and those that lie in a folder of another one."""
    if into.resolve() == directory.resolve():
        raise BenchmarkError(f"{into}: is the set that is labelled; allowed: another folder")
    store = Store(directory / folder, parquet(SCREENED))
    rows = [store.read(key).assign(key=key) for key in sorted(store.keys())]
    return pd.concat([read_further(into, table), *rows]).drop_duplicates("key", keep="last")


def _write_begun(directory: Path, begun: pd.DataFrame) -> int:
    """Write the rows of the cases that a set calls unlabelled; returns how many there are."""
    cases = read_tables(directory)[1]
    left = begun.merge(cases.loc[cases["status"] == UNLABELLED, KEYS], on=KEYS)
    write_further(directory, "begun", left.sort_values("key"), {"cases": len(left)})
    return len(left)


def _take_up(directory: Path, table: str, store: Store, units: Sequence[ScreenedUnit]) -> None:
    """Make shards of the rows of a table that would be made alike today."""
    kept = read_further(directory, table)
    wanted = {unit.key for unit in units if unit.key not in store}
    for key, rows in kept[kept["key"].isin(wanted)].groupby("key"):
        store.write(str(key), rows.to_dict("records"))


@dataclass(frozen=True, slots=True)
class Again:
    """Labels that were made once more, from scratch.

    Attributes:
        cases: names and scenarios of the cases.
        differ: of those of which a label, or what was seen at some step, is another.
    """

    cases: tuple[tuple[str, str], ...]
    differ: tuple[tuple[str, str], ...]


def label_again(
    directory: Path,
    count: int,
    *,
    seed: int = 0,
    least_items: int = 1,
    workers: int = IN_THIS_PROCESS,
    progress: Progress = silent,
) -> Again:
    """Label cases of a set again, drawn at random, and compare; the tables stay as they are.

    The rows lie in ``again/`` in the folder, and are not made once more while they are there, nor
    are those in the table ``again`` of the set, see :func:`keep_again`.

    Args:
        directory: of the set.
        count: cases to draw, of those that were labelled by screening; all where they are fewer.
        seed: of the draw, 0 or more.
        least_items: only cases of at least so many items.
        workers: see :func:`steadyload.runs.runner.run_study`.
        progress: called with the cases done and those to be done.

    Raises:
        BenchmarkError: no labelled set, or no such case in it.
        ResultsError: another run is at work in the folder.
        WorkerDiedError: see :func:`steadyload.runs.pool.run_units`.
    """
    benchmark = load_benchmark(directory)
    cases = benchmark.cases.merge(benchmark.screening[KEYS], on=KEYS)
    cases = cases[(cases["status"] == Status.DONE) & (cases["item_count"] >= least_items)]
    if cases.empty:
        raise BenchmarkError(
            f"{directory}: no case of {least_items} or more items was labelled by screening; "
            "allowed: a set that steadyload benchmark screen has labelled"
        )
    cases = cases.sample(min(count, len(cases)), random_state=seed).sort_values("item_count")
    units = _units(benchmark, cases)
    store = Store(directory / "again", parquet(SCREENED))
    with locked(directory):
        _take_up(directory, "again", store, units)
        _complete(store, units, workers, progress)
    rows = pd.concat([store.read(unit.key) for unit in units], ignore_index=True)
    now = _compared(rows, rows.rename(columns={"stands": "status_stands"}))
    stands = benchmark.labels_on(Question.STANDS)[[*KEYS, "status", "failing_step"]].rename(
        columns={"status": "status_stands", "failing_step": "failing_step_stands"}
    )
    then = _compared(rows, benchmark.cases.merge(stands, on=KEYS), benchmark.screening)
    names = tuple(zip(rows["layout"], rows["scenario"], strict=True))
    return Again(names, tuple(each for each in names if now[each] != then[each]))


_COMPARED = (
    "status", "failing_step", "status_stands", "failing_step_stands", "screen", "second",
    "reference", "why",
)  # fmt: skip


def _compared(
    asked: pd.DataFrame, table: pd.DataFrame, more: pd.DataFrame | None = None
) -> dict[tuple[str, str], str]:
    """By case, a text of the labels and of what was seen."""
    whole = table if more is None else table.merge(more, on=KEYS)
    whole = whole.set_index(KEYS).loc[list(zip(asked["layout"], asked["scenario"], strict=True))]
    texts = whole[list(_COMPARED)].map(_text).agg(" ".join, axis=1)
    return dict(zip(texts.index, texts, strict=True))


def _text(value: Any) -> str:
    if isinstance(value, list | np.ndarray):
        return str([_text(each) for each in value])
    if value is None or pd.isna(value):
        return ""
    return str(value) if isinstance(value, str) else f"{float(value):.4f}"


def _units(benchmark: Benchmark, cases: pd.DataFrame) -> list[ScreenedUnit]:
    """A unit a case."""
    both: tuple[tuple[str, ...], ...] = (SCREEN,), SCREENS
    made = {screens: screened_by(screens) for screens in both}
    layouts = (
        (scenario, benchmark.layout(name, scenario))
        for name, scenario in zip(cases["layout"], cases["scenario"], strict=True)
    )
    return [ScreenedUnit((case,), made[screens_of(len(case[1]))]) for case in layouts]


def _complete(
    store: Store, units: Sequence[ScreenedUnit], workers: int, progress: Progress
) -> None:
    store.complete(
        units,
        screened_rows,
        crashed=partial(_lost_row, Status.CRASHED),
        limit=PartLimit(CASE_SECONDS, partial(_lost_row, Status.TIMEOUT)),
        workers=workers,
        progress=progress,
    )


def screened_by(screens: tuple[str, ...]) -> dict[str, str]:
    """Everything besides the cases that rows depend on, with the present code and packages.

    Args:
        screens: as of :func:`steadyload.labelling.screened_loading.screens_of`.
    """
    own = dict(zip(("screen", "second"), screens, strict=False)) | {"reference": LABEL}
    return {
        **{
            f"{role}: {name}": value
            for role, spec in own.items()
            for name, value in made_by(make_method(spec)).items()
        },
        **package_versions(("numpy", "scipy")),
        "version of answers": str(step_answers.VERSION),
        "version of rows": str(VERSION_BY_TWO if screens == SCREENS else VERSION),
    }


def screened_rows(unit: ScreenedUnit) -> Iterator[dict[str, Any]]:
    """Prepare, then label a unit's cases, in turn: a row for every one."""
    most = max(len(layout) for _, layout in unit.cases)
    for spec in (*screens_of(most), LABEL):
        make_method(spec).prepare(most)
    return (screened_row(scenario, layout) for scenario, layout in unit.cases)


def screened_row(scenario: str, layout: Layout) -> dict[str, Any]:
    """A case's labels for both questions, with what was seen at every step."""
    with closing(ScreenedLoading(scenario, layout)) as loading:
        return loading.row()


def _lost_row(status: Status, unit: ScreenedUnit, part: int, reason: str) -> dict[str, Any]:
    own = case_row(*unit.cases[part], status, reason)
    return dict.fromkeys(SCREENED.names) | own | {"stands": str(status)}


def _merge(directory: Path, rows: pd.DataFrame) -> None:
    """Write labels into the tables of a set."""
    layouts, cases, opinions, manifest = read_tables(directory)
    labels = read_further(directory, "labels")
    screening = read_further(directory, "screening")
    shared = [name for name in CASES.names if name in rows and name not in KEYS]
    new = rows.set_index(KEYS)[shared]
    cases = cases.set_index(KEYS)
    for name in shared:
        cases[name] = cases[name].astype(object)
        cases.loc[new.index, name] = new[name].astype(object)
    cases = cases.reset_index().join(layouts.set_index("layout")["instance"], on="layout")
    cases = splits_of_manifest(cases, manifest)[CASES.names]
    own = rows[[*KEYS, "stands", "failing_step_stands", "moved_item"]].rename(
        columns={"stands": "status", "failing_step_stands": "failing_step"}
    )
    own = own.assign(question=str(Question.STANDS)).reindex(columns=LABELS.names)
    labels = _with(labels, own)
    steps = rows[SCREENING.names].dropna(subset="screen")
    screening = _with(screening, steps)
    made = {
        "label": LABEL, "screen": SCREEN, "screens": list(SCREENS), "most_by_one": MOST_BY_ONE,
        "labelled_with": provenance(),
    }  # fmt: skip
    # The cases come last: what they call labelled is in the other tables by then.
    write_further(directory, "labels", labels, {str(Question.STANDS): made})
    write_further(directory, "screening", screening, made)
    write_tables(directory, layouts, cases, opinions, {**manifest, **made}, keep_further=True)
    begun = read_further(directory, "begun")
    if len(begun):
        _write_begun(directory, begun)


def _with(table: pd.DataFrame, rows: pd.DataFrame) -> pd.DataFrame:
    """A table with further rows, which replace those of the same cases.

    An interrupted command may have written some of them before.
    """
    return pd.concat([table, rows]).drop_duplicates(KEYS, keep="last", ignore_index=True)
