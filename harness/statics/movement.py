"""How far an item moves away from its planned pose."""

from __future__ import annotations

from typing import NamedTuple


class Movement(NamedTuple):
    """Movement of an item away from its planned pose.

    Attributes:
        item: its sequence number.
        displacement: [cm], as the criterion measures it.
        rotation: the largest angle about an axis [degrees].
        beyond: the larger of the two, in units of its threshold.
    """

    item: int
    displacement: float
    rotation: float
    beyond: float
