"""Makes the embedded study's layouts: ``python -m harness.studies.embedded.make_layouts``.

Twelve layouts of each of the paper's three item classes, 4 to 20 items each, packed without any
stability rule; packing rules take turns, and no two layouts are equal.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from harness.layouts.formats import Format, write_layouts
from harness.layouts.model import Layout
from harness.layouts.packing import ITEM_CLASSES, SPACE_RULES, pack, random_item_list

SEED = 20
PER_CLASS = 12
ITEMS_OFFERED = 40
LEAST_ITEMS, MOST_ITEMS = 4, 20


def embedded_layouts() -> list[Layout]:
    """The layouts, the same ones at every call."""
    layouts: list[Layout] = []
    rules = list(SPACE_RULES)
    for number, item_class in ITEM_CLASSES.items():
        random = np.random.default_rng(np.random.SeedSequence(SEED, spawn_key=(number,)))
        hashes: set[str] = set()
        while len(hashes) < PER_CLASS:
            sizes = random_item_list(item_class, ITEMS_OFFERED, random)
            most = int(random.integers(LEAST_ITEMS, MOST_ITEMS + 1))
            name = f"class{number}-{len(hashes):02d}"
            rule = rules[len(hashes) % len(rules)]
            layout = pack(name, item_class.pallet, sizes, rule, most_items=most)
            if layout is None or len(layout) < LEAST_ITEMS or layout.content_hash() in hashes:
                continue
            hashes.add(layout.content_hash())
            layouts.append(layout)
    return layouts


if __name__ == "__main__":
    target = Path(__file__).with_name("layouts.json")
    write_layouts(target, embedded_layouts(), Format.NATIVE)
    print(target)
