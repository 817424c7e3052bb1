"""``steadyload benchmark``: the labelled set, what it holds and how to get it in and out."""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from steadyload.cli.terminal import at_least, print_table, progress_bar, resumable
from steadyload.layouts.benchmark import Part, load_benchmark
from steadyload.layouts.benchmark.build import PLANAR_OPTIONS, BuildOptions
from steadyload.layouts.benchmark.dataset import SETS
from steadyload.layouts.benchmark.observations import RotationUnit
from steadyload.layouts.benchmark.splits import SIZES, SplitSizes
from steadyload.layouts.benchmark.tables import read_tables
from steadyload.layouts.formats import Format
from steadyload.layouts.packing import WeightRule
from steadyload.layouts.scenarios import Scenario

WORK = Path("runs/benchmark")
"""Where a new set is made."""

_AT_WORK = f"folder of the new set (default: {WORK})"

_SHOWN = 10
"""Files of a kind that are named after an import; all of them are counted."""


def add_benchmark(commands: Any) -> None:
    """Add the command and its actions to the parser's commands."""
    benchmark = commands.add_parser("benchmark", help="the labelled set: look, export, import")
    actions = benchmark.add_subparsers(required=True, metavar="ACTION")
    for add in (_add_info, _add_page, _add_export, _add_import, _add_build, _add_label):
        add(actions)


def _add_directory(action: argparse.ArgumentParser) -> None:
    action.add_argument(
        "directory", nargs="?", type=_labelled_set, metavar="DIR",
        help=f"folder of a labelled set, or {' or '.join(SETS)} for that of the package "
        "(default: its large one)",
    )  # fmt: skip


def _labelled_set(text: str) -> Path | str:
    """A word of the package's sets, or a folder."""
    return text if text in SETS else Path(text)


def _add_info(actions: Any) -> None:
    info = actions.add_parser("info", help="count layouts, labels, splits and opinions")
    _add_directory(info)
    info.add_argument("--json", action="store_true", help="print one JSON object")
    info.set_defaults(run=_info)


def _add_export(actions: Any) -> None:
    export = actions.add_parser("export", help="write cases as a layout file, labels beside it")
    _add_directory(export)
    export.add_argument(
        "--part", choices=[str(part) for part in Part], default=str(Part.ALL),
        help="default: all labelled cases",
    )  # fmt: skip
    export.add_argument(
        "--scenario", action="append", choices=[str(scenario) for scenario in Scenario],
        help="only this; may be repeated",
    )  # fmt: skip
    export.add_argument(
        "--limit", type=at_least(1), metavar="N", help="only the first N of every scenario"
    )
    export.add_argument(
        "--to", choices=[str(kind) for kind in (Format.NATIVE, Format.CSV, Format.JOB)],
        help="format of the output (default: csv for *.csv, else native)",
    )  # fmt: skip
    export.add_argument("--output", "-o", required=True, type=Path, metavar="FILE")
    export.set_defaults(run=_export)


def _add_import(actions: Any) -> None:
    read = actions.add_parser("import", help="bring the authors' published set into our form")
    read.add_argument(
        "directory", type=Path, metavar="DIR", help="their folder Data, or one Data_1 or Data_2"
    )
    read.add_argument("--output", "-o", required=True, type=Path, metavar="OUT")
    read.add_argument(
        "--rotation-unit", choices=[str(u) for u in RotationUnit],
        default=str(RotationUnit.DEGREES), help="of raw observations (default: degrees)",
    )  # fmt: skip
    read.add_argument(
        "--split-seed", type=at_least(0), metavar="N",
        help="draw training, validation and test by item list (default: no splits)",
    )  # fmt: skip
    _add_sizes(read, SIZES)
    read.set_defaults(run=_import)


def _add_build(actions: Any) -> None:
    standard = BuildOptions()
    build = actions.add_parser("build", help="pack the layouts of a new set, not labelled yet")
    build.add_argument("--output", "-o", type=Path, metavar="DIR", default=WORK, help=_AT_WORK)
    build.add_argument(
        "--seed", type=at_least(0), default=standard.seed, help=f"default: {standard.seed}"
    )
    build.add_argument(
        "--instances", type=at_least(1), metavar="N",
        help=f"item lists of every class (default: {standard.instances}, "
        f"planar {PLANAR_OPTIONS.instances})",
    )  # fmt: skip
    build.add_argument(
        "--weights", choices=[str(rule) for rule in WeightRule], default=str(standard.weights),
        help=f"default: {standard.weights}",
    )  # fmt: skip
    build.add_argument(
        "--planar", action="store_true",
        help="items span the full depth: a small set that a 2-D engine can judge",
    )  # fmt: skip
    build.set_defaults(run=_build)


def _add_label(actions: Any) -> None:
    label = actions.add_parser(
        "label", help="label a set, split it, ask further judges; goes on where it was interrupted"
    )
    label.add_argument(
        "directory", nargs="?", type=Path, metavar="DIR", default=WORK, help=_AT_WORK
    )
    _add_sizes(label)
    label.add_argument(
        "--judges", choices=["all", "few", "none"], default="all",
        help="further judges of validation and test; `robust` says less with few (default: all)",
    )  # fmt: skip
    label.add_argument("--workers", "-j", type=at_least(1), default=os.cpu_count() or 1)
    label.set_defaults(run=_label)


