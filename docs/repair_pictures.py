"""The pictures of docs/repair.md: plans that fail, and beside each its repair.

``python docs/repair_pictures.py [FOLDER]`` writes them; a test makes them anew and compares.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import steadyload as sl
from steadyload.app.demo import demo_pallets
from steadyload.app.notebook_figures import repair_pictures
from steadyload.reports.viewer.picture import load_svg

FOLDER = Path(__file__).parent / "repairs"

PALLET = sl.Pallet(120, 160, 80)

ORDER = sl.Layout(
    "order",
    PALLET,
    (
        sl.Item(0, (20, 0, 20), (40, 30, 40), 12, name="SKU-2001"),
        sl.Item(1, (45, 30, 20), (40, 30, 40), 9, name="SKU-2003"),
        sl.Item(2, (60, 0, 20), (40, 30, 40), 12, name="SKU-2002"),
    ),
)
"""A box that is loaded before one of the two that carry it."""

CRUSHED = sl.Layout(
    "crushed",
    PALLET,
    (
        sl.Item(0, (0, 0, 20), (40, 30, 40), 12, name="EGGS", max_load=10),
        sl.Item(1, (40, 0, 20), (40, 30, 40), 12, name="CANS"),
        sl.Item(2, (0, 30, 20), (40, 30, 40), 9, name="SKU-2003"),
        sl.Item(3, (0, 60, 20), (40, 30, 40), 9, name="SKU-2004"),
    ),
)
"""Two boxes on one that bears less than both weigh."""


def plans() -> Iterator[sl.Layout]:
    """The plans, the last one by a packer, on an order of the labelled set of real size."""
    yield ORDER
    yield CRUSHED
    yield demo_pallets(4)[-1].renamed("packed")


def pictures() -> Iterator[tuple[str, str]]:
    """Name of each file and its SVG."""
    for plan in plans():
        repair = sl.repair(plan)
        assert repair.stands, repair
        yield f"{plan.name}.svg", load_svg(*repair_pictures(repair))


def main(folder: Path = FOLDER) -> None:
    """Write the pictures into a folder."""
    folder.mkdir(exist_ok=True)
    for name, svg in pictures():
        (folder / name).write_text(svg + "\n")
        print(folder / name)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
