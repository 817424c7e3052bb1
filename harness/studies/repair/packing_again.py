"""The boxes of a plan, packed into the same bin again by a packer that requires support."""

from __future__ import annotations

from dataclasses import replace

from steadyload.layouts.model.layout import Item, Layout
from steadyload.layouts.packers.packed import ItemList, ItemType, with_packvium

SUPPORT = 0.75
"""Least share of every base that is supported."""

_Kind = tuple[int, int, int, float]
"""Sides [mm], ascending, and weight [kg]."""


def packed_again(plan: Layout) -> tuple[Layout, tuple[int, ...]]:
    """The bin that takes most boxes, when Packvium packs them; every box may be turned in any way.

    Returns:
        That bin, and of each item the step of one of its boxes in the plan.
    """
    steps: dict[_Kind, list[int]] = {}
    for step, item in enumerate(plan.items):
        steps.setdefault(_kind(item), []).append(step)
    depth, width, height = (
        round(10.0 * side) for side in (plan.pallet.depth, plan.pallet.width, plan.pallet.height)
    )
    types = tuple(ItemType(kind[:3], len(own), kind[3]) for kind, own in steps.items())
    boxes = ItemList(plan.name, (depth, width, height), types, units="mm")
    bins = with_packvium(boxes, support=SUPPORT).layouts
    fullest = max(bins, key=lambda one: (len(one), one.sizes.prod(axis=1).sum()))
    items, origins = [], []
    for item in fullest.items:
        origin = steps[_kind(item)].pop(0)
        items.append(replace(item, name=plan.items[origin].name))
        origins.append(origin)
    return Layout(plan.name, plan.pallet, tuple(items)), tuple(origins)


def _kind(item: Item) -> _Kind:
    small, middle, large = sorted(round(10.0 * side) for side in item.size)
    return small, middle, large, item.weight
