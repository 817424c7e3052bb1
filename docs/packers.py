"""Share of packers' plans that stand: the tables of docs/packers.md.

    python docs/packers.py FOLDER PLANS

FOLDER holds instances of PackingSolver (``NAME_items.csv`` with ``NAME_bins.csv``), such as its
``data/box/ivancic1989``; PLANS is where the plans are written, one file a packer.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import packingsolver3d as ps
import packvium as pv
import py3dbp

import steadyload as sl
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.packers.plan import Plan
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share

UNITS = "in"
"""The instances have no unit; in inches their containers are up to 1.6 m long."""

METHODS = ("equilibrium", "ps_opt@mujoco")
Sides = tuple[int, int, int]


def read_instance(items: Path) -> tuple[Sides, list[tuple[Sides, int]]]:
    """The bin of an instance, and its items with their copies. Limits on turning are left out."""
    with items.open() as file, Path(str(items).replace("_items", "_bins")).open() as bins:
        only = next(csv.DictReader(bins))
        rows = list(csv.DictReader(file))
    return _sides(only), [(_sides(row), int(row["COPIES"])) for row in rows]


def _sides(row: dict[str, str]) -> Sides:
    return int(row["X"]), int(row["Y"]), int(row["Z"])


def with_packingsolver(bin_: Sides, items: list[tuple[Sides, int]]) -> Plan:
    """The plan of PackingSolver: one pass of at most 10 s, or 60 s where that finds none."""
    kinds = [ps.ItemType(*sides, copies=n, rotations=ps.ALL_ROTATIONS) for sides, n in items]
    instance = ps.Instance(
        bin_types=[ps.BinType(*bin_, copies=sum(n for _, n in items))],
        item_types=kinds,
        objective=ps.Objective.BIN_PACKING,
    )
    one_pass = ps.OptimizationMode.NOT_ANYTIME_SEQUENTIAL
    for limit in (10.0, 60.0):
        result = ps.box.solve(instance, time_limit=limit, optimization_mode=one_pass)
        if result.bins:
            break
    return sl.from_packingsolver(result, instance=instance, units=UNITS)


def with_packvium(support: float) -> Callable[[Sides, list[tuple[Sides, int]]], Plan]:
    """The plan of Packvium, with at least this share of each base supported."""
    config = pv.PackingConfig.balanced(
        minimum_support_ratio=support,
        time_limit_ms=60_000,
        effort_budget=pv.EffortBudget(max_candidates_evaluated=20_000),
    )

    def packed(bin_: Sides, items: list[tuple[Sides, int]]) -> Plan:
        boxes = [
            pv.Item.create(f"type {k}", pv.Dimensions.inches(*map(str, sides)), quantity=n)
            for k, (sides, n) in enumerate(items)
        ]
        container = pv.Container.create("bin", pv.Dimensions.inches(*map(str, bin_)))
        return sl.from_packvium(pv.Packer(config).pack(boxes, [container]))

    return packed


def with_py3dbp(bin_: Sides, items: list[tuple[Sides, int]]) -> Plan:
    """The plan of py3dbp, largest boxes first."""
    packer = py3dbp.Packer()
    length, width, height = bin_
    for number in range(sum(n for _, n in items)):
        packer.add_bin(py3dbp.Bin(f"bin {number}", width, height, length, 1_000_000))
    for kind, ((x, y, z), copies) in enumerate(items):
        for _ in range(copies):
            packer.add_item(py3dbp.Item(f"type {kind}", y, z, x, 0))
    packer.pack(bigger_first=True, distribute_items=True)
    return sl.from_py3dbp(packer, units=UNITS)


PACKERS: dict[str, Callable[[Sides, list[tuple[Sides, int]]], Plan]] = {
    "packingsolver3d": with_packingsolver,
    "packvium": with_packvium(0.0),
    "packvium-support-75": with_packvium(0.75),
    "py3dbp": with_py3dbp,
}


def plans(folder: Path, packer: str) -> Iterator[sl.Layout]:
    """All loaded bins of all instances, named by instance and bin."""
    for path in sorted(folder.glob("*_items.csv")):
        found = PACKERS[packer](*read_instance(path))
        instance = path.name.removesuffix("_items.csv")
        if found.unplaced:
            print(f"{packer}, {instance}: {len(found.unplaced)} unplaced", file=sys.stderr)
        for layout in found.layouts:
            yield replace(layout, name=f"{instance} {layout.name}")


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
