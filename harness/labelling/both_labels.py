"""Labels of both questions beside each other: where they differ, and which way."""

from __future__ import annotations

import pandas as pd

from steadyload.layouts.benchmark.dataset import KEYS, Benchmark
from steadyload.layouts.benchmark.parts import SPLITS
from steadyload.layouts.model.question import Question
from steadyload.layouts.model.scenarios import Scenario
from steadyload.reports.columns import column, percent, row
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share
from steadyload.statistics.placed import items_placed_by_case

_ALL = "all"


@row
class QuestionShares:
    """Cases of a split and scenario that have labels of both questions; shares are of these.

    ``earlier``, ``later``: than by the label of ``within``.
    """

    split: str = column()
    scenario: str = column(about="or all")
    cases: int = column(about="labelled for the question stands")
    unsettled: int = column(about="cases in which something still moves after 3 s")
    failed: int = column("no label", about="for another reason")
    within: Estimate = column("stable within 0.3 s %", percent)
    stands: Estimate = column("stands %", percent)
    same: Estimate = column("same step %", percent)
    earlier: Estimate = column("falls earlier %", percent)
    later: Estimate = column("falls later %", percent)


def question_shares(benchmark: Benchmark) -> list[QuestionShares]:
    """A row a split and scenario of the cases that have labels of both questions."""
    columns = ["split", "instance", "item_count", "failing_step"]
    cases = benchmark.cases.set_index(KEYS)[columns].rename(columns={"failing_step": "within"})
    stands = benchmark.labels_on(Question.STANDS).set_index(KEYS)[["status", "failing_step"]]
    both = stands.join(cases)
    found = []
    for split in SPLITS:
        own = both[both["split"] == split]
        scenarios = own.index.get_level_values("scenario")
        for scenario in [_ALL, *map(str, Scenario)]:
            part = own if scenario == _ALL else own[scenarios == scenario]
            if len(part):
                found.append(_shares(split, scenario, part))
    return found


def _shares(split: str, scenario: str, part: pd.DataFrame) -> QuestionShares:
    statuses = part["status"].value_counts()
    unsettled = int(statuses.get("unsettled", 0))
    done = part[part["status"] == "done"]
    count, lists = done["item_count"].astype(int), done["instance"]
    within = items_placed_by_case(done["within"], count)
    stands = items_placed_by_case(done["failing_step"], count)
    return QuestionShares(
        split=split,
        scenario=scenario,
        cases=len(part),
        unsettled=unsettled,
        failed=len(part) - len(done) - unsettled,
        within=share(within == count, lists),
        stands=share(stands == count, lists),
        same=share(within == stands, lists),
        earlier=share(stands < within, lists),
        later=share(stands > within, lists),
    )
