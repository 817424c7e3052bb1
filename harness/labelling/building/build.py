"""Layouts of a labelled set: instances packed with every heuristic, each geometry once."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from steadyload.labelling.building.splits import SIZES, SplitSizes
from steadyload.layouts.benchmark.dataset import row_of
from steadyload.layouts.benchmark.parts import LABELLED_ITEM_COUNTS
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.scenarios import Scenario, draw_case
from steadyload.layouts.packing.packing import (
    ITEM_CLASSES,
    PackedLayout,
    WeightRule,
    generate,
    make_instance,
)
from steadyload.progress import Progress, silent

_INSTANCES = 17
"""Item lists of every class of the large set."""


@dataclass(frozen=True, slots=True)
class BuildOptions:
    """Options of building a labelled set.

    Args:
        seed: root of all random draws, 0 or more.
        instances: item lists of every class.
        first_instance: number of the first of them; lists of another number are other lists.
        most_layouts: layouts of an item list, drawn at random where there are more; None for all.
        item_counts: items of an instance by class, where they are not the class's own.
        weights: how heavy items are.
        planar: every layout is a planar scene in every scenario; see
            :class:`steadyload.layouts.packing.packing.Instance` and
            :func:`steadyload.layouts.model.scenarios.apply_scenario`.
        fewest_items: layouts of fewer are left out, 1 or more.
        splits: what is held out once the set is labelled.
    """

    seed: int = 2024
    instances: int = _INSTANCES
    first_instance: int = 0
    most_layouts: int | None = None
    item_counts: Mapping[int, int] = field(default_factory=lambda: dict(LABELLED_ITEM_COUNTS))
    weights: WeightRule = WeightRule.PAPER
    planar: bool = False
    fewest_items: int = 1
    splits: SplitSizes = SIZES


PLANAR_OPTIONS = BuildOptions(
    instances=10,
    # Side by side a bin holds far fewer items than in space: these fill one, seldom two or three.
    item_counts={1: 24, 2: 30, 3: 8},
    planar=True,
    # Bins of class 3 often hold one or two items, on which methods differ little.
    fewest_items=3,
    splits=SplitSizes(test=300, validation=300, test_lists=4, validation_lists=4),
)
"""Options of the planar set that comes with the package."""


LISTS_OPTIONS = BuildOptions(
    instances=30,
    first_instance=_INSTANCES,
    most_layouts=30,
    splits=SplitSizes(most_of_list=40),
)
"""Options of the set of many item lists that comes with the package: for tests alone, from lists
that follow those of the large set, so that intervals stand on 90 lists instead of 15."""


CHOOSING_OPTIONS = BuildOptions(
    instances=20,
    first_instance=_INSTANCES + LISTS_OPTIONS.instances,
    most_layouts=12,
    splits=SplitSizes(most_of_list=72, parts=("search", "fitting")),
)
"""Options of the set that parameters are searched and cascades are fitted on: lists that follow
those of the set of many lists, half of them for either."""


def build(
    options: BuildOptions,
    progress: Progress = silent,
    *,
    apart_from: Collection[str] = (),
) -> tuple[pd.DataFrame, list[tuple[str, Layout]]]:
    """The table of layouts, and all cases as (scenario, layout), layouts in the table's order.

    A geometry that two instances share belongs to the first.

    Args:
        options: what to draw from.
        progress: called with instances packed and instances in all.
        apart_from: geometries that are left out, by
            :meth:`steadyload.layouts.model.layout.Layout.geometry_hash`.

    Raises:
        PackingError: an option that cannot be.
    """
    instances = [
        make_instance(
            number,
            which,
            seed=options.seed,
            item_count=options.item_counts.get(number),
            planar=options.planar,
        )
        for which in range(options.first_instance, options.first_instance + options.instances)
        for number in ITEM_CLASSES
    ]
    rows, cases, known = [], [], set(apart_from)
    for done, instance in enumerate(instances, start=1):
        new = []
        for packed in generate([instance], weights=options.weights):
            geometry = packed.layout.geometry_hash()
            if geometry in known or len(packed.layout) < options.fewest_items:
                continue
            known.add(geometry)
            new.append(packed)
        for packed in _drawn(new, options, done):
            rows.append(row_of(packed.layout, instance.name, instance.class_number, packed.sources))
            cases += [
                (str(s), draw_case(packed.layout, s, options.seed, planar=options.planar))
                for s in Scenario
            ]
        progress(done, len(instances))
    return pd.DataFrame(rows), cases


def _drawn(
    packed: Sequence[PackedLayout], options: BuildOptions, place: int
) -> Sequence[PackedLayout]:
    """The layouts of an item list that take part, in their order."""
    if options.most_layouts is None or len(packed) <= options.most_layouts:
        return packed
    sequence = np.random.SeedSequence(options.seed, spawn_key=(4, options.first_instance, place))
    chosen = np.random.default_rng(sequence).permutation(len(packed))[: options.most_layouts]
    return [packed[k] for k in sorted(chosen)]
