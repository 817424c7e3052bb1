"""The page of Table 5: findings, every method's accuracy and cost, and details."""

from __future__ import annotations

from pathlib import Path

from steadyload.layouts.model.question import Question
from steadyload.reports.pages.composing import composed
from steadyload.reports.pages.page import Page, Section
from steadyload.reports.table import counts, factor, markdown_table, milliseconds, names, percent
from steadyload.runs.evaluation import ALL, MethodEvaluation, cheapest_near
from steadyload.studies.agreement_section import agreement_picture
from steadyload.studies.method_sections import best_in_words
from steadyload.studies.table5.accuracy_sections import (
    accuracy_and_cost,
    by_class,
    noise_of_labels,
    planar_layouts,
    time_a_layout,
)
from steadyload.studies.table5.cost_sections import cheapest_in_words, errors_and_costs
from steadyload.studies.table5.detail_sections import (
    beside_the_paper,
    by_size,
    to_watch,
    where_methods_err,
)
from steadyload.studies.table5.summary import JudgedSet, Table5
from steadyload.studies.table5.test_sections import significantly_different, what_the_engine_changes

NEAR = 0.01
"""Largest difference to the best accuracy at which a method counts as nearly as accurate."""

_TITLES = {
    Question.WITHIN: "Table 5 for every engine",
    Question.STANDS: "Table 5, where a load has to stand",
}
_ASKED = {
    Question.WITHIN: (
        "The question is the paper's, `within`: has anything moved too far within 0.3 s? The "
        "paper's Table 5 has ten methods, one engine and 900 cases; labels are those of our own "
        "reference, not of the paper's simulation."
    ),
    Question.STANDS: (
        "The question is `stands`: does anything move too far until everything rests, within 3 s? "
        "The paper asks another, of 0.3 s, so its figures do not stand here. Methods whose name "
        "says `question=stands` are asked this one; all others judge as they do for the paper's."
    ),
}

Finding = tuple[str, str, str]
"""A question, its answer, and the number of cases that it stands on."""


def table5_page(found: Table5) -> Page:
    """Compose the page."""
    own, ceiling, planar = found.spatial, found.ceiling, found.planar
    tested = own.tests[ALL].tests
    same = Section(
        "Which methods say the same",
        f"Share of equal failing steps, n = {own.about.cases} cases each.",
        [],
        [
            agreement_picture(
                own.matrix, "Two methods may be equally accurate and say different things."
            )
        ],
    )
    rules = _under_rules(found)
    sections = [
        _found(found, rules),
        accuracy_and_cost(found),
        *([by_class(own)] if own.classes else []),
        *rules.sections,
        errors_and_costs(own),
        *([significantly_different(own), what_the_engine_changes(own)] if tested else []),
        *([noise_of_labels(own, ceiling)] if ceiling is not None else []),
        time_a_layout(own),
        *([] if found.paper is None else [beside_the_paper(own, found.paper)]),
        by_size(own),
        where_methods_err(own),
        same,
        *([to_watch(own)] if own.watched else []),
        *([planar_layouts(planar)] if planar is not None else []),
    ]
    return Page(_TITLES[found.question], _summary(found), sections, found.manifest)


def _summary(found: Table5) -> str:
    own, about = found.spatial, found.spatial.about
    planar = "" if found.planar is None else (
        f" Engines of two dimensions judge {found.planar.about.cases} planar cases instead, "
        "and all other methods beside them."
    )  # fmt: skip
    return (
        f"{best_in_words(own.evaluation.methods, NEAR)}"
        f"{len(own.evaluation.methods)} methods on {about.cases} cases of part "
        f"`{about.part}` of the labelled set: {own.layouts} layouts, packed from "
        f"{about.item_lists} item lists; {about.stable} cases are stable. "
        "Nothing was tuned, trained or fitted on them. "
        f"{_ASKED[found.question]}{_without(own)}{planar}\n\n"
        "*Accuracy* is the share of cases on which a method names the label's failing step (Eq. 5 "
        "of the paper). Brackets hold 95 % intervals: Wilson's at the effective number of cases "
        "for shares, the bootstrap over item lists for differences, times and ratios. Layouts of "
        "one item list are alike, so all of them stand on item lists. A case without a verdict "
        "counts as wrong."
    )


def _without(own: JudgedSet) -> str:
    """A sentence on the cases that were judged and have no label; empty where all have one."""
    if not own.without_label:
        return ""
    return f" Without a label of this question, and not counted: {counts(own.without_label)}."


def _found(found: Table5, rules: Page) -> Section:
    own = found.spatial
    rows = [
        _best(own), *_cheap(own), *_by_class(own), *_rules(found, rules), _errors(own),
        *_spread(own), *_labels(found), *_order(found),
    ]  # fmt: skip
    table = markdown_table(("question", "answer", "n"), rows, left=2)
    return Section("What was found", "", [table])


