"""A search waits for no compilation: numba is not even imported."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

PROGRAM = """
import sys
from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.repairing.confirmed import Confirmation, ConfirmedSearch
from steadyload.repairing.plan import Boxes, Kind

places, allows = [(0.0, 0.0, 0.0), (15.0, 20.0, 0.0), (15.0, 40.0, 0.0)], float(sys.argv[1])
items = tuple(
    Item(step, place, (20.0, 20.0, 20.0), 5.0, max_load=None if allows == 0.0 else allows)
    for step, place in enumerate(places)
)
boxes = Boxes(Layout("leans", Pallet(100.0, 100.0, 100.0), items))
search = ConfirmedSearch(
    boxes, sys.argv[2].split(","), 30.0, 0, lambda plan: Confirmation(True), 1e3
)
found = search.run()
print(found.tried > 1 or found.attempt is not None, "numba" in sys.modules)
"""


@pytest.mark.parametrize("max_load", ["0", "20"])
@pytest.mark.parametrize("allowed", ["order,drop,shift,turn,move", "order,leave", "shift"])
def test_a_search_compiles_nothing(max_load, allowed):
    ended = subprocess.run(
        [sys.executable, "-c", PROGRAM, max_load, allowed],
        env=os.environ, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert ended.stdout.strip() == "True False", ended.stderr
