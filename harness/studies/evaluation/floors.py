"""Customers' pallets on several floors: what the deck's edge and small gaps change."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import pandas as pd

from steadyload.atomic import without_link
from steadyload.layouts.benchmark import Benchmark
from steadyload.layouts.benchmark.real import PALLET_SOFTWARE
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.floor import FloorKind
from steadyload.layouts.model.scenarios import Scenario
from steadyload.reports.columns import column, percent, row
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.evaluation import evaluate
from steadyload.runs.judged import load_judged
from steadyload.statistics.estimate import Estimate
from steadyload.studies.evaluation.judging import LIMITED_SHARD_SIZE, PART, Options, run
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


@row
class FloorRow:
    """Pallets on one floor, by the title of the method.

    ``stable``: share that it calls stable. ``changed``: those whose failing step is not that on the
    first floor; a case without a verdict on either has changed.
    """

    floor: str = column()
    pallets: int
    stable: Mapping[str, Estimate] = column("{}: stable %", percent)
    changed: Mapping[str, int] = column("{}: changed")


def floor_rows(lab: Lab, asked: Options, benchmark: Benchmark) -> tuple[FloorRow, ...]:
    """A row a floor; the first one is the floor as delivered.

    Empty where there are no customers' pallets, or no method judges them on floors.

    Raises:
        ResultsError: see :func:`steadyload.runs.judged.load_judged`.
        as :func:`steadyload.runs.runner.run_study`.
    """
    methods = tuple(spec for spec in asked.spatial if spec in FLOOR_METHODS)
    chosen = _customers_pallets(benchmark, asked.pallets) if methods and asked.pallets else []
    if not chosen:
        return ()
    file = lab.work.resolve() / "pallets.json"
    delivered = [benchmark.layout(name, str(Scenario.S1)) for name in chosen]
    write_layouts(without_link(file), delivered, Format.NATIVE)
    rows: list[FloorRow] = []
    first: pd.DataFrame | None = None
    lists = benchmark.layouts["instance"]
    for number, (words, (floor, gap)) in enumerate(FLOORS.items()):
        definition = StudyDefinition(
            f"real floor {number}", methods, files=(file,), floor=floor, snap_gap=gap,
            timeout=asked.timeout, shard_size=LIMITED_SHARD_SIZE,
        )  # fmt: skip
        run(lab, definition, f"floor-{number}")
        found = load_judged(lab.work / f"floor-{number}")
        names = found.said.index.get_level_values("layout")
        clusters = pd.Series(lists.loc[names].to_numpy(), found.said.index)
        found = dataclasses.replace(found, clusters=clusters)
        first = found.said if first is None else first
        same = (found.said == first.loc[found.said.index]).fillna(False)
        rows.append(
            FloorRow(
                floor=words,
                pallets=len(found.said),
                stable={
                    own.method.title: own.fully_stable
                    for own in evaluate(found, by_scenario=False).methods
                },
                changed={key.title: int((~same[spec]).sum()) for spec, key in found.keys.items()},
            )
        )
    return tuple(rows)


def _customers_pallets(benchmark: Benchmark, most: int) -> list[str]:
    """Names of customers' pallets of the part that is judged, those of the first ranks."""
    cases = benchmark.select(PART)
    sources: pd.Series = benchmark.layouts["sources"].loc[cases["layout"]]
    delivered = sources.map(lambda names: PALLET_SOFTWARE in names).to_numpy(bool)
    centred = (cases["scenario"] == str(Scenario.S1)).to_numpy(bool)
    return [str(name) for name in cases["layout"][delivered & centred].head(most)]
