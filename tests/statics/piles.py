"""Piles that several tests build."""

from steadyload.layouts.model.layout import Item, Layout, Pallet


def top_below(boxes, x, z, width, depth):
    """The height at which a box comes to lie that is let down there [cm]."""
    tops = [
        b.position[1] + b.size[1] for b in boxes
        if b.position[0] < x + width and x < b.position[0] + b.size[0]
        and b.position[2] < z + depth and z < b.position[2] + b.size[2]
    ]  # fmt: skip
    return max(tops, default=0.0)


def wall(rows, width, weights=(1.0,)):
    """A wall of bricks, each on two of the row below, of some weights in turn."""
    items = []
    for row in range(rows):
        for place in range(width - row % 2):
            at = (20.0 * place + 10.0 * (row % 2), 10.0 * row, 0.0)
            weight = weights[len(items) % len(weights)]
            items.append(Item(len(items), at, (20.0, 10.0, 20.0), weight))
    return Layout("wall", Pallet(20.0 * width, 10.0 * rows, 20.0), tuple(items))
