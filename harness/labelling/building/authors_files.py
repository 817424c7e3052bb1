"""The files of the authors' labelled set: which there are, and what each of them says."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.labelling.building.observations import (
    Movements,
    RotationUnit,
    read_movements,
)
from steadyload.layouts.benchmark.tables import BenchmarkError
from steadyload.layouts.files.record import shown
from steadyload.layouts.formats import read_layouts
from steadyload.layouts.model.layout import Layout, LayoutError
from steadyload.layouts.model.scenarios import Scenario
from steadyload.reading import MAX_STORED_BYTES, TooLargeError, content_of, json_of

JOBS, _LABELS = "2_AeJobs", "4_Benchmark"
_INPUTS = ("0_Input", "1_AeULDs", JOBS)
_SCENARIOS = {f"ulds_scenario_{str(s)[1:].lower()}": s for s in Scenario}
_PREFIX = re.compile(r"Data_\d+_Ulds_scenario_(?:1|2a|2b)_", re.I)
_SCORE_TOLERANCE = 1e-3

Key = tuple[str, Scenario, str]
"""Data set, scenario and name of a job."""

ResultFile = tuple[bool, Path]
"""Whether a file lies in ``4_Benchmark``, and where."""


@dataclass(frozen=True, slots=True)
class Job:
    """A job file: which data set and scenario it is of, and its name without these."""

    path: Path
    place: str
    dataset: str
    scenario: Scenario
    name: str

    @property
    def key(self) -> Key:
        """The key by which its files of results are found."""
        return self.dataset, self.scenario, self.name

    @property
    def order(self) -> tuple[Any, ...]:
        """A key to sort by: H2 before H10."""
        parts = [int(p) if p.isdecimal() else p for p in re.split(r"(\d+)", self.name)]
        return self.dataset, parts, list(Scenario).index(self.scenario), self.place


@dataclass(frozen=True, slots=True)
class Label:
    """A case's label and what moved; ``safe`` is the number of items placed safely."""

    safe: int
    movements: Movements | None


def _datasets(root: Path) -> list[Path]:
    if not root.is_dir():
        raise BenchmarkError(f"{root}: is no folder")
    for folder in (root, root / "Data"):
        if (folder / JOBS).is_dir():
            return [folder]
        found = sorted(p for p in folder.glob("Data_*") if (p / JOBS).is_dir())
        if found:
            return found
    raise BenchmarkError(
        f"{root}: holds no {JOBS}; allowed: the authors' folder Data, its parent, or one of "
        "Data_1 and Data_2, unpacked"
    )


def _named_files(root: Path) -> Iterator[tuple[Path, Path, Scenario | None, str]]:
    """JSON files: data set, path, scenario from the folders' names, and name without either."""
    for dataset in _datasets(root):
        for path in sorted(dataset.rglob("*.json")):
            folders = [part.lower() for part in path.relative_to(dataset).parts[:-1]]
            scenario = next((_SCENARIOS[f] for f in folders if f in _SCENARIOS), None)
            if path.name.startswith("."):
                continue
            name = path.name
            while name.lower().endswith(".json"):
                name = name[: -len(".json")]
            yield dataset, path, scenario, _PREFIX.sub("", name, count=1)


def find_files(root: Path) -> tuple[list[Job], dict[Key, list[ResultFile]], list[Path]]:
    """All job files in the order in which they count, result files by job, and stray jobs.

    Args:
        root: the authors' ``Data``, its parent, or one ``Data_1`` or ``Data_2``.

    Raises:
        BenchmarkError: not such a folder.
        OSError: a folder cannot be read.
    """
    jobs, results, strays = [], defaultdict(list), []
    for dataset, path, scenario, name in _named_files(root):
        folder = path.relative_to(dataset).parts[0]
        if scenario is None:
            strays += [path] if folder == JOBS else []
        elif folder == JOBS:
            place = path.relative_to(root).as_posix()
            jobs.append(Job(path, place, dataset.name, scenario, name))
        elif folder not in _INPUTS:
            results[dataset.name, scenario, name].append((folder == _LABELS, path))
    for files in results.values():
        files.sort(key=lambda file: (not file[0], file[1]))
    return sorted(jobs, key=lambda job: job.order), dict(results), strays


@dataclass(frozen=True, slots=True)
class Reader:
    """Reads files of the set, and writes down which it refuses."""

    root: Path
    unit: RotationUnit
    refused: list[tuple[str, str]]

    def layout(self, job: Job, most_items: int) -> Layout | None:
        """A job's first items, or None where it is refused."""
        try:
            layouts = read_layouts(job.path)
            if len(layouts) > 1:
                raise BenchmarkError(f"holds {len(layouts)} layouts; allowed: one")
        except (LayoutError, BenchmarkError, OSError) as error:
            self.refuse(job.path, error)
            return None
        return layouts[0].first(most_items)

    def label(self, files: list[ResultFile], item_count: int) -> Label | None:
        """The first score among a job's result files, and the first observations."""
        safe, movements = None, None
        for benchmark, path in files:
            if safe is not None and movements is not None:
                break
            try:
                content = json_of(content_of(path, MAX_STORED_BYTES))
                if safe is None and _is_label(content, benchmark):
                    safe = _items_placed_safely(content["score"], item_count)
                elif movements is None and _is_observations(content):
                    movements = read_movements(content, item_count, self.unit)
            except (BenchmarkError, TooLargeError) as error:
                self.refuse(path, error)
            except (ValueError, RecursionError):
                self.refuse(path, BenchmarkError("is not valid JSON; is it cut off?"))
            except OSError as error:
                self.refuse(path, error)
        return None if safe is None else Label(safe, movements)

    def refuse(self, path: Path, error: Exception) -> None:
        """Write down a file that cannot be used, and why."""
        # A layout's error begins with the file that it is in; the place is named once.
        reason = str(error).removeprefix(f"{path}: ")
        self.refused.append((path.relative_to(self.root).as_posix(), reason))


def _is_label(content: Any, benchmark: bool) -> bool:
    return isinstance(content, dict) and (set(content) == {"score"} or
        (benchmark and "score" in content and "ulds" not in content))  # fmt: skip


def _is_observations(content: Any) -> bool:
    return (
        isinstance(content, list)
        and bool(content)
        and isinstance(content[0], dict)
        and "itemDeltas" in content[0]
    )


def _items_placed_safely(score: Any, item_count: int) -> int:
    if isinstance(score, list) and len(score) == 1:
        score = score[0]
    number = isinstance(score, int | float) and not isinstance(score, bool)
    if number and -_SCORE_TOLERANCE <= score <= 1.0 + _SCORE_TOLERANCE:
        safe = round(score * item_count)
        if abs(score - safe / item_count) <= _SCORE_TOLERANCE:
            return safe
    raise BenchmarkError(
        f"score is {shown(score)}; allowed: k/{item_count} with k from 0 to {item_count}, "
        f"as the layout has {item_count} items"
    )
