"""Item lists packed by the packers whose plans can be read: a function a packer, by its name.

Every box may be turned in any way: py3dbp cannot be told otherwise. The packers come with the extra
``packers`` and are imported when they pack.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from functools import partial
from importlib import metadata
from types import ModuleType
from typing import Any

from steadyload.errors import UserError
from steadyload.layouts.model.units import UNITS
from steadyload.layouts.packers.plan import Plan
from steadyload.layouts.packers.with_packingsolver import from_packingsolver
from steadyload.layouts.packers.with_packvium import from_packvium
from steadyload.layouts.packers.with_py3dbp import from_py3dbp

Sides = tuple[int, int, int]
"""Length, width and height, whole numbers."""

_NO_LIMIT = 1_000_000
"""Weight that a bin of py3dbp may carry [kg]."""


class PackerNotInstalledError(UserError):
    """The package of a packer is missing; the message says how to install it."""


@dataclass(frozen=True, slots=True)
class ItemType:
    """Boxes of one kind.

    Args:
        sides: in the unit of the list.
        copies: how many, 1 or more.
        weight: of one [kg]; 0 where it is not known, which is read as 200 kg/m3.
    """

    sides: Sides
    copies: int
    weight: float = 0.0


@dataclass(frozen=True, slots=True)
class ItemList:
    """Boxes to be packed into as many bins of one size as it takes.

    Args:
        name: of the list.
        bin: in the unit of the list.
        types: of the boxes; a plan names boxes of the first ``type 0``.
        units: the unit of all lengths: mm, cm, m or in.
        origin: the published instance that its boxes are of; empty where it is one itself. Splits
            never part what has one origin.
    """

    name: str
    bin: Sides
    types: tuple[ItemType, ...]
    units: str = "cm"
    origin: str = ""

    @property
    def count(self) -> int:
        """Number of boxes."""
        return sum(each.copies for each in self.types)


def with_packingsolver(items: ItemList, *, time_limits: Iterable[float] = (10.0,)) -> Plan:
    """The plan of PackingSolver: one pass.

    Args:
        items: what to pack.
        time_limits: of the pass [s]; a further one is used where those before it gave no plan.
    """
    packer = _imported("packingsolver3d")
    instance = packer.Instance(
        bin_types=[packer.BinType(*items.bin, copies=items.count)],
        item_types=[
            packer.ItemType(*each.sides, copies=each.copies, rotations=packer.ALL_ROTATIONS)
            for each in items.types
        ],
        objective=packer.Objective.BIN_PACKING,
    )
    one_pass = packer.OptimizationMode.NOT_ANYTIME_SEQUENTIAL
    result: Any = None
    for limit in time_limits:
        result = packer.box.solve(instance, time_limit=limit, optimization_mode=one_pass)
        if result.bins:
            break
    weights = {kind: each.weight for kind, each in enumerate(items.types)}
    return from_packingsolver(result, instance=instance, units=items.units, weights=weights)


def with_packvium(items: ItemList, *, support: float = 0.0) -> Plan:
    """The plan of Packvium.

    Args:
        items: what to pack.
        support: least share of each base that is supported, 0 to 1.
    """
    packer = _imported("packvium")
    config = packer.PackingConfig.balanced(
        minimum_support_ratio=support,
        time_limit_ms=60_000,
        effort_budget=packer.EffortBudget(max_candidates_evaluated=20_000),
    )
    millimetres = 10 * UNITS[items.units]

    def dimensions(sides: Sides) -> Any:
        return packer.Dimensions.mm(*(str(Decimal(side) * millimetres) for side in sides))

    boxes = [
        packer.Item.create(_named(kind), dimensions(each.sides), quantity=each.copies)
        for kind, each in enumerate(items.types)
    ]
    container = packer.Container.create("bin", dimensions(items.bin))
    weights = {_named(kind): each.weight for kind, each in enumerate(items.types)}
    return from_packvium(packer.Packer(config).pack(boxes, [container]), weights=weights)


def with_py3dbp(items: ItemList) -> Plan:
    """The plan of py3dbp, largest boxes first."""
    package = _imported("py3dbp")
    packer = package.Packer()
    length, width, height = items.bin
    for number in range(items.count):
        packer.add_bin(package.Bin(f"bin {number}", width, height, length, _NO_LIMIT))
    for kind, each in enumerate(items.types):
        x, y, z = each.sides
        for _ in range(each.copies):
            packer.add_item(package.Item(_named(kind), y, z, x, each.weight))
    packer.pack(bigger_first=True, distribute_items=True)
    return from_py3dbp(packer, units=items.units)


Packing = Callable[[ItemList], Plan]
"""Packs a list; raises :class:`PackerNotInstalledError` where its package is missing."""

PACKERS: Mapping[str, Packing] = {
    "packingsolver3d": with_packingsolver,
    "packvium": with_packvium,
    "packvium-support-75": partial(with_packvium, support=0.75),
    "py3dbp": with_py3dbp,
}
"""Name of a packer, with what it is told -> the function that packs."""

_PACKAGES = ("packingsolver3d", "packvium", "py3dbp")


def packer_versions() -> dict[str, str]:
    """Versions of the packers.

    Raises:
        PackerNotInstalledError: one is missing.
    """
    return {name: metadata.version(_imported(name).__name__) for name in _PACKAGES}


def _imported(name: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name:
            raise
        raise PackerNotInstalledError(
            f"packing with {name} needs its package: pip install 'steadyload[packers]'"
        ) from None


def _named(kind: int) -> str:
    """Name of the boxes of a type, as :func:`from_packingsolver` gives it."""
    return f"type {kind}"
