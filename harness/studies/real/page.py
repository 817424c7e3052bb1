"""The page of layouts of real size: accuracy and cost of all methods, by number of boxes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from steadyload.layouts.model.question import Question
from steadyload.reports.pages.page import Page, Picture, Section
from steadyload.reports.table import (
    MISSING,
    Column,
    Table,
    columns_for,
    counts,
    decimal,
    names,
    percent,
    plain_percent,
    significant,
    words,
)
from steadyload.studies.real.delivered import CUSTOMERS, DELIVERED, PACKERS
from steadyload.studies.real.figures import plot_accuracy, plot_cost
from steadyload.studies.real.further_sections import (
    floors_section,
    labels_section,
    no_verdict_section,
)
from steadyload.studies.real.summary import (
    NEAR,
    JudgingCost,
    MethodResult,
    RealSummary,
    SizeGroup,
)

_METHOD = words("method", "method.title")
_NO_VERDICT = Column("no verdict", "without_verdict", counts, notable=True)
_ASKED = {
    Question.WITHIN: "Does anything move too far within 0.3 s (the label of the paper)?",
    Question.STANDS: "Does the load stand once everything rests?",
}


def real_page(found: RealSummary) -> Page:
    """Compose the page."""
    sections = [
        _accuracies(found),
        _origins(found),
        _by_size(found),
        _cost(found),
        no_verdict_section(found),
        *([floors_section(found)] if found.floors else []),
        labels_section(found),
    ]
    return Page("Layouts of real size", _summary(found), sections, found.manifest)


def _summary(found: RealSummary) -> str:
    columns = [
        _METHOD,
        *(_accuracy(f"{question} %", question, "overall") for question in Question),
        _milliseconds("CPU ms, mean", "mean"),
        _milliseconds("median", "median"),
        _milliseconds("90 %", "ninety"),
        _NO_VERDICT,
    ]
    told = "\n\n".join(
        (
            _answer(found),
            f"All cases have {found.real.title} boxes. Shares of cases whose failing step is that "
            "of the label, for both questions (*within*: 0.3 s, *stands*: until all rests), with "
            "95 % intervals clustered by item list. Refused cases are left out; a case without a "
            "verdict for another reason counts as wrong. A judgement that took longer than "
            f"{found.timeout:g} s was given up and costs that much at least.",
            str(Table(found.real.methods, columns)),
        )
    )
    return told + _left_out(found)


def _answer(found: RealSummary) -> str:
    """Which method, how right, at what cost, who is as good, and what the easiest answer gives."""
    chosen, whole = found.chosen, found.real
    parts = [
        f"{result.method.title} for the question *{question}* ("
        f"{plain_percent(result.accuracy[question].overall.value)} % right, "
        f"{_of(result.cost, 'mean')} ms a layout on average, {_of(result.cost, 'median')} ms in "
        "the median)"
        for question, result in chosen.items()
    ]
    if not parts:
        return "No method judges most of these cases."
    right, failing = (
        ", ".join(
            f"{plain_percent(getattr(result.accuracy[question], what).value)} % ({question})"
            for question, result in of.items()
        )
        for what, of in (
            ("overall", dict.fromkeys(chosen, whole.methods[-1])),
            ("failing", chosen),
        )
    )
    return (
        f"On {whole.cases} cases of {whole.title} boxes ({whole.item_lists} item lists), the "
        f"cheapest method within {100 * NEAR:g} percentage point of the most accurate one is "
        f"{' and '.join(parts)}. {_no_winner(found)}"
        f"{_origins_in_words(found)}The constant verdict *stable* would be right on {right}; of "
        f"the loads that fail, these methods name the failing step on {failing}."
    )


def _no_winner(found: RealSummary) -> str:
    """Sentences on the methods that do not differ significantly from the most accurate one."""
    return "".join(
        f"For *{question}*, of {best.others} other methods compared with the most accurate one, "
        f"{best.method.title}, these do not differ from it significantly: "
        f"{names(key.title for key in best.alike)}. "
        for question, best in found.best.items()
        if best.others
    )


def _origins_in_words(found: RealSummary) -> str:
    """Sentence on the customers' pallets among the cases; empty without any."""
    by_title = {origin.title: origin for origin in found.origins}
    if not {CUSTOMERS, DELIVERED, PACKERS} <= set(by_title):
        return ""
    own, delivered = by_title[CUSTOMERS], by_title[DELIVERED]
    stand = {q: d.n - round(d.value * d.n) for q, d in delivered.failing.items() if d.n}
    shown = " and ".join(
        f"{count} of {delivered.failing[q].n} stand by the label *{q}*"
        for q, count in stand.items()
    )
    return (
        f"{own.cases} of the cases are customers' pallets ({own.layouts} pallets of "
        f"{own.item_lists} orders); as delivered, with centres of mass in the middle, {shown}. The "
        f"other {by_title[PACKERS].cases} cases are plans of packers for published item lists. "
    )


