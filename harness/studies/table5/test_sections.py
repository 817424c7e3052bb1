"""Sections of the page of Table 5 on what a difference of accuracy is worth."""

from __future__ import annotations

from steadyload.methods.naming import MethodKey
from steadyload.reports.page import Picture, Section
from steadyload.reports.table import compact, markdown_table, percent
from steadyload.runs.evaluation import ALL, MethodEvaluation
from steadyload.studies.table5.figures import plot_differences
from steadyload.studies.table5.records import JudgedSet, PairTest


def best_of(judged: JudgedSet) -> MethodEvaluation:
    """The most accurate method."""
    return max(judged.evaluation.methods, key=lambda m: m.accuracy.value)


def told_apart(own: JudgedSet) -> Section:
    """The test, all methods against the yardstick and the best one, and all pairs."""
    tests = own.tests[ALL]
    best = best_of(own)
    yard = own.timing.yardstick
    held = [m for m in dict.fromkeys([yard, best.method]) if m is not None]
    order = [
        m.method for m in sorted(own.evaluation.methods, key=lambda m: -m.accuracy.value)
    ]  # fmt: skip
    return Section(
        "Which methods are told apart",
        "Two methods are compared on the same cases. The test turns the signs of their "
        f"differences by item list, in all 2^{len(tests.sizes)} ways, and counts how often the sum "
        "is as far from 0 as the one found: a sign-flip test, exact, without a law for the "
        "differences. Cases of one list are alike, so McNemar's test, which takes every case for "
        "an observation, would find too much; a t test would ask for lists of like size, and these "
        f"hold {tests.sizes[-1]} to {tests.sizes[0]} cases. "
        f"With {len(tests.pairs)} pairs some differences look large by chance: *corrected* "
        "p-values are Holm's, over all pairs of a group (all cases, or a scenario). Told apart "
        f"means corrected p below {tests.level:g}. The smallest corrected p that so many lists and "
        f"pairs can give is {compact(tests.least)}; "
        + (
            "no pair can be told apart here."
            if tests.least >= tests.level
            else "that needs all lists on one side."
        )
        + " *Not told apart* is no proof of equality: see the intervals.",
        [_against(own, method) for method in held],
        [
            Picture(
                "differences",
                plot_differences(tests, order),
                "Accuracy of the row minus that of the column, in percentage points, n = "
                f"{own.about.cases} cases each. Coloured where the two are told apart; grey "
                "numbers are not.",
            )
        ],
    )


def _against(own: JudgedSet, yardstick: MethodKey) -> str:
    header = ("method", "n", "difference", "p", "corrected p", *(g for g in own.groups[1:]))
    rows = []
    for row in own.evaluation.methods:
        if row.method == yardstick:
            continue
        test = own.tests[ALL].of(row.method, yardstick)
        rows.append(
            (
                row.method.title,
                str(test.difference.n),
                percent(test.difference),
                compact(test.p),
                compact(test.corrected),
                *(_brief(own, group, row.method, yardstick) for group in own.groups[1:]),
            )
        )
    return (
        f"Accuracy minus that of {yardstick.title}, in percentage points; by scenario with the "
        f"corrected p in round brackets:\n\n{markdown_table(header, rows)}"
    )


def _brief(own: JudgedSet, group: str, first: MethodKey, second: MethodKey) -> str:
    test = own.tests[group].of(first, second)
    return f"{round(100 * test.difference.value, 1) + 0.0:.1f} ({compact(test.corrected)})"


def what_the_engine_changes(own: JudgedSet) -> Section:
    """The same tuning on two engines."""
    tests = simulation_pairs(own, same_tuning=True)
    rows = [
        (
            test.first.title,
            test.second.title,
            str(test.difference.n),
            percent(test.difference),
            compact(test.p),
            compact(test.corrected),
        )
        for test in tests
    ]
    header = ("first", "second", "n", "first minus second", "p", "corrected p")
    return Section(
        "What the engine changes",
        "The same parameters on two engines, in percentage points. `steadyload engines` says which "
        "of them an engine ignores or imitates."
        if rows
        else "No tuning was judged on two engines.",
        [markdown_table(header, rows, left=2)] if rows else [],
    )


def simulation_pairs(own: JudgedSet, *, same_tuning: bool) -> list[PairTest]:
    """Pairs of simulations with one tuning on two engines, or two tunings on one engine."""
    of = own.tunings
    return [
        test
        for test in own.tests[ALL].pairs
        if test.first.spec in of
        and test.second.spec in of
        and (of[test.first.spec] == of[test.second.spec]) == same_tuning
        and (test.first.engine == test.second.engine) != same_tuning
    ]
