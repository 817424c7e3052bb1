"""Pallets to try the tool on: customers' orders of the labelled set of real size."""

from __future__ import annotations

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.parts import REAL, Part
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.question import Question
from steadyload.layouts.model.scenarios import Scenario


def demo_pallets(count: int = 12) -> list[Layout]:
    """Pallets of the test part, half of them labelled as standing.

    Args:
        count: of pallets, even.
    """
    real = load_benchmark(REAL)
    cases = real.select(Part.TEST, scenarios=(str(Scenario.S1),), question=Question.STANDS)
    stand = cases["failing_step"].isna()
    chosen = sorted([*cases[stand].index[: count // 2], *cases[~stand].index[: count // 2]])
    return [real.layout(cases.loc[k, "layout"], cases.loc[k, "scenario"]) for k in chosen]
