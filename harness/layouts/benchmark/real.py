"""Layouts of real size: customers' pallets, and plans of packers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from steadyload.atomic import checksum
from steadyload.layouts.benchmark.build import draw_case
from steadyload.layouts.benchmark.dataset import row_of
from steadyload.layouts.benchmark.item_lists import (
    CONTAINER,
    DENSITIES,
    EURO_PALLET,
    PALLET_RULE,
    PalletRule,
    container_files,
    container_lists,
    pallet_lists,
    product_files,
)
from steadyload.layouts.benchmark.tables import BenchmarkError
from steadyload.layouts.files.limits import MAX_FILE_BYTES
from steadyload.layouts.formats import read_layouts
from steadyload.layouts.model.layout import Layout, Pallet
from steadyload.layouts.model.scenarios import Scenario
from steadyload.layouts.packers.packed import PACKERS, ItemList, packer_versions
from steadyload.progress import Progress, silent
from steadyload.reading import content_of

NO_CLASS = 0
"""Item class of layouts that are of none of the paper's."""

PALLET_SOFTWARE = "palletising software"
"""Source of the customers' pallets."""

_ORDER = ".order-"
"""Parts the name of a customer's pallet: before it stands the order."""

SOURCES: Mapping[str, Mapping[str, str]] = {
    "pallets": {
        "files": "62b0b81090827879",
        "title": "pallets of customers' orders, example data of pallet-sim 0.0.22 (PyPI)",
        "author": "Rodolfo Verde (THWS)",
        "licence": "MIT",
    },
    "containers": {
        "files": "88e4227a8f995a42",
        "title": "instances of Bischoff and Ratcliff (1995) as in fontanf/packingsolver, "
        "data/box/bischoff1995",
        "author": "Florian Fontan",
        "licence": "MIT",
        "commit": "f1ec896494d8e899a242d2b6a57b2761527064bb",
    },
    "products": {
        "files": "1425dc6f7edd9d19",
        "title": "instances of Alonso et al. (2019), products of ORTEC, as in JeroenGar/datasets "
        "(ESICUP), 3d_rectangular/alonso_2019",
        "author": "ESICUP",
        "licence": "CC0-1.0",
        "commit": "066edc5a3853582696d54d36aee380bb9496c7a6",
    },
}
"""Files that the set of the package is made from, by the argument that names them. ``files`` is the
checksum of all of them: of a folder, those of its instances."""


@dataclass(frozen=True, slots=True)
class RealOptions:
    """Options of building a set of real size.

    Args:
        seed: root of all random draws, 0 or more.
        containers: item lists for containers, 0 or more.
        pallets: item lists for Euro pallets, 0 or more.
        fewest_items, most_items: other layouts are left out.
        most_in_all_scenarios: larger layouts are cases in S1 alone.
        rule: how lists for Euro pallets are drawn.
        test: share of the instances that is held out, see
            :func:`steadyload.layouts.benchmark.splits.split_by_instance`.
        validation: likewise.
    """

    seed: int = 2024
    containers: int = 28
    pallets: int = 28
    fewest_items: int = 25
    most_items: int = 150
    most_in_all_scenarios: int = 75
    rule: PalletRule = PALLET_RULE
    test: float = 0.45
    validation: float = 0.2


@dataclass(frozen=True, slots=True)
class RealInputs:
    """Files that a set of real size is made from.

    Args:
        pallets: a layout file of pallets, named ``ORDER.order-NUMBER``.
        containers: folder of :func:`steadyload.layouts.benchmark.item_lists.container_lists`.
        products: folder of :func:`steadyload.layouts.benchmark.item_lists.pallet_lists`.
    """

    pallets: Path
    containers: Path
    products: Path


def build_real(
    options: RealOptions,
    inputs: RealInputs,
    progress: Progress = silent,
) -> tuple[pd.DataFrame, list[tuple[str, Layout]]]:
    """The table of layouts, and all cases as (scenario, layout), layouts in the table's order.

    Of the plan of a list by a packer the first bin with an allowed number of items is kept. Pallets
    stand on the floor that their file says, and keep its loading order.

    Args:
        options: what to draw.
        inputs: files to read.
        progress: called with item lists packed and item lists in all.

    Raises:
        ItemListError: a folder of instances cannot be read.
        LayoutError: the file of pallets cannot be read.
        PackerNotInstalledError: a packer is missing.
        BenchmarkError: nothing has an allowed number of items, or names are there twice.
        OSError: a file cannot be read.
    """
    packer_versions()
    lists = container_lists(inputs.containers, options.containers, options.seed)
    lists += pallet_lists(inputs.products, options.pallets, options.seed, options.rule)
    known: dict[str, _Found] = {}
    for layout in read_layouts(inputs.pallets):
        instance = layout.name.partition(_ORDER)[0]
        _keep(known, _Found(layout, instance, [PALLET_SOFTWARE]), options)
    for done, items in enumerate(lists, start=1):
        for packer in PACKERS:
            plan = _plan(items, packer, options)
            if plan is not None:
                _keep(known, plan, options)
        progress(done, len(lists))
    return _tables(list(known.values()), options)


