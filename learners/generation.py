"""Larger sets to learn from: fresh item lists, packed, labelled by any method, in the form of a
labelled set whose cases are all ``train``.

A folder is worked on in place: every item list has a shard of its own in a
:class:`steadyload.runs.store.Store`, and an interrupted run goes on where it was.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa

from steadyload.atomic import is_unfinished, manifest_text, write_atomically
from steadyload.layouts.benchmark import BenchmarkError
from steadyload.layouts.benchmark.dataset import row_of
from steadyload.layouts.benchmark.parts import LABELLED_ITEM_COUNTS, Part
from steadyload.layouts.benchmark.tables import (
    CASES,
    LAYOUTS,
    OPINIONS,
    SET_FILES,
    write_tables,
)
from steadyload.layouts.model.scenarios import Scenario, draw_case
from steadyload.layouts.packing.heuristics import HEURISTICS
from steadyload.layouts.packing.packing import generate, make_instance
from steadyload.learners import LearnerError
from steadyload.learners.sequences import HeldOut, geometry_of
from steadyload.methods.contract.method import Status
from steadyload.methods.registry import make_method
from steadyload.progress import Progress, silent
from steadyload.runs.pool import SinglePart
from steadyload.runs.provenance import provenance, raised
from steadyload.runs.store import Codec, Store, locked, parquet
from steadyload.stored import differing, store_list, stored_list, stored_object

VERSION = 1
"""Of what is packed and drawn: raised when the same options give another set."""

OWN_SEEDS = 1_000_000_000
"""Item lists are drawn from seeds above this; those of labelled sets are below."""

LISTS: Mapping[int, int] = {1: 1, 2: 1, 3: 8}
"""Item lists of a class for one of the first. Labelled sets hold some eight times as many layouts
of class 3, whose lists fill many bins: a network is to learn the classes as it will meet them."""

_SHARDS, _ASKED, _RUNS = "shards", "asked.json", "made_with.json"

_LABELLED = parquet(pa.schema([*CASES, *(f for f in LAYOUTS if f.name not in CASES.names)]))
"""A row a case, with all of its layout."""

Row = dict[str, Any]


@dataclass(frozen=True, slots=True)
class GenerationOptions:
    """Options of generating a labelled set.

    Args:
        lists: of classes 1 and 2, item lists each; of class 3 more, see :data:`LISTS`.
        label: spec of the method whose verdicts are the labels.
        seed: of item lists, heuristics and centres of mass; 0 or more.
        heuristics: that pack every list, drawn from the 160 for each anew. Few of them on many
            lists teach more than all of them on few, at the same cost.
        most: layouts that are kept of an item list, drawn at random.
        scenarios: where centres of mass lie.

    Raises:
        LearnerError: a number out of its range.
        SpecError: no such method.
    """

    lists: int
    label: str = "label@reference"
    seed: int = 0
    heuristics: int = 16
    most: int = 24
    scenarios: tuple[str, ...] = tuple(str(s) for s in Scenario)

    def __post_init__(self) -> None:
        for name, most in (("lists", 10**6), ("heuristics", len(HEURISTICS)), ("most", 10**4)):
            if not 1 <= getattr(self, name) <= most:
                raise LearnerError(f"{name} is {getattr(self, name)}; allowed: 1 to {most}")
        if not 0 <= self.seed < OWN_SEEDS:
            raise LearnerError(f"seed is {self.seed}; allowed: 0 to {OWN_SEEDS - 1}")
        make_method(self.label)

    def identity(self) -> dict[str, Any]:
        """Identity of a set, shared by all its shards. More lists begin with the same ones."""
        found = dataclasses.asdict(self)
        del found["lists"]
        return found | {"scenarios": list(self.scenarios)} | raised(VERSION)


@dataclass(frozen=True, slots=True)
class ListUnit(SinglePart):
    """One item list: packed and labelled in one go, into one shard."""

    class_number: int
    number: int
    options: GenerationOptions

    @property
    def key(self) -> str:
        """The key of its shard; options are those of the folder."""
        return f"{self.class_number}_{self.number:06d}"

    def describe(self, part: int) -> str:
        """The list for people."""
        return f"{self.options.label} on item list {self.number} of class {self.class_number}"


def generate_labelled(
    options: GenerationOptions,
    directory: Path,
    *,
    workers: int = 1,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Make a labelled set to train on; an interrupted run is resumed.

    Layouts that are by chance geometries of held-out layouts are left out, and so are cases that
    the method gave no label.

    Args:
        options: what to draw, and who labels.
        directory: of the set; made when it does not exist.
        workers: processes beside this one, see :func:`steadyload.runs.pool.run_units`.
        progress: called with item lists done and item lists in all.

    Returns:
        The manifest.

    Raises:
        LearnerError: the folder holds another set.
        ResultsError: another run is at work in the folder.
        WorkerDiedError: see :func:`steadyload.runs.pool.run_units`.
    """
    make_method(options.label).prepare()
    with locked(directory):
        _claim(directory, options)
        units = [
            ListUnit(number, which, options)
            for group in range(options.lists)
            for number, many in LISTS.items()
            for which in range(group * many, (group + 1) * many)
        ]
        store: Store[list[Row], pd.DataFrame] = Store(
            directory / _SHARDS, Codec(".parquet", _encoded, _LABELLED.decode)
        )
        survey = store.survey(units)
        runs = _runs(directory, at_work=bool(survey.missing))
        crashed: list[str] = []
        store.complete(
            units,
            _label_list,
            lost=lambda unit, reason: crashed.append(f"{unit.describe(0)}: {reason}"),
            workers=workers,
            progress=progress,
            survey=survey,
        )
        whole = [store.read(unit.key) for unit in units if unit.key in store]
        return _gather(directory, options, whole, crashed, runs)


