"""Layouts of real size: customers' pallets, and plans of packers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from steadyload.atomic import checksum
from steadyload.labelling.building.item_lists import (
    CONTAINER,
    DENSITIES,
    EURO_PALLET,
    PALLET_RULE,
    WHOLE_CONTAINER,
    PalletRule,
    container_files,
    container_lists,
    pallet_lists,
    product_files,
)
from steadyload.layouts.benchmark.dataset import row_of
from steadyload.layouts.benchmark.parts import NO_CLASS, PALLET_SOFTWARE
from steadyload.layouts.benchmark.tables import BenchmarkError
from steadyload.layouts.files.limits import MAX_FILE_BYTES
from steadyload.layouts.formats import read_layouts
from steadyload.layouts.model.layout import Layout, Pallet
from steadyload.layouts.model.scenarios import Scenario, draw_case
from steadyload.layouts.packers.packed import (
    PACKERS,
    ItemList,
    Packing,
    packer_versions,
    with_packingsolver,
)
from steadyload.layouts.sizes import MOST_SMALL
from steadyload.progress import Progress, silent
from steadyload.reading import content_of

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
            :func:`steadyload.labelling.building.splits.split_by_instance`.
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


FURTHER = RealOptions(
    seed=2025,
    containers=21,
    pallets=12,
    fewest_items=MOST_SMALL + 1,
    most_in_all_scenarios=MOST_SMALL,
    rule=PalletRule(load_heights=(100, 130), fewest_boxes=75, most_boxes=180),
    test=0.5,
    validation=0.5,
)
"""Options of the further draw of the set of the package, see :func:`build_further`: large layouts
alone, in S1 alone."""


@dataclass(frozen=True, slots=True)
class ListInputs:
    """Folders that item lists are drawn from.

    Args:
        containers: of :func:`steadyload.labelling.building.item_lists.container_lists`.
        products: of :func:`steadyload.labelling.building.item_lists.pallet_lists`.
    """

    containers: Path
    products: Path


@dataclass(frozen=True, slots=True)
class RealInputs(ListInputs):
    """Files that a set of real size is made from.

    Args:
        containers, products: folders of item lists.
        pallets: a layout file of pallets, named ``ORDER.order-NUMBER``.
    """

    pallets: Path


@dataclass(frozen=True, slots=True)
class Before:
    """A set that is added to.

    Args:
        containers: lists for containers that it was drawn from.
        instances: names of its instances.
        geometries: of its layouts, by
            :meth:`steadyload.layouts.model.layout.Layout.geometry_hash`.
    """

    containers: int
    instances: frozenset[str]
    geometries: frozenset[str]


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
    _pack(lists, PACKERS, known, options, progress)
    return _tables(list(known.values()), options)


def build_further(
    options: RealOptions, inputs: ListInputs, before: Before, progress: Progress = silent
) -> tuple[pd.DataFrame, list[tuple[str, Layout]]]:
    """Layouts and cases that are added to a set, as those of :func:`build_real`: plans alone.

    Lists for containers follow those that the set was drawn from, and are for whole containers.
    Lists for Euro pallets share no product with those instances of the set that are among the
    files. What the set has already is left out.

    Args:
        options: what to draw.
        inputs: files to read: those that the set was made from.
        before: the set.
        progress: called with item lists packed and item lists in all.

    Raises:
        ItemListError: a folder of instances cannot be read.
        PackerNotInstalledError: a packer is missing.
        BenchmarkError: nothing has an allowed number of items.
        OSError: a file cannot be read.
    """
    packer_versions()
    lists = container_lists(
        inputs.containers, options.containers, options.seed, skip=before.containers, whole=True
    )
    lists += pallet_lists(
        inputs.products, options.pallets, options.seed, options.rule, apart_from=before.instances
    )
    known: dict[str, _Found] = {}
    _pack(lists, _PATIENT, known, options, progress)
    new = [found for geometry, found in known.items() if geometry not in before.geometries]
    return _tables(new, options)


_PATIENCE = 120.0
"""Time limit of PackingSolver for large lists [s]: it needs 3 s of CPU time, and on a busy machine
gave no plan within its usual 10 s."""

_PATIENT: Mapping[str, Packing] = {
    **PACKERS,
    "packingsolver3d": partial(with_packingsolver, time_limits=(_PATIENCE,)),
}


def _pack(
    lists: Sequence[ItemList],
    packers: Mapping[str, Packing],
    known: dict[str, _Found],
    options: RealOptions,
    progress: Progress,
) -> None:
    """Add to ``known`` a plan of every list by every packer."""
    for done, items in enumerate(lists, start=1):
        for name, packing in packers.items():
            plan = _plan(items, name, packing, options)
            if plan is not None:
                _keep(known, plan, options)
        progress(done, len(lists))


@dataclass(frozen=True, slots=True)
class _Found:
    """A layout, its item list, and the names of all that gave it."""

    layout: Layout
    instance: str
    sources: list[str]


def _plan(items: ItemList, packer: str, packing: Packing, options: RealOptions) -> _Found | None:
    """The first bin of a plan that has an allowed number of items."""
    for number, layout in enumerate(packing(items).layouts, start=1):
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
    return {
        "origin": "real",
        **asdict(options),
        "sources": {"pallets": _source("pallets", [inputs.pallets]), **list_sources(inputs)},
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


def further_manifest(
    options: RealOptions, inputs: ListInputs, before: Before, layouts: pd.DataFrame
) -> dict[str, Any]:
    """The entry of a further draw, see :func:`build_further`.

    Raises:
        PackerNotInstalledError: a packer is missing.
    """
    return {
        **asdict(options),
        "lists_for_containers_left_out": before.containers,
        "container": list(WHOLE_CONTAINER),
        "sources": list_sources(inputs),
        "packers": {
            "names": list(_PATIENT),
            "versions": packer_versions(),
            "seconds_of_packingsolver3d": _PATIENCE,
        },
        "layouts": len(layouts),
        "instances": sorted(layouts["instance"].unique().tolist()),
    }


def list_sources(inputs: ListInputs) -> dict[str, Mapping[str, str]]:
    """Entries of the manifest about the folders of item lists: whose, and the checksums."""
    return {
        "containers": _source("containers", list(container_files(inputs.containers).values())),
        "products": _source("products", product_files(inputs.products)),
    }


def _source(name: str, paths: list[Path]) -> Mapping[str, str]:
    """The entry of :data:`SOURCES`; of other files than those their checksum alone."""
    sums = {each.name: checksum(content_of(each, MAX_FILE_BYTES)) for each in sorted(paths)}
    parts = [f"{name} {found}\n" for name, found in sums.items()]
    found = checksum("".join(parts).encode())
    known = SOURCES[name]
    return known if known["files"] == found else {"title": "other files", "files": found}
