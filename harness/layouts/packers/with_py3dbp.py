"""Plans of py3dbp: its packer or one of its bins, as they are after packing.

py3dbp knows no units and does not say which way is up: width, height and depth are its x, y and z,
as they are ours. Boxes may float: it puts a box beside, on or before another and asks for no
support.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Literal

from steadyload.layouts.model.layout import Vector
from steadyload.layouts.model.units import UNITS, WEIGHT_UNITS
from steadyload.layouts.packers.plan import (
    Bin,
    Order,
    Placed,
    Plan,
    PlanError,
    factor,
    plan,
)


def from_py3dbp(
    packed: Any,
    *,
    units: str = "cm",
    weights: str = "kg",
    up: Literal["y", "z"] = "y",
    order: Order = "height",
) -> Plan:
    """Layouts of a py3dbp ``Packer``, or of one ``Bin``, that has packed.

    Args:
        packed: the packer, or the bin.
        units: the unit of its lengths: mm, cm, m or in.
        weights: the unit of its weights: g, kg or lb. An item that weighs 0 weighs 200 kg/m3.
        up: the axis that points up: ``y``, the height, or ``z``, the depth, for those who pack with
            the height as third side.
        order: the loading order: ``height`` (base, then from the back to the front) or ``given``,
            the order in which the items were packed.

    Raises:
        PlanError: what is given has not been packed by py3dbp, or one item is in two bins.
        LayoutError: a bin is no valid layout.
    """
    bins = [packed] if hasattr(packed, "unfitted_items") else getattr(packed, "bins", None)
    if bins is None or not all(hasattr(each, "unfitted_items") for each in bins):
        raise PlanError(f"a {type(packed).__name__} is no plan; allowed: py3dbp's Packer or Bin")
    if up not in ("y", "z"):
        raise PlanError(f"up is {up!r}; allowed: 'y', 'z'")
    placed = _each_in_one_bin(bins)
    length, weight = factor(units, UNITS), factor(weights, WEIGHT_UNITS)

    def loaded() -> Iterator[Bin]:
        for each in bins:
            boxes = [
                Placed(
                    str(item.name),
                    _scaled(item.position, length),
                    _scaled(item.get_dimension(), length),
                    float(item.weight) * weight or None,
                )
                for item in each.items
            ]
            size = _scaled((each.width, each.height, each.depth), length)
            yield Bin(str(each.name), size, boxes, up)

    # Those of a packer itself are in no list of a bin's before it has packed them.
    left = {id(item): str(item.name) for each in bins for item in each.unfitted_items}
    left |= {id(item): str(item.name) for item in packed.items}
    return plan(loaded(), [name for key, name in left.items() if key not in placed], order)


def _each_in_one_bin(bins: Any) -> set[int]:
    """Identities of the items in bins.

    Packed without ``distribute_items``, an item is in every bin that it fits into, and lies only
    where the last one has put it.
    """
    seen: dict[int, str] = {}
    for each in bins:
        for item in each.items:
            if id(item) in seen:
                raise PlanError(
                    f'item "{item.name}" is in bin "{seen[id(item)]}" and in bin "{each.name}"; '
                    "allowed: each in one, as pack(distribute_items=True) leaves them"
                )
            seen[id(item)] = str(each.name)
    return set(seen)


def _scaled(values: Any, by: float) -> Vector:
    x, y, z = (float(value) * by for value in values)
    return x, y, z
