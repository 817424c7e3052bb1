"""Layouts whose units were probably read wrong: grams as kilograms, millimetres as centimetres.

The limits lie far beyond goods of any kind: no load is denser than lead or about as light as air,
and no deck of freight, on the road or in the air, is wider than 3 m or as small as a hand.
"""

from __future__ import annotations

from decimal import Decimal

import numpy as np

from steadyload.escaping import printable
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.checks import SHOWN
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import Layout

DENSITIES = (0.0015, 12.0)
"""Plausible mean densities of a load [kg per litre]."""

WIDEST, SHORTEST = 400.0, 10.0
"""Longest plausible shorter side, and shortest plausible longer side, of a deck [cm]."""

_LITRE = 1000.0
_ROUNDING = 1e-9


def implausible(layout: Layout, frame: Frame | None = None) -> str:
    """Sentence on what is implausible about a layout, with the units that were probably meant.

    Args:
        layout: as it was read.
        frame: units of the sentence: those of the file of the layout.

    Returns:
        A sentence; empty for a layout that may well be as it is stated.
    """
    width, depth = layout.pallet.width, layout.pallet.depth
    density = float(layout.weights.sum() / np.prod(layout.sizes, axis=1).sum() * _LITRE)
    unit, scale = "", 1.0
    if min(width, depth) > WIDEST:
        unit, scale = "--units mm", 0.1
    elif max(width, depth) < SHORTEST:
        unit, scale = "--units m", 100.0
    meant = [unit] if unit else []
    if density / scale**3 > DENSITIES[1]:
        meant.append("--weight g")
    elif density / scale**3 < DENSITIES[0]:
        meant.append("another --weight" if unit else "another --units or --weight")
    if not meant:
        return ""
    frame = frame or Frame()
    longest, weight = np.median(layout.sizes.max(axis=1)), np.median(layout.weights)
    size = " x ".join(_length(side, frame) for side in frame.in_plan(width, depth))
    return (
        f'layout "{printable(layout.name, SHOWN)}": a pallet of {size} and boxes of '
        f"{_length(longest, frame)} and {_plain(weight / frame.kg, 4)} {frame.weight} (medians), "
        f"{_plain(density, 2)} kg a litre: did you mean {' and '.join(meant)}?"
    )


def implausible_among(batch: LayoutBatch) -> str:
    """The sentence on the first layout of a batch that is implausible; empty where none is.

    Args:
        batch: layouts as they were read, of a file in cm and kg, with y up.
    """
    volumes = batch.sizes[:, 0] * batch.sizes[:, 1] * batch.sizes[:, 2]
    weights, volumes = (np.add.reduceat(v, batch.starts[:-1]) for v in (batch.weights, volumes))
    # Sums in another order may differ in their last digits.
    density, low, high = weights / volumes * _LITRE, *DENSITIES
    doubtful = (density < low * (1.0 + _ROUNDING)) | (density > high * (1.0 - _ROUNDING))
    decks = [(kind.width, kind.depth) for kind in batch.kinds.kinds]
    odd = np.array([min(deck) > WIDEST or max(deck) < SHORTEST for deck in decks], dtype=bool)
    doubtful |= odd[batch.kinds.which]
    told = (implausible(batch[k]) for k in np.flatnonzero(doubtful).tolist())
    return next(filter(None, told), "")


def _length(cm: float, frame: Frame) -> str:
    return f"{_plain(cm / frame.cm, 5)} {frame.unit}"


def _plain(number: float, digits: int) -> str:
    """A number without an exponent, to some significant digits."""
    return f"{Decimal(f'{number:.{digits}g}'):,f}"
