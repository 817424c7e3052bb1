"""The same layout elsewhere on the pallet, turned or mirrored, centres of mass too."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from steadyload.layouts.model.layout import Layout, Vector
from steadyload.methods.contract.declared import LayoutRange


def translated(layout: Layout, along_x: float, along_z: float) -> Layout:
    """Every item further along x and z by this [cm], 0 or more; the pallet grows as much."""
    pallet = layout.pallet
    items = tuple(
        replace(item, position=_sum(item.position, (along_x, 0.0, along_z)))
        for item in layout.items
    )
    wider = replace(pallet, width=pallet.width + along_x, depth=pallet.depth + along_z)
    return Layout(layout.name, wider, items)


def drawn_in(layout: Layout, by: float) -> Layout:
    """The same items on a deck that is narrower by this at every edge [cm], overhanging by it more.

    The items stand where they stood; positions are those from the new deck's corner.
    """
    pallet = layout.pallet
    deck = replace(
        pallet,
        width=pallet.width - 2.0 * by,
        depth=pallet.depth - 2.0 * by,
        overhang=pallet.overhang + by,
    )
    items = tuple(
        replace(item, position=_sum(item.position, (-by, 0.0, -by))) for item in layout.items
    )
    return Layout(layout.name, deck, items)


def brought_within(layout: Layout, declared: LayoutRange) -> Layout:
    """The layout with the least changes that bring it into a method's range, where there are some.

    All lengths are scaled alike, by a power of two where one will do, so that positions still add
    up exactly; weights go with the cube. Light items then get heavier and shifts of centres of mass
    smaller, as far as they have to. Sides too unequal for the range stay outside of it, and so does
    an overhang.
    """
    factor = _scale_into(layout, declared)
    weights = layout.weights * factor**3
    least, most = declared.weight
    weights = np.clip(weights, least, most)
    # The quotient must not exceed the ratio by rounding.
    weights = np.maximum(weights, weights.max() / declared.weight_ratio * (1.0 + 1e-9))
    items = tuple(
        replace(
            item,
            position=_times(item.position, factor),
            size=_times(item.size, factor),
            weight=float(weight),
            mass_offset=_limited(
                _times(item.mass_offset, factor), _times(item.size, factor), declared
            ),
        )
        for item, weight in zip(layout.items, weights, strict=True)
    )
    width, height, depth = _times(layout.pallet.size, factor)
    if max(width, height, depth) < declared.pallet_side[0]:
        height = declared.pallet_side[0]
    overhang = layout.pallet.overhang * max(1.0, factor)
    pallet = replace(layout.pallet, width=width, height=height, depth=depth, overhang=overhang)
    return Layout(layout.name, pallet, items)


def _scale_into(layout: Layout, declared: LayoutRange) -> float:
    """Factor of all lengths that brings sides into a range, the closest to 1; 1 if none does."""
    sizes = layout.upper - layout.lower
    shortest, longest = sizes.min(axis=1), sizes.max(axis=1)
    least = max(
        declared.shortest_side[0] / float(shortest.min()),
        declared.longest_side[0] / float(longest.min()),
    )
    most = min(
        declared.shortest_side[1] / float(shortest.max()),
        declared.longest_side[1] / float(longest.max()),
        declared.pallet_side[1] / max(layout.pallet.size),
    )
    if least > most or least <= 1.0 <= most:
        return 1.0
    if least > 1.0:
        power = 2.0 ** math.ceil(math.log2(least))
        return power if power <= most else least
    power = 2.0 ** math.floor(math.log2(most))
    return power if power >= least else most


def _limited(offset: Vector, size: Vector, declared: LayoutRange) -> Vector:
    """A shift of a centre of mass, within the range along every axis."""
    if math.isinf(declared.mass_offset):
        return offset
    x, y, z = (
        max(-declared.mass_offset * side, min(declared.mass_offset * side, value))
        for value, side in zip(offset, size, strict=True)
    )
    return (x, y, z)


def _times(vector: Vector, factor: float) -> Vector:
    return (vector[0] * factor, vector[1] * factor, vector[2] * factor)


def quarter_turned(layout: Layout) -> Layout:
    """Turned about the vertical by a quarter, z into x: (x, z) becomes (z, width - x)."""
    items = tuple(
        replace(
            item,
            position=(
                item.position[2],
                item.position[1],
                layout.pallet.width - item.position[0] - item.size[0],
            ),
            size=(item.size[2], item.size[1], item.size[0]),
            mass_offset=(item.mass_offset[2], item.mass_offset[1], -item.mass_offset[0]),
        )
        for item in layout.items
    )
    pallet = layout.pallet
    turned = replace(pallet, width=pallet.depth, depth=pallet.width)
    return Layout(layout.name, turned, items)


def mirrored(layout: Layout) -> Layout:
    """Mirrored in a plane across x: x becomes width - x."""
    items = tuple(
        replace(
            item,
            position=(
                layout.pallet.width - item.position[0] - item.size[0],
                item.position[1],
                item.position[2],
            ),
            mass_offset=(-item.mass_offset[0], item.mass_offset[1], item.mass_offset[2]),
        )
        for item in layout.items
    )
    return Layout(layout.name, layout.pallet, items)


def _sum(first: Vector, second: Vector) -> Vector:
    return (first[0] + second[0], first[1] + second[1], first[2] + second[2])
