"""The rule of thumb: a load as one box, which slides at its friction and tips over its edge."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import ConvexHull

from steadyload.layouts.model.contacts import FLOOR
from steadyload.layouts.model.layout import Arrangement
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
    low, high, supports = layout.lower, layout.upper, layout.supports
    shares = layout.weights / layout.weights.sum()
    centre = shares @ (0.5 * (low + high) + layout.mass_offsets)
    bases = [
        (low[item, 0], low[item, 2], high[item, 0], high[item, 2])
        for item, whole in enumerate(supports.on_floor)
        if whole
    ]
    bases += [patch[2:] for own in supports.below for patch in own if patch.below == FLOOR]
    if not bases:
        lowest = float(low[:, 1].min())
        raise TransportError(
            f"layout {layout.name!r}: its lowest box is {lowest:g} cm above the deck; allowed: a "
            "load of which a box stands on it"
        )
    corners = [(x, z) for x0, z0, x1, z1 in bases for x in (x0, x1) for z in (z0, z1)]
    # A row (a, b, c) a side: a x + b z + c is the distance beyond it.
    sides = ConvexHull(np.array(corners)).equations
    angle = math.radians(direction_deg)
    towards = sides[:, :2] @ (math.cos(angle), math.sin(angle))
    inside = -(sides[:, :2] @ centre[[0, 2]] + sides[:, 2])
    ahead = towards > 1e-9
    lever = float((inside[ahead] / towards[ahead]).min())
    return min(friction, max(0.0, lever / float(centre[1])))
