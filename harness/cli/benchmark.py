"""``steadyload benchmark``: the labelled set, its contents, import and export."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from steadyload.cli.convert import WRITABLE, output_format
from steadyload.cli.flags import UsageError
from steadyload.cli.interrupts import working
from steadyload.cli.terminal import print_table, progress_bar
from steadyload.config import REQUIRED, operand, option, output_option, stated
from steadyload.studies.benchmark.study import labelled_set

_SHOWN = 10
"""Number of files of a kind that are named after an import; all of them are counted."""


@dataclass(frozen=True, kw_only=True)
class Info:
    """Which set, and the format of the output."""

    directory: str | None = labelled_set()
    json: bool = option(False, "print one JSON object")

    def run(self) -> None:
        """Print counts."""
        from steadyload.layouts.benchmark import load_benchmark
        from steadyload.layouts.benchmark.overview import overview

        found = overview(load_benchmark(self.directory))
        if self.json:
            print(json.dumps(found, indent=1))
            return
        print(
            f"{found['layouts']} layouts of {found['instances']} instances, "
            f"{found['cases']} cases; origin: {found['origin'] or 'not stated'}"
        )
        shares = (f"{s} {100 * share:.1f} %" for s, share in found["natural_stable"].items())
        print("naturally stable: " + (", ".join(shares) or "nothing is labelled"))
        header = ("split", "scenario", "cases", "stable", "unstable", "layouts", "instances")
        _section(
            (*header, "items, mean"),
            [
                (*(str(row[k]) for k in header), f"{row['items_mean']:.1f}")
                for row in found["splits"]
            ],
        )
        print()
        for row in found["labels"]:
            statuses = ", ".join(f"{count} {name}" for name, count in row["status"].items())
            print(f"labels of the question {row['question']}: {statuses or 'none'}")
            if row["cases"]:
                print(
                    f"  confidence: {row['cases']} judged again, {row['robust']} robust, "
                    f"{row['fragile']} fragile; mean {100 * row['mean']:.1f} %"
                )
        _section(
            ("judge", "reason", "cases", "agrees %"),
            [
                [row["judge"], row["reason"], str(row["cases"]), f"{100 * row['agreement']:.1f}"]
                for row in found["judges"]
            ],
        )


def _section(header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    if rows:
        print()
        print_table(header, rows)


@dataclass(frozen=True, kw_only=True)
class Export:
    """Which cases, and the file they are written to."""

    directory: str | None = labelled_set()
    part: str = option(
        "all", "default: all labelled cases", choices="steadyload.layouts.benchmark.parts:Part"
    )
    scenarios: tuple[str, ...] = option(
        (), "only this; may be repeated", names=("--scenario",),
        choices="steadyload.layouts.model.scenarios:Scenario",
    )  # fmt: skip
    limit: int | None = option(None, "only the first N of every scenario", least=1)
    failing: bool = option(False, "only cases that fail by the label of at least one question")
    to: str | None = option(
        None, "format of the output (default: csv for *.csv, native for *.json, parquet for "
        "*.parquet)", choices=WRITABLE,
    )  # fmt: skip
    output: Path = output_option(REQUIRED, "the file that is written")

    def run(self) -> None:
        """Write cases and labels."""
        from steadyload.layouts.benchmark import load_benchmark
        from steadyload.layouts.benchmark.export import export, labels_path
        from steadyload.layouts.formats import Format

        working()
        kind = Format(output_format(self.output, self.to))
        count = export(
            load_benchmark(self.directory), self.output, kind,
            part=self.part, scenarios=self.scenarios, limit=self.limit, failing=self.failing,
        )  # fmt: skip
        print(f"{count} cases -> {self.output}; labels -> {labels_path(self.output)}")


IN_SPLIT = "cases a scenario in the {} split, an even number (default: {})"
"""Description of an option: the split, and the default."""


@dataclass(frozen=True, kw_only=True)
class Import:
    """Folders of the authors' set and of the imported one."""

    directory: Path = operand(REQUIRED, "their folder Data, or one Data_1 or Data_2", metavar="DIR")
    output: Path = output_option(REQUIRED, "folder of the set", metavar="OUT")
    rotation_unit: str = option(
        "degrees", "of raw observations (default: degrees)",
        choices="steadyload.labelling.building.observations:RotationUnit",
    )  # fmt: skip
    split_seed: int | None = option(
        None, "draw training, validation and test by item list (default: no splits)", least=0
    )
    test: int | None = option(None, IN_SPLIT.format("test", "that of the package"), least=2)
    validation: int | None = option(
        None, IN_SPLIT.format("validation", "that of the package"), least=2
    )

    def run(self) -> None:
        """Import the authors' set, and print the differences."""
        from steadyload.labelling.building.authors import import_authors
        from steadyload.labelling.building.observations import RotationUnit
        from steadyload.labelling.building.splits import SIZES

        with progress_bar("reading") as advance:
            found = import_authors(
                self.directory,
                self.output,
                rotation_unit=RotationUnit(self.rotation_unit),
                split_seed=self.split_seed,
                sizes=replace(SIZES, **stated(test=self.test, validation=self.validation)),
                progress=advance,
            )
        print(
            f"{found.layouts} layouts, {found.cases} cases ({found.labelled} labelled, "
            f"{found.unlabelled} not) -> {self.output}"
        )
        print(f"{found.checked} labels held against what moved, {len(found.mismatches)} differ")
        print_first("differs from what moved", found.mismatches)
        print_first("repeats a case with another score", found.conflicts)
        print_first("refused", [f"{place}: {reason}" for place, reason in found.refused])
        print_first("doubtful", found.doubts)


