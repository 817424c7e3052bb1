"""The page of Table 5: what was found, every method's accuracy and cost, and what stands behind."""

from __future__ import annotations

from steadyload.reports.charts import plot_matrix
from steadyload.reports.page import Page, Picture, Section
from steadyload.reports.table import (
    factor,
    markdown_table,
    milliseconds,
    names,
    percent,
)
from steadyload.runs.evaluation import ALL, MethodEvaluation
from steadyload.studies.table5.accuracy_sections import (
    accuracy_and_cost,
    noise_of_labels,
    planar_layouts,
    time_a_layout,
)
from steadyload.studies.table5.detail_sections import (
    beside_the_paper,
    by_size,
    to_watch,
    where_methods_err,
)
from steadyload.studies.table5.records import JudgedSet, Table5
from steadyload.studies.table5.test_sections import (
    best_of,
    simulation_pairs,
    told_apart,
    what_the_engine_changes,
)

NEAR = 0.01
"""A method counts as nearly as accurate as the best that is so close."""


def table5_page(found: Table5) -> Page:
    """Compose the page."""
    own, about = found.spatial, found.spatial.about
    planar = "" if found.planar is None else (
        f" Engines of two dimensions judge {found.planar.about.cases} planar cases instead, "
        "and all other methods beside them."
    )  # fmt: skip
    return Page(
        "Table 5 for every engine",
        f"{len(own.evaluation.methods)} methods on {about.cases} cases of part `{about.part}` of "
        f"the labelled set: {own.layouts} layouts, packed from {about.item_lists} item lists; "
        f"{about.stable} cases are stable. Nothing was tuned, trained or fitted on them. The "
        "paper's Table 5 has ten methods, one engine and 900 cases; labels are those of our own "
        f"reference, not of the paper's simulation.{planar}\n\n"
        "*Accuracy* is the share of cases on which a method names the label's failing step (Eq. 5 "
        "of the paper). Brackets hold 95 % intervals: Wilson's at the effective number of cases "
        "for shares, the bootstrap over item lists for differences, times and ratios. Layouts of "
        "one item list are alike, so all of them stand on item lists. A case without a verdict "
        "counts as wrong.",
        [
            _found(found),
            accuracy_and_cost(found),
            *([told_apart(own), what_the_engine_changes(own)] if own.tests[ALL].pairs else []),
            *([noise_of_labels(found)] if found.ceiling is not None else []),
            time_a_layout(own),
            beside_the_paper(found),
            by_size(own),
            where_methods_err(own),
            Section(
                "Which methods say the same",
                f"Share of equal failing steps, n = {about.cases} cases each.",
                [],
                [
                    Picture(
                        "agreement",
                        plot_matrix(
                            own.matrix.titles,
                            own.matrix.shares,
                            label="same failing step (%)",
                        ),
                        "Share of cases on which two methods name the same failing step. Two "
                        "methods may be equally accurate and say different things.",
                    )
                ],
            ),
            *([to_watch(own)] if own.watched else []),
            *([planar_layouts(found.planar)] if found.planar is not None else []),
        ],
        found.manifest,
    )


def _found(found: Table5) -> Section:
    own = found.spatial
    best, tests, cases = best_of(own), own.tests[ALL], str(own.about.cases)
    alike = [
        m.method.title
        for m in own.evaluation.methods
        if m is not best and tests.of(best.method, m.method).corrected >= tests.level
    ]
    rows = [
        (
            "Which method is the most accurate?",
            f"{best.method.title}: {percent(best.accuracy)} %. Not told apart from it: "
            f"{names(alike)}.",
            cases,
        ),
        *_cheap(own, best),
        *_spread(own),
    ]
    if found.ceiling is not None:
        widest = found.ceiling.by_group[ALL][-1]
        rows.append(
            (
                "How much do the labels allow?",
                "Two answers of the reference to the same question agree in "
                f"{percent(widest.twin)} % of cases, when {widest.name} change a little.",
                cases,
            )
        )
    same, pairs = found.same_order
    if pairs:
        rows.append(
            (
                "Do the paper's methods stand in the paper's order?",
                f"{same} of {pairs} pairs do (a simulation is the mean of its engines).",
                cases,
            )
        )
    return Section(
        "What was found", "", [markdown_table(("question", "answer", "n"), rows, left=2)]
    )


def _cheap(own: JudgedSet, best: MethodEvaluation) -> list[tuple[str, str, str]]:
    """What speed costs: the cheapest nearly as accurate method, and the front."""
    near = [
        m
        for m in own.evaluation.methods
        if m.accuracy.value >= best.accuracy.value - NEAR and m.cpu.n
    ]
    if not near:
        return []
    method = min(near, key=lambda m: m.cpu.value)
    share = own.timing.shares[ALL].get(method.method.spec)
    titles = {m.method.spec: m.method.title for m in own.evaluation.methods}
    ratio = "" if share is None or own.timing.yardstick is None else (
        f", {factor(share)} of {own.timing.yardstick.title}"
    )  # fmt: skip
    timed = str(own.timing.layouts)
    return [
        (
            f"What is the cheapest method within {100 * NEAR:g} point of it?",
            f"{method.method.title}: {percent(method.accuracy)} %, {milliseconds(method.cpu)} ms "
            f"of CPU time a layout{ratio}.",
            timed,
        ),
        (
            "Which methods are the best for their cost?",
            f"By rising cost: {names(titles[spec] for spec in own.fronts[ALL].specs)}.",
            timed,
        ),
    ]


def _spread(own: JudgedSet) -> list[tuple[str, str, str]]:
    """What the engine changes, and what the tuning does."""
    rows, cases = [], str(own.about.cases)
    for question, pairs in (
        ("Does the engine matter, with one tuning?", simulation_pairs(own, same_tuning=True)),
        ("Does the tuning matter, on one engine?", simulation_pairs(own, same_tuning=False)),
    ):
        if pairs:
            largest = max(pairs, key=lambda t: abs(t.difference.value))
            apart = sum(t.corrected < own.tests[ALL].level for t in pairs)
            rows.append(
                (
                    question,
                    f"{apart} of {len(pairs)} pairs are told apart. The largest difference: "
                    f"{largest.first.title} minus {largest.second.title}, "
                    f"{percent(largest.difference)} points.",
                    cases,
                )
            )
    return rows
