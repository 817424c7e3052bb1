"""Items at rest, and whether they can carry what moving items press on them.

Loads are handed down one way, from the highest base to the lowest. That proves that items stay at
rest where it succeeds; where it fails nothing is said, and the item has to be solved for.

A load has six numbers: force (x, y, z) [kg] and its moment about the origin (x, y, z) [kg cm]. In
``presses`` forces are vertical: force downwards [kg], force times x, force times z [kg cm].
"""

from __future__ import annotations

from typing import Any

import numpy as np

from steadyload.statics.kernels.compiled import compiled
from steadyload.statics.kernels.constants import EDGE, FLOOR
from steadyload.statics.kernels.contacts import Contacts
from steadyload.statics.kernels.least_squares import nonnegative_least_squares
from steadyload.statics.kernels.spreading import spread

_LEVEL = 1e-12
"""Share of a load: horizontal forces and twists below it are rounding."""

FREE, HANDED, WAITING = 1, 2, 3
"""State of an item while loads are handed down: it is solved for, its load has been handed
down, or will be; 0 for all others."""


@compiled
def first_overloaded(
    step: int, role: Any, loads: Any, contacts: Contacts, meets: Any, centres: Any, weights: Any,
    lower: Any, presses: Any, changed: Any, friction: float,
) -> int:  # fmt: skip
    """The first item at rest for which no way to carry its load was found; -1 where all do.

    Args:
        step: later items are not there.
        role: :data:`FREE` and :data:`WAITING` items; those reached become :data:`HANDED`, (J,).
        loads: of free items on all others, (J, 6).
        contacts: of the layout.
        meets: the patch of every pair of ``contacts.above``.
        centres: of mass (x, y, z) [cm], (J, 3).
        weights: [kg], (J,).
        lower: corners [cm], (J, 3).
        presses: what items at rest press on each other where nothing is handed down, (P, 3).
        changed: what those press that are :data:`HANDED` is put there, (P, 6).
        friction: of tops and bases.
    """
    load = np.empty(6)
    while True:
        item = -1
        for j in range(step + 1):
            if role[j] == WAITING and (item < 0 or lower[j, 1] > lower[item, 1]):
                item = j
        if item < 0:
            return -1
        role[item] = HANDED
        load[:] = loads[item]
        x, z, weight = centres[item, 0], centres[item, 2], weights[item]
        load[1] -= weight
        load[3] += weight * z
        load[5] -= weight * x
        for k in range(contacts.above_starts[item], contacts.above_ends[item]):
            other, patch = contacts.above[k], meets[k]
            if other > step or role[other] == FREE:
                continue
            if role[other] == HANDED:
                for c in range(6):
                    load[c] += changed[patch, c]
            else:
                load[1] -= presses[patch, 0]
                load[3] += presses[patch, 2]
                load[5] -= presses[patch, 1]
        if not _handed(item, step, load, role, contacts, lower, changed, friction):
            return item
        for k in range(contacts.starts[item], contacts.ends[item]):
            carrier = contacts.below[k]
            if carrier == FLOOR or carrier > step or contacts.on_floor[carrier]:
                continue
            if role[carrier] == 0 and (changed[k, 1] != 0.0 or presses[k, 0] != 0.0):
                role[carrier] = WAITING


@compiled
def _handed(
    item: int, step: int, load: Any, role: Any, contacts: Contacts, lower: Any, changed: Any,
    friction: float,
) -> bool:  # fmt: skip
    """Hand a load to the patches below an item that stand on items at rest; False without a way."""
    down = -load[1]
    if not down > 0.0:
        return False
    first, end = contacts.starts[item], contacts.ends[item]
    patches, below = np.empty((end - first, 4)), np.empty(end - first, dtype=np.int64)
    count = 0
    for k in range(first, end):
        carrier = contacts.below[k]
        if carrier <= step and carrier != FLOOR and role[carrier] == FREE:
            continue
        changed[k] = 0.0
        if carrier <= step:
            patches[count], below[count] = contacts.patches[k], k
            count += 1
    x, z = -load[5] / down, load[3] / down
    level = lower[item, 1]
    sideways = max(abs(load[0]), abs(load[2]))
    # What turns the item about the vertical, once the force is taken at its own point.
    twist = load[4] - (z * load[0] - x * load[2])
    if sideways <= _LEVEL * down and abs(twist) <= _LEVEL * down * 100.0:
        found = np.zeros((count, 3))
        if not spread(down, x, z, patches[:count], found):
            return False
        for k in range(count):
            at = below[k]
            changed[at, 1] = -found[k, 0]
            changed[at, 3] = found[k, 2]
            changed[at, 5] = -found[k, 1]
        return True
    return _handed_sideways(load, level, patches[:count], below, changed, friction)


@compiled
def _handed_sideways(
    load: Any, level: float, patches: Any, below: Any, changed: Any, friction: float
) -> bool:
    """Hand a load that is not vertical to patches, inside their friction pyramids."""
    count = len(patches)
    if count == 0 or friction == 0.0:
        return False
    down = -load[1]
    x, z = (-load[5] - level * load[0]) / down, (load[3] - level * load[2]) / down
    reach = EDGE
    for k in range(count):
        reach = max(reach, abs(patches[k, 0] - x), abs(patches[k, 2] - x))
        reach = max(reach, abs(patches[k, 1] - z), abs(patches[k, 3] - z))
    columns, target = np.empty((16 * count, 6)), np.empty(6)
    _put(target, load, x, level, z, 1.0 / down, reach)
    unit = np.empty(6)
    for k in range(16 * count):
        corner, facet = (k // 4) % 4, k % 4
        patch = patches[k // 16]
        a = patch[0] if corner < 2 else patch[2]
        b = patch[1] if corner % 2 == 0 else patch[3]
        _pressed(unit, a, level, b, facet, friction)
        _put(columns[k], unit, x, level, z, 1.0, reach)
    parts, rest, ended = nonnegative_least_squares(columns, target)
    if not ended or np.sqrt((rest**2).sum()) * reach > 0.1 * EDGE:
        return False
    for k in range(16 * count):
        if parts[k] > 0.0:
            corner, facet = (k // 4) % 4, k % 4
            patch = patches[k // 16]
            a = patch[0] if corner < 2 else patch[2]
            b = patch[1] if corner % 2 == 0 else patch[3]
            _pressed(unit, a, level, b, facet, friction)
            for c in range(6):
                changed[below[k // 16], c] += parts[k] * down * unit[c]
    return True


@compiled
def _pressed(unit: Any, x: float, y: float, z: float, facet: int, friction: float) -> None:
    """The load of a force downwards at a point, on one edge of the friction pyramid."""
    fx = friction if facet == 0 else (-friction if facet == 1 else 0.0)
    fz = friction if facet == 2 else (-friction if facet == 3 else 0.0)
    unit[0], unit[1], unit[2] = fx, -1.0, fz
    unit[3] = y * fz + z
    unit[4] = z * fx - x * fz
    unit[5] = -x - y * fx


@compiled
def _put(row: Any, load: Any, x: float, y: float, z: float, scale: float, reach: float) -> None:
    """A load as force and moment about a point, the moment in units of a length."""
    row[0], row[1], row[2] = load[0] * scale, load[1] * scale, load[2] * scale
    row[3] = (load[3] - (y * load[2] - z * load[1])) * scale / reach
    row[4] = (load[4] - (z * load[0] - x * load[2])) * scale / reach
    row[5] = (load[5] - (x * load[1] - y * load[0])) * scale / reach
