"""The labelled set that the authors of the paper published, brought into our own form.

Their folder (Zenodo 13925610)::

    Data/Data_{1,2}/2_AeJobs/Ulds_scenario_{1,2a,2b}/NAME.json                 what is judged
    Data/Data_{1,2}/4_Benchmark/Ulds_scenario_{1,2a,2b}/done/NAME.json         its score
    Data/Data_{1,2}/4_Benchmark/Ulds_scenario_{1,2a,2b}/done_raw/NAME.json     what moved

This is how their published scripts write it; the folder itself may differ. So only the first line
is relied upon: scores and raw observations are told by their content and looked for under the same
name (``NAME.json.json`` counts, their simulation writes that) in every folder of a data set but its
inputs. What ``4_Benchmark`` holds comes first. ``3_AeResults`` holds scores of *other methods*
under the same names; outside ``4_Benchmark`` a score counts only where it is all that a file holds.

Lengths are in cm, angles in degrees: their scripts set both, and their rule compares the
numbers with 10 as they are.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from steadyload.labelling.building.authors_files import (
    JOBS,
    Job,
    Label,
    Reader,
    find_files,
)
from steadyload.labelling.building.observations import LABEL_T, Movements, RotationUnit
from steadyload.labelling.building.splits import SIZES, SplitSizes, assign_splits
from steadyload.layouts.benchmark.dataset import row_of
from steadyload.layouts.benchmark.tables import (
    CASES,
    LAYOUTS,
    OPINIONS,
    UNLABELLED,
    BenchmarkError,
    refuse_foreign,
    write_tables,
)
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.scenarios import Scenario
from steadyload.layouts.packing.packing import MOST_ITEMS
from steadyload.progress import Progress, silent
from steadyload.statistics.placed import failing_step_of

_PACKED = re.compile(r"H\d+_(Class_(\d+)_Instance_\d+)_ULD_\d+")
_HEURISTIC, _DEVICE = re.compile(r"^H\d+_"), re.compile(r"_(?:ULD|ake|pmc|pge)_?.*$", re.I)
_FOLDERS = "allowed: Ulds_scenario_1, Ulds_scenario_2a, Ulds_scenario_2b"
_LONGEST_ANGLE = 2.0 * math.pi


@dataclass(frozen=True, slots=True)
class ImportSummary:
    """Summary of an import. Files are named relative to the folder that was read.

    Attributes:
        layouts, cases: rows of the two tables.
        labelled, unlabelled: cases with a score, and without.
        checked: labelled cases whose raw observations were compared with the label's rule.
        mismatches: those of them where the rule names another failing step than the score does.
        conflicts: job files that repeat a case but have another score; the first one counts.
        refused: files that could not be used, each with the reason.
        doubts: what is suspicious about the whole.
    """

    layouts: int
    cases: int
    labelled: int
    unlabelled: int
    checked: int
    mismatches: tuple[str, ...]
    conflicts: tuple[str, ...]
    refused: tuple[tuple[str, str], ...]
    doubts: tuple[str, ...]


def import_authors(
    directory: str | Path,
    output: str | Path,
    *,
    rotation_unit: RotationUnit = RotationUnit.DEGREES,
    most_items: int = MOST_ITEMS,
    split_seed: int | None = None,
    sizes: SplitSizes = SIZES,
    progress: Progress = silent,
) -> ImportSummary:
    """Write the authors' set as a folder that :func:`load_benchmark` reads.

    Args:
        directory: as for :func:`read_authors`.
        output: a folder that does not exist, is empty, or holds a labelled set to replace.
        rotation_unit: as for :func:`read_authors`.
        most_items: as for :func:`read_authors`.
        split_seed: draw splits by item list, see :func:`assign_splits`; None gives no case a split.
        sizes: of validation and test.
        progress: as for :func:`read_authors`.

    Raises:
        BenchmarkError: as :func:`read_authors`; ``output`` holds something else; or too few stable
            or unstable cases for splits.
        OSError: a folder cannot be read or written.
    """
    output = Path(output)
    refuse_foreign(output)
    layouts, cases, summary = read_authors(
        directory, rotation_unit=rotation_unit, most_items=most_items, progress=progress
    )
    if split_seed is not None:
        lists = layouts.set_index("layout")[["instance", "item_class"]]
        cases = assign_splits(cases.join(lists, on="layout"), seed=split_seed, sizes=sizes)
    manifest = {
        "origin": "imported",
        "split_seed": split_seed,
        "source": Path(directory).resolve().name,
        "labelled": summary.labelled,
        "unlabelled": summary.unlabelled,
        "checked": summary.checked,
        "mismatches": len(summary.mismatches),
        "conflicts": len(summary.conflicts),
        "refused": len(summary.refused),
        "rotation_unit": str(rotation_unit),
        "most_items": most_items,
    }
    write_tables(output, layouts, cases, pd.DataFrame(columns=OPINIONS.names), manifest)
    return summary


def read_authors(
    directory: str | Path,
    *,
    rotation_unit: RotationUnit = RotationUnit.DEGREES,
    most_items: int = MOST_ITEMS,
    progress: Progress = silent,
) -> tuple[pd.DataFrame, pd.DataFrame, ImportSummary]:
    """The authors' set as tables of layouts and cases, and what there is to say about it.

    Many heuristics pack a bin alike. A *case* is a geometry with its weights, in a scenario, with
    its centres of mass; a job file that repeats one adds its name to ``sources`` of the case's
    layout. A row of the table of layouts is named after the first job of a new case, and holds at
    most one case a scenario. Where two jobs of one geometry differ in their centres of mass (the
    authors drew them per file), both are cases, and the geometry stands in two rows: one has the
    case of S1, which they share, and each its own of S2a and S2b. All rows of one geometry belong
    to the instance of the first, so that a split by instance never parts them.

    Args:
        directory: the authors' ``Data``, its parent, or one ``Data_1`` or ``Data_2``.
        rotation_unit: of the angles in raw observations.
        most_items: layouts are cut to so many items, as they were when they were simulated.
        progress: called with job files read and job files in all.

    Returns:
        Rows of :data:`steadyload.layouts.benchmark.tables.LAYOUTS` and
        :data:`steadyload.layouts.benchmark.tables.CASES`, and a summary. Labels under the criterion
        ``paper`` do not exist: ``failing_step_paper`` is null for every case.

    Raises:
        BenchmarkError: not such a folder, or one without a single readable job.
        OSError: a folder cannot be read.
    """
    root = Path(directory)
    jobs, results, strays = find_files(root)
    collected = _Collected()
    reader = Reader(root, rotation_unit, collected.refused)
    for path in strays:
        reader.refuse(path, BenchmarkError("lies in no folder of a scenario; " + _FOLDERS))
    for done, job in enumerate(jobs, start=1):
        layout = reader.layout(job, most_items)
        if layout is not None:
            found = reader.label(results.get(job.key, []), len(layout))
            collected.add(job, layout, found)
        progress(done, len(jobs))
    if not collected.cases:
        reason = f"; the first is refused: {collected.refused[0][1]}" if collected.refused else ""
        raise BenchmarkError(f"{root}: holds no readable job file in {JOBS}{reason}")
    layouts = pd.DataFrame(list(collected.rows.values()))[LAYOUTS.names]
    cases = pd.DataFrame(list(collected.cases.values()))[CASES.names]
    return layouts, cases.astype({"failing_step": "Int16"}), collected.summary(rotation_unit)


@dataclass(slots=True)
class _Collected:
    """The tables as they grow, one job file after the other."""

    rows: dict[tuple[str, Any], dict[str, Any]] = field(default_factory=dict)
    cases: dict[Any, dict[str, Any]] = field(default_factory=dict)
    refused: list[tuple[str, str]] = field(default_factory=list)
    _places: dict[Any, str] = field(default_factory=dict)
    _owners: dict[Any, dict[str, Any]] = field(default_factory=dict)
    _instances: dict[str, tuple[str, int]] = field(default_factory=dict)
    _names: set[str] = field(default_factory=set)
    _found: dict[Any, Movements] = field(default_factory=dict)
    _conflicts: list[str] = field(default_factory=list)

    def add(self, job: Job, layout: Layout, label: Label | None) -> None:
        geometry = (layout.geometry_hash(), layout.weights.tobytes(), layout.pallet)
        offsets = layout.mass_offsets + 0.0  # one zero, not two
        key = (geometry, job.scenario, offsets.tobytes())
        if key not in self.cases:
            row = self._row(job.name, geometry, layout)
            self.cases[key] = _case(row["layout"], job.scenario, layout, offsets)
            self._owners[key], self._places[key] = row, job.place
        sources = self._owners[key]["sources"]
        if job.name not in sources:
            sources.append(job.name)
        if label is None:
            return
        case, step = self.cases[key], failing_step_of(label.safe, len(layout))
        if case["status"] == UNLABELLED:
            case |= {"status": "done", "failing_step": step}
            self._places[key] = job.place
            if label.movements is not None:
                self._found[key] = label.movements
                case |= _columns(label.movements)
        elif case["failing_step"] != step:
            self._conflicts.append(job.place)

    def _row(self, name: str, geometry: Any, layout: Layout) -> dict[str, Any]:
        if (name, geometry) not in self.rows:
            free, number = name, 1
            while free in self._names:
                number += 1
                free = f"{name}#{number}"
            self._names.add(free)
            instance, item_class = self._instances.setdefault(geometry[0], _instance(name))
            row = row_of(layout.renamed(free), instance, item_class, (name,))
            self.rows[name, geometry] = row
        return self.rows[name, geometry]

    def summary(self, unit: RotationUnit) -> ImportSummary:
        labelled = sum(case["status"] == "done" for case in self.cases.values())
        mismatches = [
            self._places[key]
            for key, movements in self._found.items()
            if movements.failing_step != self.cases[key]["failing_step"]
        ]
        return ImportSummary(
            layouts=len(self.rows),
            cases=len(self.cases),
            labelled=labelled,
            unlabelled=len(self.cases) - labelled,
            checked=len(self._found),
            mismatches=tuple(mismatches),
            conflicts=tuple(self._conflicts),
            refused=tuple(self.refused),
            doubts=tuple(self._doubts(unit)),
        )

    def _doubts(self, unit: RotationUnit) -> Iterator[str]:
        """Doubts about the angles: an item that falls turns by far more than 6 degrees."""
        angle = max((m.largest_value for m in self._found.values()), default=0.0)
        fell = any(m.corner_last.max() > LABEL_T for m in self._found.values())
        if unit is RotationUnit.DEGREES and fell and angle <= _LONGEST_ANGLE:
            yield f"items fall, but no angle exceeds {angle:.3g}: are rotations in radians?"
        if unit is RotationUnit.RADIANS and angle > _LONGEST_ANGLE:
            yield f"an angle is {angle:.3g}, more than a full turn: are rotations in degrees?"


def _instance(name: str) -> tuple[str, int]:
    """Item list and item class in a name; 0 for a name without a class."""
    packed = _PACKED.fullmatch(name)
    if packed is not None and int(packed[2]) < 128:
        return packed[1], int(packed[2])
    return _DEVICE.sub("", _HEURISTIC.sub("", name)) or name, 0


def _case(name: str, scenario: Scenario, layout: Layout, offsets: np.ndarray) -> dict[str, Any]:
    return dict.fromkeys(CASES.names) | {
        "layout": name,
        "scenario": str(scenario),
        "item_count": len(layout),
        "offsets": offsets.ravel().tolist() if offsets.any() else None,
        "status": UNLABELLED,
    }


def _columns(movements: Movements) -> dict[str, Any]:
    columns = ("corner_last", "corner_most", "angle_last", "angle_most")
    lists = {name: getattr(movements, name).tolist() for name in columns}
    return lists | {"moved": movements.moved}
