"""Layouts of the benchmark: labelled cases, layouts of files, and large ones for growth."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from steadyload.layouts.benchmark.dataset import Part, load_benchmark
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


@dataclass(frozen=True)
class Cases:
    """Layouts that are judged as they are, under a name."""

    name: str
    layouts: tuple[Layout, ...]


@dataclass(frozen=True)
class Source:
    """A large layout whose first items are judged, more and more of them.

    ``alone``: how many of its items stand on one pallet; the others stand beside them.
    """

    layout: Layout
    alone: int


@dataclass(frozen=True)
class Scene:
    """Where the layouts of growth come from.

    Attributes:
        name: of the scene.
        sources: of a method, and seconds after which a judgement is given up.
    """

    name: str
    sources: Callable[[Method, float], Sequence[Source]]


def labelled_cases(limit: int | None) -> Cases:
    """Validation cases of the labelled set; at most ``limit`` a scenario."""
    benchmark = load_benchmark()
    rows = benchmark.select(Part.VALIDATION, limit=limit)
    named = zip(rows["layout"], rows["scenario"], strict=True)
    return Cases(LABELLED, tuple(benchmark.layout(name, scenario) for name, scenario in named))


def cases_of(path: Path, limit: int | None) -> Cases:
    """Layouts of a file, under its name without the ending; at most ``limit``.

    Raises:
        LayoutError: the file holds something that is no valid layout, or no layout at all.
        OSError: it cannot be read.
    """
    layouts = tuple(read_layouts(path)[:limit])
    if not layouts:
        raise LayoutError("holds no layouts; allowed: one or more").located(file=str(path))
    return Cases(path.stem, layouts)


def check_names(sets: Sequence[Cases]) -> None:
    """Refuse sets of which two have one name, or one that of the generated scene.

    Raises:
        LayoutError: they have.
    """
    taken = {PILES}
    for cases in sets:
        if cases.name in taken:
            raise LayoutError(
                f"two sets of layouts are called {shown(cases.name)}; allowed: files of different "
                f"names, but {PILES} and {LABELLED}"
            )
        taken.add(cases.name)


def piles(most_items: int, draws: int) -> Scene:
    """Random boxes on a deck of 80 x 80 cm, packed from the bottom up, bases supported by 0.8."""
    packed = [
        random_boxes(
            f"pile-{seed}", most_items, _DECK, "bottom-back-left", seed=seed, support=_SUPPORT
        )
        for seed in range(_SEED, _SEED + draws)
    ]
    sources = [Source(layout, most_items) for layout in packed]
    return Scene(PILES, lambda method, patience: sources)


def growing(cases: Cases, most_items: int, draws: int) -> Scene:
    """The layouts of a set in random order, joined to large ones.

    Of every layout the first items are taken, as many as the method calls safe, ten at least. A
    source begins with one layout; the next ones stand beside it on one long deck, until there are
    ``most_items``.
    """
    order = np.random.default_rng(_SEED).permutation(len(cases.layouts)).tolist()
    layouts = [cases.layouts[place] for place in order]

    def sources(method: Method, patience: float) -> list[Source]:
        parts: list[Layout] = []
        for part in _safe_parts(method, layouts, patience):
            parts.append(part)
            if sum(map(len, parts[draws - 1 :])) >= most_items:
                break
        return [
            Source(_side_by_side(f"{cases.name}-{first}", row), len(row[0]))
            for first in range(min(draws, len(parts)))
            for row in [_enough(parts[first:], most_items)]
        ]

    return Scene(cases.name, sources)


def _safe_parts(method: Method, layouts: Sequence[Layout], patience: float) -> Iterator[Layout]:
    for layout in layouts:
        verdict = method.judge(layout, timeout=patience)
        if verdict.items_placed is not None and verdict.items_placed >= _FEWEST:
            yield layout.first(verdict.items_placed)


def _enough(parts: Sequence[Layout], items: int) -> list[Layout]:
    """The first parts, until they have so many items, or all."""
    totals = np.cumsum([len(part) for part in parts])
    return list(parts[: int(np.searchsorted(totals, items)) + 1])


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
