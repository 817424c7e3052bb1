"""Features of every step: a row of numbers an item, from the items placed by then."""

from __future__ import annotations

from dataclasses import replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from steadyload.core.learned import plain_features, support
from steadyload.core.whole import Given
from steadyload.layouts.model.layout import Arrangement, Item, Layout, Vector

Array32 = NDArray[np.float32]


class FeatureKind(StrEnum):
    """Kind of features.

    ``plain``: those of the paper's Fig. 2: position, size, centre of mass and weight of the item
    and the size of the pallet. ``support``: how the item and all that carries it stand on what is
    below them (:data:`SUPPORT`), whatever the pallet and the way it is turned.
    """

    PLAIN = "plain"
    SUPPORT = "support"


VERSION = 2
"""Of all features: raised when a layout has others."""

PLAIN = (
    "x", "y", "z", "width", "height", "depth", "mass x", "mass y", "mass z", "weight",
    "pallet width", "pallet height", "pallet depth", "scale",
)  # fmt: skip
"""Lengths in shares of the pallet's longest side, the feature ``scale`` [log of metres]; ``mass``:
centre of mass from the geometric centre; ``weight`` the log of the item's weight on a pallet of one
metre [kg], at the same density."""

STATE = (
    "supported share", "supporters", "margin", "relative margin", "drop", "free angle",
    "touch angle", "side angle", "catch angle", "angle", "way", "excess", "held angle",
    "box height", "lever", "load", "shorter side",
)  # fmt: skip
SUPPORT = (
    "on the floor", *STATE, "height", "weight", "mass height",
    *(f"worst {name}" for name in (*STATE, "height")),
    "least margin", "items below", "unbalanced", "moving",
)  # fmt: skip
"""Of item j itself, then of the item in the greatest danger among those that the step reaches, and
over all of these: ``sl_column`` of ``harness/core/learned.h`` has what each is, in this order. None
depends on the pallet but for the edges of a deck, nor on where on it an item stands, nor on the
unit of weight; none changes when the layout is turned or mirrored."""

_X, _Y, _Z, _WIDTH, _HEIGHT, _DEPTH, _MASS_X, _MASS_Y, _MASS_Z = range(9)
_PALLET_X, _PALLET_Z = 10, 12

SYMMETRIES = 8
"""Turns and mirrors of a pallet about its vertical: bit 0 mirrors along x, bit 1 along z, bit 2
then swaps the two axes. 0 leaves all as it is."""


def names(kind: FeatureKind) -> tuple[str, ...]:
    """Names of the features, in the order of the columns."""
    return PLAIN if kind is FeatureKind.PLAIN else SUPPORT


def features(layout: Arrangement, kind: FeatureKind) -> Array32:
    """The features of every step, not yet normalised: shape (J, len(names(kind))).

    Row j depends on the items 0 to j alone.
    """
    return features_of(layout.given, layout.pallet.size, kind)


def features_of(given: Given, pallet: Vector, kind: FeatureKind) -> Array32:
    """As :func:`features`, of a layout on a pallet of a size."""
    found: Array32 = (
        plain_features(given, np.array(pallet, dtype=np.float64))
        if kind is FeatureKind.PLAIN
        else support(given)[1]
    )
    return found


def turned(layout: Layout, symmetry: int) -> Layout:
    """The layout turned or mirrored, with its pallet; see :data:`SYMMETRIES`."""
    width, _, depth = layout.pallet.size
    items = []
    for item in layout.items:
        (x, y, z), (w, h, d), (a, b, c) = item.position, item.size, item.mass_offset
        if symmetry & 1:
            x, a = width - x - w, -a
        if symmetry & 2:
            z, c = depth - z - d, -c
        if symmetry & 4:
            x, z, w, d, a, c = z, x, d, w, c, a
        items.append(Item(item.sequence, (x, y, z), (w, h, d), item.weight, (a, b, c), item.name))
    pallet = layout.pallet
    if symmetry & 4:
        pallet = replace(pallet, width=depth, depth=width)
    return Layout(layout.name, pallet, tuple(items))


def symmetry_matrices(kind: FeatureKind) -> Array32:
    """Matrices of symmetries: ``features(turned(layout, k)) == features(layout) @ m[k]``.

    All plain features are linear in what a symmetry changes, and those of support do not change.

    Returns:
        Shape (SYMMETRIES, F, F), F columns.
    """
    count = len(names(kind))
    if kind is FeatureKind.SUPPORT:
        return np.tile(np.eye(count, dtype=np.float32), (SYMMETRIES, 1, 1))
    mirrors = []
    for at, size, mass, pallet in (
        (_X, _WIDTH, _MASS_X, _PALLET_X),
        (_Z, _DEPTH, _MASS_Z, _PALLET_Z),
    ):
        mirror = np.eye(count)
        mirror[:, at] = 0.0
        mirror[at, at], mirror[size, at], mirror[pallet, at] = -1.0, -1.0, 1.0
        mirror[mass, mass] = -1.0
        mirrors.append(mirror)
    swap = np.eye(count)
    pairs = ((_X, _Z), (_WIDTH, _DEPTH), (_MASS_X, _MASS_Z), (_PALLET_X, _PALLET_Z))
    for one, two in pairs:
        swap[:, [one, two]] = swap[:, [two, one]]
    result = []
    for symmetry in range(SYMMETRIES):
        matrix = np.eye(count)
        for bit, part in enumerate((*mirrors, swap)):
            if symmetry >> bit & 1:
                matrix = matrix @ part
        result.append(matrix)
    return np.array(result, dtype=np.float32)
