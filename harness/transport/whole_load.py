"""The rule of thumb: a load as one box, which slides at its friction and tips over its edge."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import ConvexHull

from steadyload.layouts.model import TOLERANCE, Arrangement
from steadyload.transport.errors import TransportError


def whole_load_limit(layout: Arrangement, friction: float, direction_deg: float) -> float:
    """The acceleration at which a load slides or tips, if nothing in it moved on its own [g].

    The lesser of the friction and of b / h: b is the way from under its centre of mass to the edge
    of what it stands on, in the direction of the force, and h the height of that centre.

    Args:
        layout: the load.
        friction: Coulomb coefficient at the deck, 0 or more.
        direction_deg: of the force on the boxes, seen from above.

    Raises:
        TransportError: no box stands on the deck.
    """
    low, high = layout.lower, layout.upper
    shares = layout.weights / layout.weights.sum()
    centre = shares @ (0.5 * (low + high) + layout.mass_offsets)
    below = low[:, 1] <= TOLERANCE
    if not below.any():
        lowest = float(low[:, 1].min())
        raise TransportError(
            f"layout {layout.name!r}: its lowest box is {lowest:g} cm above the deck; allowed: a "
            "load of which a box stands on it"
        )
    corners = [
        np.column_stack((x[below, 0], z[below, 2])) for x in (low, high) for z in (low, high)
    ]
    # A row (a, b, c) a side: a x + b z + c is the distance beyond it.
    sides = ConvexHull(np.concatenate(corners)).equations
    angle = math.radians(direction_deg)
    towards = sides[:, :2] @ (math.cos(angle), math.sin(angle))
    inside = -(sides[:, :2] @ centre[[0, 2]] + sides[:, 2])
    ahead = towards > 1e-9
    lever = float((inside[ahead] / towards[ahead]).min())
    return min(friction, max(0.0, lever / float(centre[1])))
