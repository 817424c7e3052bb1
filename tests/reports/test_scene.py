"""Layouts drawn in 3-D."""

from dataclasses import replace

import numpy as np
from matplotlib import pyplot

from steadyload.layouts import Item, Layout, Pallet
from steadyload.reports.charts.scene import scene

BOX = Item(0, (-6.0, 0.0, 5.0), (20.0, 10.0, 10.0), 1.0)


def drawn(layout):
    figure = scene(layout).figure
    [axes] = figure.axes
    ends = [getattr(axes, f"get_{name}lim")() for name in "yzx"]  # width, height, depth
    pyplot.close(figure)
    return len(axes.collections), np.array(ends).T


def test_a_deck_with_edges_is_drawn_and_a_plane_is_not():
    inside = Layout("inside", Pallet(60.0, 40.0, 30.0), (replace(BOX, position=(0.0, 0.0, 5.0)),))
    over = Layout("over", inside.pallet, (BOX,))
    plane, ends = drawn(inside)
    assert ends.tolist() == [[0.0, 0.0, 0.0], [60.0, 10.5, 30.0]]
    deck, ends = drawn(over)
    assert deck == plane + 1
    # All of the slab and of the box that overhangs it is to be seen.
    assert ends.tolist() == [[-6.0, -14.4, 0.0], [60.0, 10.5, 30.0]]
