"""Bins of the number of boxes that pages of layouts of real size, and measurements, share."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

MOST_SMALL = 61
"""Boxes of a small layout at most. Larger ones are split apart from these, and their labels rest on
the two simulations that a set names as its ``screens``."""

SIZES = (MOST_SMALL, 100, 150)
"""Largest numbers of boxes of the sizes that pages answer for."""

FINE_SIZES = (37, *SIZES)
"""Those of the bins of tables and of measurements."""

FEWER = 24
"""Layouts of real size have more boxes."""


def binned(boxes: ArrayLike, largest: Sequence[int]) -> tuple[NDArray[np.intp], dict[int, str]]:
    """The bin of each layout, and by bin its name, such as ``62 to 100``; empty ones have none.

    Args:
        boxes: number of boxes of each layout.
        largest: largest numbers of boxes of the bins, which rise; what is larger is a last bin,
            whose name ends with the largest number there is.
    """
    count = np.asarray(boxes, dtype=int)
    place = np.searchsorted(largest, count)
    names = {}
    for bin_ in np.unique(place).tolist():
        low = largest[bin_ - 1] + 1 if bin_ else 1
        high = largest[bin_] if bin_ < len(largest) else int(count.max())
        names[bin_] = " to ".join(map(str, dict.fromkeys((low, high))))
    return place, names