@dataclass(frozen=True, slots=True)
class _Found:
    """A layout, its item list, and the names of all that gave it."""

    layout: Layout
    instance: str
    sources: list[str]


def _plan(items: ItemList, packer: str, options: RealOptions) -> _Found | None:
    """The first bin of a plan that has an allowed number of items."""
    for number, layout in enumerate(PACKERS[packer](items).layouts, start=1):
        if _allowed(layout, options):
            name = f"{items.name} {packer} {number}"
            return _Found(layout.renamed(name), items.origin or items.name, [packer])
    return None


def _allowed(layout: Layout, options: RealOptions) -> bool:
    return options.fewest_items <= len(layout) <= options.most_items


def _keep(known: dict[str, _Found], found: _Found, options: RealOptions) -> None:
    """Add a layout; a geometry that is there already belongs to the first, with all sources."""
    if not _allowed(found.layout, options):
        return
    first = known.setdefault(found.layout.geometry_hash(), found)
    first.sources.extend(name for name in found.sources if name not in first.sources)


def _tables(
    found: list[_Found], options: RealOptions
) -> tuple[pd.DataFrame, list[tuple[str, Layout]]]:
    if not found:
        raise BenchmarkError(
            f"nothing has {options.fewest_items} to {options.most_items} items; allowed: pallets "
            "or item lists that give some"
        )
    names: set[str] = set()
    cases = []
    for each in found:
        if each.layout.name in names:
            raise BenchmarkError(f"layout {each.layout.name!a} is there twice; allowed: once")
        names.add(each.layout.name)
        if each.layout.pallet != Pallet(*each.layout.pallet.size):
            raise BenchmarkError(
                f"layout {each.layout.name!a} states more than its pallet's sides; allowed: the "
                "usual overhang, deck and floor, since a set stores the sides alone"
            )
        large = len(each.layout) > options.most_in_all_scenarios
        cases += [
            (str(s), draw_case(each.layout, s, options.seed))
            for s in ([Scenario.S1] if large else Scenario)
        ]
    rows = [row_of(e.layout, e.instance, NO_CLASS, tuple(e.sources)) for e in found]
    return pd.DataFrame(rows), cases


def real_manifest(options: RealOptions, inputs: RealInputs) -> dict[str, Any]:
    """Entries of the manifest of such a set: what it is made from, and by which rules.

    Raises:
        PackerNotInstalledError: a packer is missing.
    """
    files = {
        "pallets": [inputs.pallets],
        "containers": list(container_files(inputs.containers).values()),
        "products": product_files(inputs.products),
    }
    return {
        "origin": "real",
        **asdict(options),
        "sources": {name: _source(name, paths) for name, paths in files.items()},
        "packers": {"names": list(PACKERS), "versions": packer_versions()},
        "loading_order": "pallets: that of the file; plans: height of the base, then from the back "
        "to the front, then from left to right",
        "turning": "boxes of plans may be turned in any way",
        "densities": f"container: log-uniform by item type, {DENSITIES[0]:g} to {DENSITIES[1]:g} "
        "kg/m3; products and pallets: their own weights",
        "container": list(CONTAINER),
        "euro_pallet": list(EURO_PALLET),
        "floor": "auto: the deck where an item overhangs it, the infinite plane where none does",
    }


def _source(name: str, paths: list[Path]) -> Mapping[str, str]:
    """The entry of :data:`SOURCES`; of other files than those their checksum alone."""
    sums = {each.name: checksum(content_of(each, MAX_FILE_BYTES)) for each in sorted(paths)}
    parts = [f"{name} {found}\n" for name, found in sums.items()]
    found = checksum("".join(parts).encode())
    known = SOURCES[name]
    return known if known["files"] == found else {"title": "other files", "files": found}
