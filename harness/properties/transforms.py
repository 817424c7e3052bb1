"""The same layout elsewhere on the pallet, turned or mirrored, centres of mass too."""

from __future__ import annotations

from dataclasses import replace

from steadyload.layouts.model import Layout, Pallet, Vector


def translated(layout: Layout, along_x: float, along_z: float) -> Layout:
    """Every item further along x and z by this [cm], 0 or more; the pallet grows as much."""
    width, height, depth = layout.pallet.size
    items = tuple(
        replace(item, position=_sum(item.position, (along_x, 0.0, along_z)))
        for item in layout.items
    )
    return Layout(layout.name, Pallet(width + along_x, height, depth + along_z), items)


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
    width, height, depth = layout.pallet.size
    return Layout(layout.name, Pallet(depth, height, width), items)


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