def _add_sizes(action: argparse.ArgumentParser, sizes: SplitSizes | None = None) -> None:
    """Ask for sizes of splits; without standard ones, those of the set at hand are meant."""
    for name in ("test", "validation"):
        standard = getattr(sizes, name, None)
        default = "as built or labelled last" if standard is None else standard
        action.add_argument(
            f"--{name}", type=at_least(2), metavar="N", default=standard,
            help=f"cases a scenario in the {name} split, an even number (default: {default})",
        )  # fmt: skip


def _add_page(actions: Any) -> None:
    page = actions.add_parser("page", help="write the page of a set")
    _add_directory(page)
    page.add_argument(
        "--output", "-o", type=Path, metavar="DIR", default=Path("runs/benchmark-page")
    )
    page.set_defaults(run=_page)


def _info(options: argparse.Namespace) -> None:
    from steadyload.layouts.benchmark.overview import overview

    found = overview(load_benchmark(options.directory))
    if options.json:
        print(json.dumps(found, indent=1))
        return
    print(
        f"{found['layouts']} layouts of {found['instances']} instances, {found['cases']} cases; "
        f"origin: {found['origin'] or 'not stated'}"
    )
    print("status: " + ", ".join(f"{count} {name}" for name, count in found["status"].items()))
    shares = (f"{s} {100 * share:.1f} %" for s, share in found["natural_stable"].items())
    print("naturally stable: " + (", ".join(shares) or "nothing is labelled"))
    header = ("split", "scenario", "cases", "stable", "unstable", "layouts", "instances")
    _section(
        (*header, "items, mean"),
        [(*(str(row[k]) for k in header), f"{row['items_mean']:.1f}") for row in found["splits"]],
    )
    sure = found["confidence"]
    if sure["cases"]:
        print(
            f"\nconfidence: {sure['cases']} labels judged again, {sure['robust']} robust, "
            f"{sure['fragile']} fragile; mean {100 * sure['mean']:.1f} %"
        )
    _section(
        ["judge", "reason", "cases", "agrees %"],
        [
            [row["judge"], row["reason"], str(row["cases"]), f"{100 * row['agreement']:.1f}"]
            for row in found["judges"]
        ],
    )


def _section(header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    if rows:
        print()
        print_table(header, rows)


def _build(options: argparse.Namespace) -> None:
    from steadyload.studies.benchmark.labelling import build_set

    standard = PLANAR_OPTIONS if options.planar else BuildOptions()
    chosen = replace(
        standard,
        seed=options.seed,
        instances=options.instances or standard.instances,
        weights=WeightRule(options.weights),
    )
    with progress_bar("packing") as advance:
        count = build_set(chosen, options.output, advance)
    print(f"{count} cases -> {options.output}; next: steadyload benchmark label {options.output}")


def _label(options: argparse.Namespace) -> None:
    from steadyload.studies.benchmark.labelling import PANELS, label_set, split_sizes

    wanted = {"test": options.test, "validation": options.validation}
    given = {name: size for name, size in wanted.items() if size is not None}
    sizes = replace(split_sizes(read_tables(options.directory)[3]), **given)
    with resumable(options.directory), progress_bar("labelling") as advance:
        label_set(
            options.directory,
            sizes=sizes,
            judges=PANELS[options.judges],
            workers=options.workers,
            progress=lambda _, done, total: advance(done, total),
        )
    print(f"labels and opinions -> {options.directory}")


def _page(options: argparse.Namespace) -> None:
    from steadyload.reports.page import write_page
    from steadyload.studies.benchmark.page import benchmark_page
    from steadyload.studies.benchmark.summary import made_with, summarise

    found = load_benchmark(options.directory)
    page = benchmark_page(summarise(found), made_with(found), found.notes)
    print(write_page(page, options.output))


def _export(options: argparse.Namespace) -> None:
    from steadyload.layouts.benchmark.export import export, labels_path

    by_name = Format.CSV if options.output.suffix.lower() == ".csv" else Format.NATIVE
    count = export(
        load_benchmark(options.directory),
        options.output,
        Format(options.to) if options.to else by_name,
        part=options.part,
        scenarios=tuple(options.scenario or ()),
        limit=options.limit,
    )
    print(f"{count} cases -> {options.output}; labels -> {labels_path(options.output)}")


def _import(options: argparse.Namespace) -> None:
    from steadyload.layouts.benchmark.authors import import_authors

    with progress_bar("reading") as advance:
        found = import_authors(
            options.directory,
            options.output,
            rotation_unit=RotationUnit(options.rotation_unit),
            split_seed=options.split_seed,
            sizes=SplitSizes(options.test, options.validation),
            progress=advance,
        )
    print(
        f"{found.layouts} layouts, {found.cases} cases ({found.labelled} labelled, "
        f"{found.unlabelled} not) -> {options.output}"
    )
    print(f"{found.checked} labels held against what moved, {len(found.mismatches)} differ")
    _list("differs from what moved", found.mismatches)
    _list("repeats a case with another score", found.conflicts)
    _list("refused", [f"{place}: {reason}" for place, reason in found.refused])
    _list("doubtful", found.doubts)


def _list(title: str, entries: Sequence[str]) -> None:
    for entry in entries[:_SHOWN]:
        print(f"{title}: {entry}")
    if len(entries) > _SHOWN:
        print(f"{title}: {len(entries) - _SHOWN} more")
