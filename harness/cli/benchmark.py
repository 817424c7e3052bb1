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
from steadyload.cli.studies import workers_option
from steadyload.cli.terminal import print_table, progress_bar, resumable, study_progress
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
        print("status: " + ", ".join(f"{count} {name}" for name, count in found["status"].items()))
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
        if found["stands"]:
            stands = (f"{count} {name}" for name, count in found["stands"].items())
            print("\nlabels of the question stands: " + ", ".join(stands))
        sure = found["confidence"]
        if sure["cases"]:
            print(
                f"\nconfidence: {sure['cases']} labels judged again, {sure['robust']} robust, "
                f"{sure['fragile']} fragile; mean {100 * sure['mean']:.1f} %"
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


_IN_SPLIT = "cases a scenario in the {} split, an even number (default: {})"


@dataclass(frozen=True, kw_only=True)
class Import:
    """Folders of the authors' set and of the imported one."""

    directory: Path = operand(REQUIRED, "their folder Data, or one Data_1 or Data_2", metavar="DIR")
    output: Path = output_option(REQUIRED, "folder of the set", metavar="OUT")
    rotation_unit: str = option(
        "degrees", "of raw observations (default: degrees)",
        choices="steadyload.layouts.benchmark.observations:RotationUnit",
    )  # fmt: skip
    split_seed: int | None = option(
        None, "draw training, validation and test by item list (default: no splits)", least=0
    )
    test: int | None = option(None, _IN_SPLIT.format("test", "that of the package"), least=2)
    validation: int | None = option(
        None, _IN_SPLIT.format("validation", "that of the package"), least=2
    )

    def run(self) -> None:
        """Import the authors' set, and print the differences."""
        from steadyload.layouts.benchmark.authors import import_authors
        from steadyload.layouts.benchmark.observations import RotationUnit
        from steadyload.layouts.benchmark.splits import SIZES

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
        _list("differs from what moved", found.mismatches)
        _list("repeats a case with another score", found.conflicts)
        _list("refused", [f"{place}: {reason}" for place, reason in found.refused])
        _list("doubtful", found.doubts)


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
        from steadyload.labelling.labelling import build_set
        from steadyload.layouts.benchmark.build import (
            CHOOSING_OPTIONS,
            LISTS_OPTIONS,
            PLANAR_OPTIONS,
            BuildOptions,
        )
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
        from steadyload.labelling.labelling import build_real_set, extend_real_set
        from steadyload.layouts.benchmark.real import FURTHER, RealInputs, RealOptions

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
        from steadyload.labelling.labelling import extend_real_set
        from steadyload.layouts.benchmark.real import FURTHER, ListInputs

        chosen = replace(
            FURTHER,
            **stated(seed=self.seed, containers=self.container_lists, pallets=self.pallet_lists),
        )
        inputs = ListInputs(self.containers, self.products)
        with progress_bar("packing") as advance:
            count = extend_real_set(chosen, inputs, self.directory, advance)
        print(f"{count} cases added; next: steadyload benchmark screen {self.directory}")


@dataclass(frozen=True)
class Label:
    """Which set, the sizes of the splits, and the further methods."""

    directory: Path = operand(
        Path("runs/benchmark"), "folder of the new set (default: runs/benchmark)", metavar="DIR"
    )
    test: int | None = option(None, _IN_SPLIT.format("test", "as built or labelled last"), least=2)
    validation: int | None = option(
        None, _IN_SPLIT.format("validation", "as built or labelled last"), least=2
    )
    judges: str | None = option(
        None, "further judges of validation and test; `robust` says less with few (default: all)",
        choices=("all", "few", "none"),
    )  # fmt: skip
    question: str = option(
        "within", "stands: whether a load stands once everything rests; of a set that has its "
        "labels and splits (default: within)", choices="steadyload.layouts.model.question:Question",
    )  # fmt: skip
    train: int | None = option(
        None, "with --question stands: this many training cases, too (default: 5000)", least=0
    )
    workers: int = workers_option(0)

    def __post_init__(self) -> None:
        of_within = {"--test": self.test, "--validation": self.validation, "--judges": self.judges}
        of_other = {"--train": self.train} if self.question == "within" else of_within
        for flag, value in of_other.items():
            if value is not None:
                raise UsageError(f"{flag}: not allowed with --question {self.question}")

    def run(self) -> None:
        """Label the missing cases."""
        from steadyload.layouts.model.question import Question

        if self.question == Question.STANDS:
            self._stands()
        else:
            self._within()

    def _stands(self) -> None:
        from steadyload.labelling.label_stands import TRAINING_CASES, label_stands

        with resumable(self.directory), study_progress() as progress:
            count = label_stands(
                self.directory,
                training_cases=TRAINING_CASES if self.train is None else self.train,
                workers=self.workers,
                progress=progress,
            )
        print(f"{count} labels of the question stands -> {self.directory / 'stands.parquet'}")

    def _within(self) -> None:
        from steadyload.labelling.labelling import PANELS, label_set, split_sizes
        from steadyload.layouts.benchmark.tables import read_tables

        built = split_sizes(read_tables(self.directory)[3])
        sizes = replace(built, **stated(test=self.test, validation=self.validation))
        with resumable(self.directory), study_progress() as progress:
            label_set(
                self.directory, sizes=sizes, judges=PANELS[self.judges or "all"],
                workers=self.workers, progress=progress,
            )  # fmt: skip
        print(f"labels and opinions -> {self.directory}")


@dataclass(frozen=True)
class Screen:
    """Which set, and how large its layouts may be."""

    directory: Path = operand(REQUIRED, "folder of the set", metavar="DIR")
    most_items: int | None = option(None, "only layouts of at most so many items", least=1)
    again: int | None = option(
        None, "label N cases once more, drawn at random, and compare; the set stays as it is",
        metavar="N", least=1,
    )  # fmt: skip
    least_items: int | None = option(None, "with --again: only of at least so many items", least=1)
    keep_in: Path | None = option(
        None, "label nothing; keep the rows made so far in tables of the set SET, from which this "
        "command goes on in a copy of SET", metavar="SET",
    )  # fmt: skip
    workers: int = workers_option(0)

    def __post_init__(self) -> None:
        if self.keep_in is not None and (self.again or self.most_items) is not None:
            raise UsageError("--keep-in: not allowed with --again or --most-items")
        if self.again is not None and self.most_items is not None:
            raise UsageError("--most-items: not allowed with --again; allowed: --least-items")
        if self.again is None and self.least_items is not None:
            raise UsageError("--least-items: not allowed without --again")

    def run(self) -> None:
        """Label the missing cases for both questions: validation, then test, then training."""
        from steadyload.labelling.screening import keep_again, keep_begun, label_screened

        if self.keep_in is not None:
            print(f"unlabelled cases with rows: {keep_begun(self.directory, self.keep_in)}")
            print(f"labels that were made again: {keep_again(self.directory, self.keep_in)}")
        elif self.again is not None:
            self._again(self.again)
        else:
            with resumable(self.directory), progress_bar("labelling") as advance:
                count = label_screened(
                    self.directory, most_items=self.most_items, workers=self.workers,
                    progress=advance,
                )  # fmt: skip
            print(f"{count} cases have labels of both questions -> {self.directory}")

    def _again(self, count: int) -> None:
        from steadyload.labelling.screening import label_again

        with resumable(self.directory), progress_bar("labelling again") as advance:
            found = label_again(
                self.directory, count, least_items=self.least_items or 1, workers=self.workers,
                progress=advance,
            )  # fmt: skip
        equal = len(found.cases) - len(found.differ)
        print(f"{equal} of {len(found.cases)} cases, labelled again, are equal -> {self.directory}")
        _list("differs", [f"{layout} {scenario}" for layout, scenario in found.differ])


def _list(title: str, entries: Sequence[str]) -> None:
    for entry in entries[:_SHOWN]:
        print(f"{title}: {entry}")
    if len(entries) > _SHOWN:
        print(f"{title}: {len(entries) - _SHOWN} more")