def _origins(found: RealSummary) -> Section:
    return Section(
        "Whose pallets these are",
        "Customers' pallets are orders as palletising software planned them. Where the centres of "
        "mass of their boxes are is not known: *as delivered* they are in the middle, and those "
        "off the middle are made up. The plans of packers are for published item lists; nobody "
        "loaded them.",
        [
            Table(
                found.origins,
                [
                    words("cases", "title"),
                    Column("n", "cases"),
                    Column("layouts"),
                    Column("item lists", "item_lists"),
                    *columns_for(Question, "fails {} %", "failing", percent),
                ],
            )
        ],
    )


def _left_out(found: RealSummary) -> str:
    if not found.left_out:
        return ""
    told = "; ".join(f"`{spec}`: {reason}" for spec, reason in found.left_out.items())
    return f"\n\nLeft out, since they cannot judge here: {told}."


def _accuracy(title: str, question: Question, what: str) -> Column:
    return Column(title, lambda row: getattr(row.accuracy[question], what), percent)


def _milliseconds(title: str, what: str) -> Column:
    return Column(title, lambda row: _of(row.cost, what))


def _of(cost: JudgingCost | None, what: str) -> str:
    return MISSING if cost is None else significant(getattr(cost, what))


def _accuracies(found: RealSummary) -> Section:
    def table(question: Question) -> Table:
        columns = [
            _METHOD,
            words("asked", lambda row: row.asked or "-"),
            Column("n", lambda row: row.accuracy[question].overall.n),
            _accuracy("accuracy %", question, "overall"),
            Column("failing n", lambda row: row.accuracy[question].failing.n),
            _accuracy("failing: accuracy %", question, "failing"),
            _accuracy("behind the best", question, "behind"),
        ]
        return Table(found.real.methods, columns, f"**{_ASKED[question]}**")

    return Section(
        "Both questions, and failing loads alone",
        "*Asked*: the question that a method is asked; all are compared with the labels of both. "
        "*Behind the best*: accuracy minus that of the most accurate method, on the same cases, in "
        "percentage points; here refused cases count as wrong. *Failing*: cases whose label is a "
        "failing step, on which the constant verdict is never right.",
        [table(question) for question in Question],
    )


def _by_size(found: RealSummary) -> Section:
    groups = found.groups
    small = (
        "The first bin holds small layouts, of the set of the package: half of these fail, so that "
        "their accuracies do not compare with those of the others. "
        if found.small
        else ""
    )
    sizes = [
        Column("boxes", "title"),
        Column("median", lambda group: f"{group.middle:g}"),
        Column("cases"),
        Column("item lists", "item_lists"),
        *columns_for(Question, "fails {} %", "failing", percent),
    ]

    def table(question: Question) -> Table:
        each = _each(groups, lambda result: percent(result.accuracy[question].overall))
        caption = f"**Accuracy in per cent, label {question}, by boxes**"
        return Table(found.real.methods, [_METHOD, *each], caption)

    return Section(
        "By number of boxes",
        f"{small}A bin of few item lists tells little: its intervals say how much.",
        [
            Table(groups, sizes),
            *(table(question) for question in Question),
        ],
        [
            Picture(
                "accuracy_by_boxes",
                plot_accuracy(groups),
                "Accuracy against boxes, by the labels of either question, of the methods that "
                "are asked it or have no such parameter; bars are 95 % intervals.",
            )
        ],
    )


def _each(groups: tuple[SizeGroup, ...], text: Callable[[MethodResult], str]) -> Iterator[Column]:
    """A column a group, of the result that the method of a row has there."""
    yield from columns_for(
        groups, lambda group: group.title, lambda row, group: text(group.of(row.method.spec))
    )


def _cost(found: RealSummary) -> Section:
    methods = [result for result in found.real.methods if result.method.spec in found.growth]

    def power(what: str) -> Callable[[Any], str]:
        return lambda row: decimal(getattr(found.growth[row.method.spec], what))

    columns = [
        _METHOD,
        *(_milliseconds(title, what) for title, what in (
            ("mean ms", "mean"), ("median ms", "median"), ("90 % ms", "ninety"),
            ("worst ms", "worst"))),
        Column("n", lambda row: found.growth[row.method.spec].real.n),
        Column("exponent, real size", power("real")),
        Column("n", lambda row: found.growth[row.method.spec].everything.n),
        Column("exponent, all", power("everything")),
    ]  # fmt: skip
    return Section(
        "Cost and its growth",
        f"{found.cost_source.explained()} There is no timing pass, since simulations of a "
        "hundred boxes take seconds each. Refused cases cost nothing and are left out. The "
        "*exponent* is that of the number of boxes in the CPU time, by least squares in log-log "
        "over the cases (n) that a method calls stable, which it judges to the end, clustered by "
        "item list; what was given up is missing there, so exponents of methods with timeouts are "
        "too small.",
        [
            Table(methods, columns),
            Table(
                methods,
                [_METHOD, *_each(found.groups, lambda result: _of(result.cost, "median"))],
                "**Median CPU time in ms, by boxes**",
            ),
        ],
        [
            Picture(
                "cost_by_boxes",
                plot_cost(found.groups, found.growth),
                "Median CPU time of a layout against boxes; the exponent over all sizes stands in "
                "the legend.",
            )
        ],
    )
