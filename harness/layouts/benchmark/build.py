"""Which layouts are labelled: instances packed with every heuristic, each geometry once."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from harness.layouts.benchmark.dataset import row_of
from harness.layouts.model import Layout
from harness.layouts.packing import ITEM_CLASSES, WeightRule, generate, make_instance
from harness.layouts.scenarios import Scenario, apply_scenario

_OFFSET_DECIMALS = 2
"""Centres of mass lie on tenths of a millimetre: what is stored is what is judged."""


@dataclass(frozen=True, slots=True)
class BuildOptions:
    """What a labelled set is drawn from.

    Args:
        seed: root of all random draws, 0 or more.
        instances: item lists of every class.
        item_counts: items of an instance by class, where they are not the class's own. Class 3
            has 32 instead of 64: splits and intervals stand on item lists, and this gives more.
        weights: how heavy items are.
    """

    seed: int = 2024
    instances: int = 17
    item_counts: Mapping[int, int] = field(default_factory=lambda: {3: 32})
    weights: WeightRule = WeightRule.PAPER


def build(
    options: BuildOptions, progress: Callable[[int, int], None] = lambda done, total: None
) -> tuple[pd.DataFrame, list[tuple[str, Layout]]]:
    """The table of layouts, and all cases as (scenario, layout), layouts in the table's order.

    A geometry that two instances share belongs to the first.

    Args:
        options: what to draw from.
        progress: called with instances packed and instances in all.

    Raises:
        PackingError: an option that cannot be.
    """
    instances = [
        make_instance(number, which, seed=options.seed, item_count=options.item_counts.get(number))
        for which in range(options.instances)
        for number in ITEM_CLASSES
    ]
    rows, cases, known = [], [], set()
    for done, instance in enumerate(instances, start=1):
        for packed in generate([instance], weights=options.weights):
            geometry = packed.layout.geometry_hash()
            if geometry in known:
                continue
            known.add(geometry)
            name = f"Class_{instance.class_number}_Instance_{instance.number}"
            rows.append(row_of(packed.layout, name, instance.class_number, packed.sources))
            cases += [(str(s), draw_case(packed.layout, s, options.seed)) for s in Scenario]
        progress(done, len(instances))
    return pd.DataFrame(rows), cases


def draw_case(layout: Layout, scenario: Scenario, seed: int) -> Layout:
    """A layout in a scenario, its centres of mass rounded as they are stored."""
    drawn = apply_scenario(layout, scenario, seed)
    return drawn.with_mass_offsets(np.round(drawn.mass_offsets, _OFFSET_DECIMALS) + 0.0)