def _claim(directory: Path, options: GenerationOptions) -> None:
    asked = directory / _ASKED
    if asked.exists():
        found = stored_object(asked, "remove it and run again with the options of before")
        if found != options.identity():
            differs = differing(found, options.identity())
            raise LearnerError(
                f"{directory}: holds another set ({differs} differ); choose another "
                "folder, or remove it"
            )
    elif any(map(_is_foreign, directory.iterdir())):
        raise LearnerError(f"{directory}: holds something else; choose another folder")
    write_atomically(asked, manifest_text(options.identity()))


def _is_foreign(found: Path) -> bool:
    """Not what an interrupted beginning leaves, nor the set that its shards were gathered to."""
    own = found.name in (_SHARDS, _RUNS, ".lock") or is_unfinished(found, _ASKED)
    return not own and not (found.name in SET_FILES and (found.parent / _SHARDS).is_dir())


def _runs(directory: Path, *, at_work: bool) -> list[dict[str, Any]]:
    """Runs that made the shards, oldest first, with this run if it is about to make some."""
    path = directory / _RUNS
    runs = stored_list(path, "runs", "remove it, and which earlier runs made the set is unknown")
    now = provenance()
    if not runs or (at_work and runs[-1] != now):
        runs.append(now)
        store_list(path, "runs", runs)
    return runs


def _encoded(answers: Sequence[list[Row]]) -> bytes:
    [rows] = answers
    return _LABELLED.encode(rows)


def _label_list(unit: ListUnit) -> Iterator[list[Row]]:
    """Pack and label one item list: the rows of its cases."""
    method = make_method(unit.options.label)
    method.prepare()
    return (_rows(unit, method) for _ in range(1))


def _rows(unit: ListUnit, method: Any) -> list[Row]:
    options = unit.options
    root = OWN_SEEDS + options.seed
    random = np.random.default_rng(np.random.SeedSequence([root, unit.class_number, unit.number]))
    count = LABELLED_ITEM_COUNTS.get(unit.class_number)
    instance = make_instance(unit.class_number, unit.number, seed=root, item_count=count)
    name = f"Seed_{options.seed}_{instance.name}"
    which = sorted(random.choice(len(HEURISTICS), options.heuristics, replace=False).tolist())
    packed = generate([instance], heuristics=[HEURISTICS[k] for k in which])
    kept = sorted(random.permutation(len(packed))[: options.most].tolist())
    rows = []
    for k in kept:
        layout = packed[k].layout.renamed(f"Seed_{options.seed}_{packed[k].layout.name}")
        geometry = row_of(layout, name, unit.class_number, packed[k].sources)
        for scenario in options.scenarios:
            drawn = draw_case(layout, Scenario(scenario), root)
            verdict = method.judge(drawn)
            rows.append(
                {
                    **geometry,
                    "scenario": scenario,
                    "item_count": len(layout),
                    "offsets": drawn.mass_offsets.ravel().tolist()
                    if drawn.mass_offsets.any()
                    else None,
                    "split": str(Part.TRAIN),
                    "rank": 0,
                    "status": str(verdict.status),
                    "failing_step": verdict.failing_step,
                }
            )
    return rows


def _gather(
    directory: Path,
    options: GenerationOptions,
    whole: list[pd.DataFrame],
    crashed: list[str],
    runs: list[dict[str, Any]],
) -> dict[str, Any]:
    """All shards as one labelled set."""
    if not whole:
        raise BenchmarkError(f"{directory}: no item list could be labelled; {crashed[0]}")
    rows = pd.concat(whole, ignore_index=True)
    layouts = rows[LAYOUTS.names].drop_duplicates("layout", ignore_index=True)
    cases = rows[CASES.names]
    held_out = HeldOut.of()
    hashes = np.array([geometry_of(row) for row in layouts.to_dict("records")])
    twins = np.isin(hashes, list(held_out.geometries))
    again = pd.Series(hashes).duplicated().to_numpy()  # two lists, one geometry
    layouts = layouts[~(twins | again)].reset_index(drop=True)
    cases = cases[cases["layout"].isin(layouts["layout"])]
    labelled = cases["status"] == str(Status.DONE)
    unlabelled = cases["status"][~labelled].value_counts().to_dict()
    cases = cases[labelled].reset_index(drop=True)
    # Ranks are drawn, so that the first ones are a fair part of the whole.
    random = np.random.default_rng(np.random.SeedSequence([OWN_SEEDS + options.seed]))
    for _, group in cases.groupby("scenario", sort=True):
        cases.loc[random.permutation(group.index.to_numpy()), "rank"] = np.arange(len(group))
    manifest = {
        "origin": "generated to learn from",
        **options.identity(),
        "seed": OWN_SEEDS + options.seed,
        "lists": options.lists,
        "left_out": {
            "held-out geometries": int(twins.sum()),
            "geometries met again": int(again.sum()),
            "no label": {str(k): int(v) for k, v in unlabelled.items()},
        },
        "crashed": crashed,
        "labelled_with": runs[-1],
        "labelled_with_before": runs[:-1],
    }
    empty = pd.DataFrame({name: [] for name in OPINIONS.names})
    write_tables(directory, layouts, cases, empty, manifest)
    return manifest | {"cases": len(cases), "layouts": len(layouts)}
