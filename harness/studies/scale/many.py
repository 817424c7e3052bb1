"""Many different layouts: plans of many item lists, each with many draws of centres of mass."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np

from steadyload.atomic import write_atomically
from steadyload.layouts.files.limits import MAX_LAYOUTS
from steadyload.layouts.files.parquet_layouts import parquet_of, rows_of
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.scenarios import Scenario
from steadyload.layouts.packing.packing import drawn_layouts

GROUP = 10_000
"""Layouts of a row group."""

_SHARE, _STEP = 0.1, 0.01
"""Centres of mass lie within this share of a box's sides from its middle, on a grid [cm]."""


def write_many(folder: Path, lists: int, each: int, seed: int) -> list[Path]:
    """Write Parquet files of layouts, all of which differ, each of as many as a file may have.

    Each of the item lists is packed once; its layouts, ``each`` of them, a divisor of
    :data:`GROUP`, differ in their centres of mass.
    """
    folder.mkdir(parents=True, exist_ok=True)
    groups, files = many_layouts(lists, each, seed), []
    for number in range(-(-lists * each // MAX_LAYOUTS)):
        files.append(folder / f"layouts-{number:03d}.parquet")
        rows = map(rows_of, islice(groups, MAX_LAYOUTS // GROUP))
        write_atomically(files[-1], parquet_of(rows))
    return files


def many_layouts(lists: int, each: int, seed: int) -> Iterator[LayoutBatch]:
    """The layouts of :func:`write_many`, in the batches that are its row groups."""
    random = np.random.default_rng(np.random.SeedSequence([seed, lists, each]))
    packed = enumerate(islice(drawn_layouts(seed, scenario=Scenario.S1), lists))
    while some := list(islice(packed, GROUP // each)):
        yield LayoutBatch.joined([_varied(plan, number, each, random) for number, plan in some])


def _varied(plan: Layout, number: int, draws: int, random: np.random.Generator) -> LayoutBatch:
    items = len(plan)
    reach = np.tile(_SHARE * plan.sizes, (draws, 1))
    offsets = np.round(random.uniform(-reach, reach) / _STEP) * _STEP
    return LayoutBatch.from_arrays(
        items * np.arange(draws + 1),
        np.tile(plan.lower, (draws, 1)),
        np.tile(plan.sizes, (draws, 1)),
        np.tile(plan.weights, draws),
        offsets,
        pallets=plan.pallet,
        names=[f"{number}-{draw}" for draw in range(draws)],
    )
