"""Makes the embedded study's layouts: ``python -m harness.studies.embedded.make_layouts``."""

from __future__ import annotations

from pathlib import Path

from harness.layouts.formats import Format, write_layouts
from harness.layouts.model import Layout
from harness.layouts.packing import random_layouts
from harness.layouts.scenarios import Scenario

SEED = 20
COUNT = 36


def embedded_layouts() -> list[Layout]:
    """The layouts, the same ones at every call; the study draws their centres of mass itself."""
    return random_layouts(COUNT, SEED, scenario=Scenario.S1)


if __name__ == "__main__":
    target = Path(__file__).with_name("layouts.json")
    write_layouts(target, embedded_layouts(), Format.NATIVE)
    print(target)
