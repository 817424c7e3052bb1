"""What a search calls is compiled before its time begins to count."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

PROGRAM = """
import sys
from numba.core.dispatcher import Dispatcher
from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.repairing.confirmed import Confirmation, ConfirmedSearch
from steadyload.repairing.plan import Boxes, Kind


def compiled():
    kernels = {
        (name, word): kernel
        for name, module in list(sys.modules.items()) if name.startswith("steadyload.")
        for word, kernel in vars(module).items() if isinstance(kernel, Dispatcher)
    }
    return {name for name, kernel in kernels.items() if kernel.overloads}


places, allows = [(0.0, 0.0, 0.0), (15.0, 20.0, 0.0), (15.0, 40.0, 0.0)], float(sys.argv[1])
items = tuple(
    Item(step, place, (20.0, 20.0, 20.0), 5.0, max_load=None if allows == 0.0 else allows)
    for step, place in enumerate(places)
)
boxes = Boxes(Layout("leans", Pallet(100.0, 100.0, 100.0), items))
search = ConfirmedSearch(
    boxes, sys.argv[2].split(","), 30.0, 0, lambda plan: Confirmation(True), 1e3
)
before = compiled()
found = search.run()
print(found.tried > 1 or found.attempt is not None, sorted(compiled() - before))
"""


@pytest.mark.parametrize("max_load", ["0", "20"])
@pytest.mark.parametrize("allowed", ["order,drop,shift,turn,move", "order,leave", "shift"])
def test_no_kernel_is_loaded_or_compiled_once_a_search_runs(max_load, allowed):
    ended = subprocess.run(
        [sys.executable, "-c", PROGRAM, max_load, allowed],
        env=os.environ, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert ended.stdout.strip() == "True []", ended.stderr
