"""Sections of the page of Table 5 on the significance of differences of accuracy."""

from __future__ import annotations

from steadyload.methods.naming import MethodKey
from steadyload.reports.pages.page import Picture, Section
from steadyload.reports.table import Column, Table, columns_for, compact, percent, words
from steadyload.runs.comparison import PairTest
from steadyload.runs.evaluation import ALL
from steadyload.statistics.paired import LEVEL
from steadyload.studies.table5.figures import plot_differences
from steadyload.studies.table5.summary import JudgedSet

_N = Column("n")
_P = (Column("p", format=compact), Column("corrected p", "corrected", compact))


def significantly_different(own: JudgedSet) -> Section:
    """Section of the tests: all methods against the yardstick and the best one, and all pairs."""
    tests = own.tests[ALL]
    held = [m for m in dict.fromkeys([own.timing.yardstick, own.best.method]) if m is not None]
    order = sorted(own.evaluation.methods, key=lambda m: -m.accuracy.value)
    return Section(
        "Which methods are told apart",
        "Two methods are compared on the same cases. The test turns the signs of their "
        f"differences by item list, in all 2^{len(tests.sizes)} ways, and counts how often the sum "
        "is as far from 0 as the one found: a sign-flip test, exact, without a law for the "
        "differences. Cases of one list are alike, so McNemar's test, which takes every case for "
        "an observation, would find too much; a t test would ask for lists of like size, and these "
        f"hold {tests.sizes[-1]} to {tests.sizes[0]} cases. "
        "Of many differences some are large by chance, so *corrected* p-values are Holm's, over "
        "the family of tests that answer one question. The tables below ask which methods differ "
        f"from one: a family is the {len(order) - 1} others, each compared with it, on a group of "
        "cases (all, or a scenario). The figure and the *letters* above compare all methods with "
        f"one another: a family is all {len(tests.tests)} pairs of a group. Told apart "
        f"means corrected p below {LEVEL:g}. The smallest corrected p that so many lists and "
        f"all pairs can give is {compact(tests.least)}; "
        + (
            "no pair can be told apart here."
            if tests.least >= LEVEL
            else "that needs all lists on one side."
        )
        + " *Not told apart* is no proof of equality: see the intervals.",
        [_against(own, method) for method in held],
        [
            Picture(
                "differences",
                plot_differences(tests, [m.method for m in order]),
                "Accuracy of the row minus that of the column, in percentage points, n = "
                f"{own.about.cases} cases each. Coloured where the two are told apart among all "
                f"{len(tests.tests)} pairs; grey numbers are not.",
            )
        ],
    )


def _against(own: JudgedSet, held: MethodKey) -> Table:
    """A row a method: its difference to one of them."""
    found = {group: tests.versus(held) for group, tests in own.tests.items()}

    def brief(test: PairTest[MethodKey], group: str) -> str:
        here = found[group].of(test.first, held)
        return f"{round(100 * here.difference.value, 1) + 0.0:.1f} ({compact(here.corrected)})"

    rows = found[ALL].tests
    return Table(
        rows,
        [
            words("method", "first.title"),
            _N,
            Column("difference", format=percent),
            *_P,
            *columns_for(own.groups[1:], "{}", brief),
        ],
        f"Accuracy minus that of {held.title}, in percentage points; by scenario with the "
        f"corrected p in round brackets. Each column of p is a family of {len(rows)} tests:",
    )


def what_the_engine_changes(own: JudgedSet) -> Section:
    """Section on the same tuning on two engines."""
    rows = own.simulation_pairs(same_tuning=True)
    columns = [
        words("first", "first.title"),
        words("second", "second.title"),
        _N,
        Column("first minus second", "difference", percent),
        *_P,
    ]
    return Section(
        "What the engine changes",
        "The same parameters on two engines, in percentage points; corrected p over these "
        f"{len(rows)} pairs. `steadyload engines` says which of them an engine ignores or imitates."
        if rows
        else "No tuning was judged on two engines.",
        [Table(rows, columns)] if rows else [],
    )
