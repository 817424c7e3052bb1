"""Customers' pallets on several floors: what the deck's edge and small gaps change."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from steadyload.atomic import without_link
from steadyload.layouts.benchmark import Benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.floor import FloorKind
from steadyload.layouts.model.scenarios import Scenario
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.judged import load_judged
from steadyload.statistics.metrics import share
from steadyload.studies.evaluation.judging import LIMITED_SHARD_SIZE, PALLETS, PART, Options, run
from steadyload.studies.evaluation.verdicts import of_customers
from steadyload.studies.kit import Lab

FLOOR_METHODS = (
    "equilibrium:margin=0.01", "equilibrium:time=0.3", "settling", "cascade@mujoco",
)  # fmt: skip
"""Of the methods that are compared, those that judge customers' pallets on several floors."""

FLOORS: Mapping[str, tuple[FloorKind, float]] = {
    "deck with edges, as delivered": (FloorKind.AUTO, 0.0),
    "infinite plane": (FloorKind.INFINITE, 0.0),
    "deck, gaps up to 0.35 cm closed": (FloorKind.AUTO, 0.35),
    "deck, gaps up to 1 cm closed": (FloorKind.AUTO, 1.0),
    "deck, gaps up to 2 cm closed": (FloorKind.AUTO, 2.0),
}
"""Floor, and vertical gaps that are closed [cm]."""


def floors(lab: Lab, asked: Options, benchmark: Benchmark) -> pd.DataFrame:
    """A row a floor, the first one as delivered: the share that a method calls stable, and changes.

    Changes are the pallets whose failing step is not that on the first floor; a case without a
    verdict on either has changed. Empty without a time limit, where there are no customers'
    pallets, or where no method judges them on floors.
    """
    methods = tuple(spec for spec in asked.spatial if spec in FLOOR_METHODS)
    limited = methods and asked.timeout is not None
    chosen = _customers_pallets(benchmark, PALLETS) if limited else []
    if not chosen:
        return pd.DataFrame()
    file = lab.work.resolve() / "pallets.json"
    delivered = [benchmark.layout(name, str(Scenario.S1)) for name in chosen]
    write_layouts(without_link(file), delivered, Format.NATIVE)
    rows: list[dict[str, Any]] = []
    first: pd.DataFrame | None = None
    lists = benchmark.layouts["instance"]
    for number, (words, (floor, gap)) in enumerate(FLOORS.items()):
        definition = StudyDefinition(
            f"real floor {number}", methods, files=(file,), floor=floor, snap_gap=gap,
            timeout=asked.timeout, shard_size=LIMITED_SHARD_SIZE,
        )  # fmt: skip
        run(lab, definition, f"floor-{number}")
        found = load_judged(lab.work / f"floor-{number}")
        clusters = lists.loc[found.said.index.get_level_values("layout")].to_numpy()
        items = found.results.drop_duplicates(KEYS).set_index(KEYS)["item_count"]
        stable = found.said.eq(items.loc[found.said.index], axis=0).fillna(False)
        first = found.said if first is None else first
        same = (found.said == first.loc[found.said.index]).fillna(False)
        titles = {spec: key.title for spec, key in found.keys.items()}
        rows.append(
            {"floor": words, "pallets": len(found.said)}
            | {f"floor_stable:{t}": share(stable[spec], clusters) for spec, t in titles.items()}
            | {f"floor_changed:{t}": int((~same[spec]).sum()) for spec, t in titles.items()}
        )
    return pd.DataFrame(rows)


def _customers_pallets(benchmark: Benchmark, most: int) -> list[str]:
    """Names of customers' pallets of the part that is judged, those of the first ranks."""
    cases = benchmark.select(PART)
    delivered = of_customers(cases["layout"], benchmark)
    centred = (cases["scenario"] == str(Scenario.S1)).to_numpy(bool)
    return [str(name) for name in cases["layout"][delivered & centred].head(most)]