def _best(own: JudgedSet) -> Finding:
    others = own.tests[ALL].versus(own.best.method).tests
    alike = [test.first.title for test in others if not test.significant]
    tested = (
        f" Of {len(others)} others, each compared with it, these are not significantly different: "
        f"{names(alike)}."
        if others
        else ""
    )
    return (
        "Which method is the most accurate?",
        f"{own.best.method.title}: {percent(own.best.accuracy)} %.{tested}",
        str(own.about.cases),
    )


def _cheap(own: JudgedSet) -> list[Finding]:
    """Findings on the accuracy lost to speed: the cheapest nearly as accurate method, the front."""
    method = cheapest_near(own.evaluation.methods, NEAR)
    if method is None:
        return []
    share, yard = own.timing.shares[ALL].get(method.method.spec), own.timing.yardstick
    ratio = "" if share is None or yard is None else f", {factor(share)} of {yard.title}"
    front = names(own.evaluation.row(spec).method.title for spec in own.fronts[ALL])
    timed = str(own.timing.layouts)
    return [
        (
            f"What is the cheapest method within {100 * NEAR:g} point of it?",
            f"{method.method.title}: {percent(method.accuracy)} %, {milliseconds(method.cpu)} ms "
            f"of CPU time a layout{ratio}.",
            timed,
        ),
        ("Which methods are the best for their cost?", f"By rising cost: {front}.", timed),
    ]


def _by_class(own: JudgedSet) -> list[Finding]:
    """The finding on what accuracies hang on besides methods: the mix of classes of items."""
    if not own.classes:
        return []

    def ends(row: MethodEvaluation) -> tuple[float, float]:
        found = [bin_.accuracy[row.method.spec].value for bin_ in own.classes]
        return min(found), max(found)

    front = set(own.fronts[ALL]) or {own.best.method.spec}
    rows = [row for row in own.evaluation.methods if row.method.spec in front]
    widest = max(rows, key=lambda row: ends(row)[1] - ends(row)[0])
    classes = names(f"{bin_.name}" for bin_ in own.classes)

    def by(row: MethodEvaluation) -> str:
        found = (percent(bin_.accuracy[row.method.spec]) for bin_ in own.classes)
        return f"{row.method.title} {' / '.join(found)} %"

    shown = dict.fromkeys(by(row) for row in (own.best, widest))
    return [
        (
            "How much do figures hang on the mix of items?",
            f"On classes {classes}: {'; '.join(shown)}. A set of another mix gives other figures.",
            " / ".join(str(bin_.cases) for bin_ in own.classes),
        )
    ]


def _spread(own: JudgedSet) -> list[Finding]:
    """Findings on the effect of the engine, and of the tuning."""
    rows = []
    for question, pairs in (
        ("Does the engine matter, with one tuning?", own.simulation_pairs(same_tuning=True)),
        ("Does the tuning matter, on one engine?", own.simulation_pairs(same_tuning=False)),
    ):
        if pairs:
            largest = max(pairs, key=lambda t: abs(t.difference.value))
            apart = sum(test.significant for test in pairs)
            answer = (
                f"{apart} of {len(pairs)} pairs, taken as one family of tests, differ "
                "significantly. The largest difference: "
                f"{largest.first.title} minus {largest.second.title}, "
                f"{percent(largest.difference)} points."
            )
            rows.append((question, answer, str(own.about.cases)))
    return rows


def _errors(own: JudgedSet) -> Finding:
    return (
        "Whose errors cost least, by the ratio of the cost of an overestimation to that of an "
        "underestimation?",
        cheapest_in_words(own.error_costs),
        str(own.about.cases),
    )


def _labels(found: Table5) -> list[Finding]:
    if found.ceiling is None:
        return []
    widest = found.ceiling.by_group[ALL][-1]
    answer = (
        "Two answers of the reference to the same question agree in "
        f"{percent(widest.twin)} % of cases, when {widest.name} change a little."
    )
    return [("How much do the labels allow?", answer, str(found.spatial.about.cases))]


def _rules(found: Table5, rules: Page) -> list[Finding]:
    if found.rules is None:
        return []
    question = "Which conclusions survive other rules for the label?"
    return [(question, rules.summary, str(found.rules.cases))]


def _under_rules(found: Table5) -> Page:
    """Conclusions under other rules, and the section of ranks; empty where these were not asked."""
    if found.rules is None:
        return Page("", "", [], {})
    return composed(Path(__file__).with_name("rules.md.j2"), {"found": found.rules}, {})


def _order(found: Table5) -> list[Finding]:
    same, pairs = found.same_order
    question = "Do the paper's methods stand in the paper's order?"
    answer = (
        f"{same} of {pairs} pairs do, like with like: PS_3 and PS_5 in the literal reading, PS_opt "
        "with the paper's values, no network. A simulation is the mean of its engines."
    )
    return [(question, answer, str(found.spatial.about.cases))] if pairs else []
