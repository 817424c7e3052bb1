"""The part of a study's page that holds methods against labels."""

from __future__ import annotations

from collections.abc import Sequence

from steadyload.reports.charts import CostPoint, plot_cost_accuracy
from steadyload.reports.page import Picture, Section
from steadyload.reports.table import markdown_table, milliseconds, names, percent
from steadyload.runs.evaluation import ALL, Evaluation, MethodEvaluation

LABELS_EXPLAINED = (
    "A *label* is the failing step that the labelled set keeps for a case, found once by the "
    "reference simulator; *accuracy* is the share of cases on which a method names the same one."
)


def accuracy_sections(found: Evaluation) -> list[Section]:
    """Accuracy against cost, and what the most accurate method is ahead by."""
    sections = [_accuracy(found)]
    if len(found.methods) > 1:
        sections.append(_differences(found))
    return sections


def _accuracy(found: Evaluation) -> Section:
    about = found.labelled
    assert about is not None, "the run is on a labelled set"
    tables = [
        _table(found.rows[group])
        if group == ALL
        else f"**Scenario {group}**\n\n{_table(found.rows[group])}"
        for group in found.groups
    ]
    natural = ", ".join(f"{s} {100 * share:.1f} %" for s, share in about.natural_stable.items())
    return Section(
        "Accuracy and cost",
        f"Part `{about.part}` of the labelled set: {about.cases} cases, of which {about.stable} "
        f"are stable, {about.robust} have a robust label and {about.fragile} a fragile one. All "
        "cases first, then each scenario by itself.\n\n"
        "*Overestimated*: the method lets the loading fail later than the label does, or not at "
        "all; *underestimated*: earlier. *Stable or not*: both say that the whole layout is "
        "stable, or both that it is not. *Within one*: the numbers of items placed safely differ "
        "by at most one. A label is *robust* when every judge of the ensemble that was asked again "
        "names the same step, and *fragile* when one does not. *Natural prevalence*: accuracy on "
        "stable and on unstable cases, weighted by scenario with the share of stable layouts in "
        f"the whole set ({natural}). A case without a verdict counts as wrong in every accuracy, "
        "and as neither over- nor underestimated. Intervals stand on the "
        f"{about.item_lists} item lists. {found.cost_source.explained()}",
        tables,
        [
            Picture(
                "accuracy",
                plot_cost_accuracy(
                    [CostPoint(m.method, m.accuracy, m.cpu) for m in found.methods],
                ),
                "Accuracy against CPU time; good methods stand at the upper left. Colour tells "
                "the method, marker tells the engine, hollow markers have parameters of their own, "
                "bars are 95 % intervals; equal methods hide each other.",
            )
        ],
    )


def _table(methods: Sequence[MethodEvaluation]) -> str:
    header = (
        "method",
        "n",
        "accuracy %",
        "overestimated %",
        "underestimated %",
        "stable or not %",
        "within one %",
        f"robust % (n {methods[0].robust.n})",
        f"fragile % (n {methods[0].fragile.n})",
        "natural prevalence %",
        "CPU ms",
        "wall ms",
        "no verdict",
    )
    return markdown_table(
        header,
        [
            (
                m.method.title,
                str(m.accuracy.n),
                *(
                    percent(share)
                    for share in (
                        m.accuracy,
                        m.over,
                        m.under,
                        m.stable_or_not,
                        m.within_one,
                        m.robust,
                        m.fragile,
                        m.natural,
                    )
                ),
                milliseconds(m.cpu),
                milliseconds(m.wall),
                names(f"{count} {status}" for status, count in m.without_verdict.items()),
            )
            for m in methods
        ],
    )


def _differences(found: Evaluation) -> Section:
    best = next(m for m in found.methods if m.behind is None)
    rows = [
        (m.method.title, str(m.behind.n), percent(m.behind))
        for m in found.methods
        if m.behind is not None
    ]
    return Section(
        "Behind the most accurate method",
        f"Accuracy minus that of {best.method.title}, on the same cases, in percentage points. "
        "An interval that holds 0 tells no difference.",
        [markdown_table(("method", "n", "difference"), rows)],
    )
