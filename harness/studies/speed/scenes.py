"""Layouts of the benchmark: labelled cases, layouts of files, and large ones for growth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from steadyload.layouts.benchmark.dataset import load_benchmark
from steadyload.layouts.benchmark.parts import Part
from steadyload.layouts.files.record import shown
from steadyload.layouts.formats import read_layouts
from steadyload.layouts.model.layout import Item, Layout, LayoutError, Pallet
from steadyload.layouts.packing.packing import random_boxes
from steadyload.methods.contract.method import Method

LABELLED = str(Part.VALIDATION)
"""Name of the labelled cases."""

PILES = "piles"
"""Name of the generated scene of growth."""

_DECK = Pallet(80.0, 400.0, 80.0)
_SUPPORT = 0.8
_APART = 20.0
"""Distance between pallets that are joined [cm]."""

_FEWEST = 10
"""Items of a pallet that is joined to others, at least."""

_SEED = 3


class Extent(NamedTuple):
    """How much is measured.

    ``draws``: layouts of a size in the growth. ``patience``: seconds after which a judgement is
    given up. ``limit``: cases a scenario, and layouts of a file; None for all.
    """

    repeats: int = 9
    draws: int = 8
    most_items: int = 200
    patience: float = 2.0
    limit: int | None = None


FULL = Extent()
QUICK = Extent(repeats=3, draws=2, most_items=50, patience=0.5)


class Source(NamedTuple):
    """A large layout whose first items are judged, more and more of them.

    ``alone``: how many of its items stand on one pallet; the others stand beside them.
    """

    layout: Layout
    alone: int


def case_sets(files: Sequence[Path], limit: int | None) -> dict[str, list[Layout]]:
    """Layouts that are judged as they are, by the name of their set.

    The first set has the validation cases of the labelled set; each other one has the layouts of a
    file, and its name without the ending.

    Raises:
        LayoutError: a file holds something that is no valid layout, or no layout at all, or has
            the name of another set.
    """
    benchmark = load_benchmark()
    rows = benchmark.select(Part.VALIDATION, limit=limit)
    named = zip(rows["layout"], rows["scenario"], strict=True)
    sets = {LABELLED: [benchmark.layout(name, scenario) for name, scenario in named]}
    for file in files:
        if file.stem in (PILES, *sets):
            raise LayoutError(
                f"two sets of layouts are called {shown(file.stem)}; allowed: files of different "
                f"names, but {PILES} and {LABELLED}"
            )
        sets[file.stem] = read_layouts(file)[:limit]
        if not sets[file.stem]:
            raise LayoutError("holds no layouts; allowed: one or more").located(file=str(file))
    return sets


def piles(extent: Extent) -> list[Source]:
    """Random boxes on a deck of 80 x 80 cm, packed from the bottom up, bases supported by 0.8."""
    packed = [
        random_boxes(
            f"pile-{seed}", extent.most_items, _DECK, "bottom-back-left", seed=seed,
            support=_SUPPORT,
        )
        for seed in range(_SEED, _SEED + extent.draws)
    ]  # fmt: skip
    return [Source(layout, extent.most_items) for layout in packed]


def joined(name: str, layouts: Sequence[Layout], extent: Extent, method: Method) -> list[Source]:
    """Layouts of a set in random order, joined to large ones.

    Of every layout the first items are taken, as many as the method calls safe, ten at least. A
    source begins with one layout; the next ones stand beside it on one long deck, until there are
    as many items as the extent has.
    """
    parts: list[Layout] = []
    for place in np.random.default_rng(_SEED).permutation(len(layouts)).tolist():
        safe = method.judge(layouts[place], timeout=extent.patience).items_placed
        if safe is not None and safe >= _FEWEST:
            parts.append(layouts[place].first(safe))
            if sum(map(len, parts[extent.draws - 1 :])) >= extent.most_items:
                break
    sources = []
    for first in range(min(extent.draws, len(parts))):
        totals = np.cumsum([len(part) for part in parts[first:]])
        row = parts[first : first + int(np.searchsorted(totals, extent.most_items)) + 1]
        sources.append(Source(_side_by_side(f"{name}-{first}", row), len(row[0])))
    return sources


def _side_by_side(name: str, layouts: Sequence[Layout]) -> Layout:
    """One layout of several, one pallet after the other along the depth."""
    items: list[Item] = []
    depth = 0.0
    for layout in layouts:
        for item in layout.items:
            x, y, z = item.position
            items.append(replace(item, sequence=len(items), position=(x, y, z + depth)))
        depth += layout.pallet.depth + _APART
    pallets = [layout.pallet for layout in layouts]
    width, height = max(p.width for p in pallets), max(p.height for p in pallets)
    deck = replace(pallets[0], width=width, height=height, depth=depth - _APART)
    return Layout(name, deck, tuple(items))
