"""The same layout elsewhere on the pallet, turned or mirrored, centres of mass too."""

from __future__ import annotations

from dataclasses import replace

from steadyload.layouts.model import Layout, Vector


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
