"""Plans of packers and their labels, as one table."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from steadyload.labelling.building.item_lists import CONTAINER, EURO_PALLET
from steadyload.layouts.benchmark.dataset import KEYS, Benchmark
from steadyload.layouts.benchmark.parts import PALLET_SOFTWARE
from steadyload.layouts.benchmark.tables import UNLABELLED
from steadyload.layouts.model.question import Question
from steadyload.statistics.placed import items_placed_by_case

PACKER_TITLES: Mapping[str, str] = {
    "packingsolver3d": "PackingSolver",
    "packvium": "Packvium",
    "packvium-support-75": "Packvium (75 % supported)",
    "py3dbp": "py3dbp",
    PALLET_SOFTWARE: "palletising software",
}
"""Source of layouts -> title, in the order of tables."""

CUSTOMERS, CONTAINERS, EURO_PALLETS, OTHERS = (
    "customers' pallets",
    "containers",
    "Euro pallets",
    "other bins",
)
KINDS = (CONTAINERS, EURO_PALLETS, OTHERS, CUSTOMERS)
"""Kinds of lists, in the order of tables."""

NARROW = 0.1
"""A box that contact patches narrower or wider by less would let fall, or hold, is within 1 mm of
its point of balance [cm]; see :mod:`steadyload.statics.margins`."""

_OF_CASES = [
    *(*KEYS, "instance", "item_count", "status", "failing_step"),
    *("margin", "corner_most", "angle_most"),
]
_OF_STANDS = {
    "status": "stands_status",
    "failing_step": "stands_step",
    "moved_item": "moved_item",
}


def plans_of(benchmark: Benchmark) -> pd.DataFrame:
    """A row a packer, layout and scenario; what two packers found is a plan of each.

    Columns: ``packer`` (title), ``layout``, ``scenario``, ``list``, ``instance``, ``kind``,
    ``items``; ``status`` of the label of ``within`` and ``stands_status`` of that of ``stands``,
    with ``labelled`` and ``settled`` for done, ``is_known`` where there is one or the plan is
    unsettled, and ``is_new`` where labelling has not come to it; ``failing_step`` and
    ``stands_step``, with ``within`` and ``stands`` for none; ``score`` by ``stands``,
    ``moved_item``, ``narrow`` for a box within 1 mm of its point of balance, and the movements
    ``corner_most`` and ``angle_most`` by step.
    """
    sources = benchmark.layouts["sources"].explode()
    sources = sources[sources.isin(list(PACKER_TITLES))].rename("source").reset_index()
    labels = benchmark.labels_on(Question.STANDS).set_index(KEYS)
    stands = labels[list(_OF_STANDS)].rename(columns=_OF_STANDS)
    found = benchmark.cases[_OF_CASES].join(stands, on=KEYS).merge(sources, on="layout")
    found["settled"] = (found["stands_status"] == "done").fillna(False).astype(bool)
    found["items"] = found["item_count"].astype(int)
    found["labelled"] = found["status"] == "done"
    found["is_known"] = found["labelled"] | found["stands_status"].isin(["done", "unsettled"])
    found["is_new"] = found["status"] == UNLABELLED
    found["within"] = found["labelled"] & found["failing_step"].isna()
    found["stands"] = found["settled"] & found["stands_step"].isna()
    found["score"] = items_placed_by_case(found["stands_step"], found["items"]) / found["items"]
    found["packer"] = found["source"].map(PACKER_TITLES)
    found["list"] = [_list_of(row) for row in found.to_dict("records")]
    bins = benchmark.layouts["pallet"]
    found["kind"] = [
        CUSTOMERS if source == PALLET_SOFTWARE else _kind(bins[layout])
        for source, layout in zip(found["source"], found["layout"], strict=True)
    ]
    found["narrow"] = [_is_narrow(row) for row in found.to_dict("records")]
    return found.drop(columns=["item_count", "margin", "source"])


def _list_of(row: Mapping[str, object]) -> str:
    """The list of a plan ``LIST PACKER NUMBER``, or the order of a customer's pallet."""
    name, instance = str(row["layout"]), str(row["instance"])
    return instance if row["source"] == PALLET_SOFTWARE else name.rsplit(" ", 2)[0]


def _kind(bin_: object) -> str:
    sides = np.asarray(bin_, dtype=float)
    if sorted(sides) == sorted(CONTAINER):
        return CONTAINERS
    return EURO_PALLETS if sorted(sides[[0, 2]]) == sorted(EURO_PALLET) else OTHERS


def _is_narrow(row: Mapping[str, object]) -> bool:
    """At the failing step, or at any where the load stands."""
    margins = row["margin"]
    if margins is None or not row["settled"]:
        return False
    known = np.asarray(margins, dtype=float)
    step = row["stands_step"]
    near = np.abs(known) < NARROW
    return bool(near.any() if pd.isna(step) else near[int(str(step))])