@dataclass(frozen=True)
class Build:
    """Options of a new labelled set."""

    output: Path = output_option(
        Path("runs/benchmark"), "folder of the new set (default: runs/benchmark)", metavar="DIR"
    )
    seed: int | None = option(None, "default: 2024", least=0)
    instances: int | None = option(
        None, "item lists of every class (default: 17, planar 10, lists 30, choosing 20)", least=1
    )
    weights: str = option(
        "paper", "default: paper", choices="steadyload.layouts.packing.packing:WeightRule"
    )
    planar: bool = option(
        False, "items span the full depth: a small set that a 2-D engine can judge"
    )
    lists: bool = option(
        False, "few layouts of each of many item lists, after those of the large set: a test alone"
    )
    choosing: bool = option(
        False, "few layouts of each of further item lists: half for searches of parameters, half "
        "for fitting cascades",
    )  # fmt: skip

    def __post_init__(self) -> None:
        asked = [name for name in ("planar", "lists", "choosing") if getattr(self, name)]
        if len(asked) > 1:
            raise UsageError(f"--{asked[1]}: not allowed with --{asked[0]}")

    def run(self) -> None:
        """Pack the layouts of a new set."""
        from steadyload.labelling.building.build import (
            CHOOSING_OPTIONS,
            LISTS_OPTIONS,
            PLANAR_OPTIONS,
            BuildOptions,
        )
        from steadyload.labelling.labelling import build_set
        from steadyload.layouts.packing.packing import WeightRule

        kinds = (
            (self.planar, PLANAR_OPTIONS), (self.lists, LISTS_OPTIONS),
            (self.choosing, CHOOSING_OPTIONS), (True, BuildOptions()),
        )  # fmt: skip
        chosen = replace(
            next(options for asked, options in kinds if asked),
            weights=WeightRule(self.weights),
            **stated(seed=self.seed, instances=self.instances),
        )
        with progress_bar("packing") as advance:
            count = build_set(chosen, self.output, advance)
        print(f"{count} cases -> {self.output}; next: steadyload benchmark label {self.output}")


def _containers_option() -> Any:
    return option(
        REQUIRED, "instances for containers: NAME.txt_NUMBER_items.csv of PackingSolver, in cm",
        metavar="FOLDER",
    )  # fmt: skip


def _products_option() -> Any:
    return option(
        REQUIRED, "instances of products: *.csv of Alonso et al. (2019)", metavar="FOLDER"
    )


@dataclass(frozen=True, kw_only=True)
class BuildReal:
    """Files that layouts of real size are made from, and the options of the set."""

    pallets: Path = option(
        REQUIRED, "layout file of pallets, named ORDER.order-NUMBER", metavar="FILE"
    )
    containers: Path = _containers_option()
    products: Path = _products_option()
    output: Path = output_option(REQUIRED, "folder of the new set", metavar="DIR")
    seed: int | None = option(None, "default: 2024", least=0)
    container_lists: int | None = option(None, "item lists for containers (default: 28)", least=0)
    pallet_lists: int | None = option(None, "item lists for Euro pallets (default: 28)", least=0)
    further: bool = option(
        False, "and the further lists of the set of the package, as benchmark extend-real adds them"
    )

    def run(self) -> None:
        """Pack the layouts of a set of real size."""
        from steadyload.labelling.building.real import FURTHER, RealInputs, RealOptions
        from steadyload.labelling.labelling import build_real_set, extend_real_set

        chosen = RealOptions(
            **stated(seed=self.seed, containers=self.container_lists, pallets=self.pallet_lists)
        )
        inputs = RealInputs(self.containers, self.products, self.pallets)
        with progress_bar("packing") as advance:
            count = build_real_set(chosen, inputs, self.output, advance)
        if self.further:
            with progress_bar("packing further lists") as advance:
                count += extend_real_set(FURTHER, inputs, self.output, advance)
        print(f"{count} cases -> {self.output}; next: steadyload benchmark screen {self.output}")


@dataclass(frozen=True, kw_only=True)
class ExtendReal:
    """Which set, the files that it was made from, and how many lists are added."""

    directory: Path = operand(
        REQUIRED, "folder of the set of `benchmark build-real`", metavar="DIR"
    )
    containers: Path = _containers_option()
    products: Path = _products_option()
    seed: int | None = option(None, "default: 2025", least=0)
    container_lists: int | None = option(
        None, "item lists for whole containers (default: 21)", least=0
    )
    pallet_lists: int | None = option(None, "item lists for Euro pallets (default: 12)", least=0)

    def run(self) -> None:
        """Add large layouts of further item lists to a set; what it holds stays as it is."""
        from steadyload.labelling.building.real import FURTHER, ListInputs
        from steadyload.labelling.labelling import extend_real_set

        chosen = replace(
            FURTHER,
            **stated(seed=self.seed, containers=self.container_lists, pallets=self.pallet_lists),
        )
        inputs = ListInputs(self.containers, self.products)
        with progress_bar("packing") as advance:
            count = extend_real_set(chosen, inputs, self.directory, advance)
        print(f"{count} cases added; next: steadyload benchmark screen {self.directory}")


def print_first(title: str, entries: Sequence[str]) -> None:
    """Print a line an entry, of many the first, and how many more there are."""
    for entry in entries[:_SHOWN]:
        print(f"{title}: {entry}")
    if len(entries) > _SHOWN:
        print(f"{title}: {len(entries) - _SHOWN} more")
