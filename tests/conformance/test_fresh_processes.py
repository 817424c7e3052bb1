"""The same layouts judged by every engine in two fresh processes give identical score tables."""

import json
import subprocess
import sys

from tested_engines import TESTED

SCRIPT = """
import json, sys
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods import make_method
rows = []
layouts = random_layouts(5, 9)
largest = max(layouts, key=len)
layouts = [layout.first(min(len(layout), 8)) for layout in layouts] + [largest]
for engine in sys.argv[1:]:
    for tuning in ("ps_opt-paper", "simulation"):
        values = "" if tuning == "ps_opt-paper" else ":between_steps=reseat,frequency=90"
        for verdict in make_method(f"{tuning}@{engine}{values}").judge_many(layouts):
            rows.append([verdict.status, verdict.failing_step, verdict.moved_item,
                         verdict.displacement, verdict.rotation, verdict.effort.substeps])
print(json.dumps(rows))
"""


def table():
    command = [sys.executable, "-c", SCRIPT, *TESTED]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def test_two_fresh_processes_give_identical_tables():
    first = table()
    assert first == table()
    rows = json.loads(first)
    assert len(rows) == 12 * len(TESTED)
    assert any(row[1] is not None for row in rows)
