"""Share of packers' plans that stand: the tables of docs/packers.md.

    python docs/packers.py FOLDER PLANS

FOLDER holds instances of PackingSolver (``NAME_items.csv`` with ``NAME_bins.csv``), such as its
``data/box/ivancic1989``; PLANS is where the plans are written, one file a packer.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import steadyload as sl
from steadyload.layouts.benchmark.item_lists import read_items
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.packers.packed import (
    PACKERS,
    ItemList,
    ItemType,
    Packing,
    with_packingsolver,
)
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share

UNITS = "in"
"""The instances have no unit; in inches their containers are up to 1.6 m long."""

METHODS = ("equilibrium", "ps_opt@mujoco")

PACK: dict[str, Packing] = {
    **PACKERS,
    # One pass of at most 10 s, or 60 s where that finds no plan.
    "packingsolver3d": partial(with_packingsolver, time_limits=(10.0, 60.0)),
}


def read_instance(items: Path) -> ItemList:
    """An instance: its bin, and its items with their copies. Limits on turning are left out."""
    with Path(str(items).replace("_items", "_bins")).open() as bins:
        only = next(csv.DictReader(bins))
    types = tuple(ItemType(sides, copies) for sides, copies in read_items(items))
    bin_ = int(only["X"]), int(only["Y"]), int(only["Z"])
    return ItemList(items.name.removesuffix("_items.csv"), bin_, types, UNITS)


def plans(folder: Path, packer: str) -> Iterator[sl.Layout]:
    """All loaded bins of all instances, named by instance and bin."""
    for path in sorted(folder.glob("*_items.csv")):
        items = read_instance(path)
        found = PACK[packer](items)
        if found.unplaced:
            print(f"{packer}, {items.name}: {len(found.unplaced)} unplaced", file=sys.stderr)
        for layout in found.layouts:
            yield replace(layout, name=f"{items.name} {layout.name}")


def rows(packer: str, layouts: list[sl.Layout]) -> tuple[str, str]:
    """A packer's rows: containers that stand by each method, and their scores."""
    instances = [layout.name.split()[0] for layout in layouts]
    stand: list[str] = []
    scores: list[str] = []
    for spec in METHODS:
        verdicts = sl.make_method(spec).judge_many(layouts)
        assert all(verdict.status == "done" for verdict in verdicts)
        stand.append(percent(share([verdict.stable for verdict in verdicts], instances)))
        scores.append(percent(mean([verdict.score for verdict in verdicts], instances)))
    boxes = f"{sum(map(len, layouts)) / len(layouts):.1f}"
    counts = [str(len(set(instances))), str(len(layouts)), boxes]
    first, second = (" | ".join([packer, *cells]) for cells in (counts + stand, scores))
    return f"| {first} |", f"| {second} |"


def percent(estimate: Estimate) -> str:
    """An estimate of a share in per cent, with its interval."""
    value, low, high = (100.0 * v for v in (estimate.value, estimate.low, estimate.high))
    return f"{value:.1f} [{low:.1f}, {high:.1f}]"


def main() -> None:
    """Pack, write the plans, judge them, print the rows of both tables."""
    folder, kept = map(Path, sys.argv[1:])
    kept.mkdir(parents=True, exist_ok=True)
    found = []
    for packer in PACKERS:
        file = kept / f"{packer}.json"
        if not file.exists():
            write_layouts(file, plans(folder, packer), Format.NATIVE)
        found.append(rows(packer, sl.read(file)))
    for table in zip(*found, strict=True):
        print("\n".join(table), end="\n\n")


if __name__ == "__main__":
    main()
