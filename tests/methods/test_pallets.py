"""Customers' pallets, which overhang their decks: the table of docs/pallets.md."""

from pathlib import Path

import numpy as np

from steadyload.layouts.formats import read_layouts
from steadyload.layouts.model.layout import TOLERANCE
from steadyload.methods.registry import make_method
from steadyload.properties.transforms import drawn_in
from steadyload.runs.scoring import score_layouts

METHODS = ("fbs", "sme", "equilibrium")
PAGE = Path(__file__).resolve().parents[2] / "docs" / "pallets.md"


def published(floor):
    """Numbers of a row of the page's table."""
    [row] = [line for line in PAGE.read_text().splitlines() if line.startswith(f"| {floor} |")]
    return [int(cell) for cell in row.strip("|").split("|")[1:]]


def counted(found, plane):
    stand = [steps.count(None) for steps in found]
    return stand + [sum(map(lambda a, b: a != b, *pair)) for pair in zip(found, plane, strict=True)]


def test_the_table_of_customers_pallets_is_what_methods_say(customers_pallets):
    pallets = read_layouts(customers_pallets)
    assert len(pallets) == 263
    assert sum(pallet.floor.has_edges for pallet in pallets) == 218
    floors = {
        "infinite plane": [pallet.on("infinite") for pallet in pallets],
        "deck, as read": pallets,
        "deck drawn in by 5 cm": [drawn_in(pallet, 5.0) for pallet in pallets],
        "deck drawn in by 10 cm": [drawn_in(pallet, 10.0) for pallet in pallets],
    }
    methods = [make_method(name) for name in METHODS]
    found = {
        floor: [[v.failing_step for v in method.judge_many(layouts)] for method in methods]
        for floor, layouts in floors.items()
    }
    for floor, steps in found.items():
        assert counted(steps, found["infinite plane"]) == published(floor)
    # A box on the floor falls, at the latest, where its own centre of mass is past the edge.
    for layout, step in zip(
        floors["deck drawn in by 10 cm"], found["deck drawn in by 10 cm"][2], strict=True
    ):
        centres = (0.5 * (layout.lower + layout.upper) + layout.mass_offsets)[:, ::2]
        past = np.maximum(layout.floor.low - centres, centres - layout.floor.high).max(axis=1)
        falls = np.flatnonzero((layout.lower[:, 1] <= TOLERANCE) & (past > TOLERANCE))
        assert not len(falls) or (step is not None and step <= falls[0])


def test_customers_pallets_are_judged_without_an_option(customers_pallets):
    records = score_layouts([customers_pallets], METHODS)
    assert len(records) == 3 * 263
    assert {record["status"] for record in records} == {"done"}
    stand = [sum(r["score"] == 1.0 for r in records if r["method"] == m) for m in METHODS]
    assert stand == published("deck, as read")[:3]
