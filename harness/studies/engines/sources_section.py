"""Section of the page of engines: where the differences between verdicts come from."""

from __future__ import annotations

from collections.abc import Sequence

from steadyload.methods.tuned import tuned_engines
from steadyload.reports.pages.page import Picture, Section
from steadyload.reports.table import Column, Table, names, percent, plain_percent, words
from steadyload.statistics.variance import SourceShare
from steadyload.studies.engines.figures import plot_sources
from steadyload.studies.engines.sources import ANSWERS, SourceTable

_COLUMNS = (
    words("what differs", lambda share: " with ".join(share.factors)),
    Column("share of all differences %", "whole", percent),
    Column("the same on all cases %", "always", percent),
    Column("from case to case %", "by_case", percent),
)


def sources(tables: Sequence[SourceTable]) -> Section:
    """Section of the shares of engine, parameters and question in the differences of verdicts."""
    first = next(iter(ANSWERS))
    return Section(
        "Engine, parameters, question or luck: what verdicts differ by",
        "\n".join(_sentence(table) for table in tables if table.answer == first) + "\n\n"
        f"Each case is judged on every engine ({names(tuned_engines())}) with every parameter "
        "set and, where two are named, for both questions. The parameter sets ps3-literal and "
        "ps_opt-paper run for other times and have other thresholds than the label, so a part of "
        "what comes with the parameters is a difference of questions; ps_opt and label follow the "
        "label. The differences between the verdicts on "
        "one case are shared out among what differs between their methods (analysis of variance; "
        "the shares add up to 100 %). *The same on all cases*: one engine, say, lets more items "
        "stand than another, always. *From case to case*: which of the two lets more stand "
        "depends on the case, and cannot be told without judging it. *A with B*: how far the "
        "difference that A makes depends on B. Verdicts are taken as the share of items placed "
        "safely, and, for comparison, as stable or not. Intervals are of item lists drawn anew.",
        [Table(table.shares, list(_COLUMNS), _title(table)) for table in tables],
        [
            Picture(
                "sources",
                plot_sources([table for table in tables if table.answer == first]),
                "Shares in the differences between verdicts on the same case: dark, what is the "
                "same on all cases; light, what differs from case to case; bars: 95 % intervals.",
            )
        ],
    )


def _sentence(table: SourceTable) -> str:
    return (
        f"- {_about(table)}: {plain_percent(table.differing)} % of {table.cases} cases have "
        f"verdicts that differ. Of the differences {_shared_out(table)}."
    )


def leading_source(tables: Sequence[SourceTable]) -> str:
    """Sentence on what the differences between verdicts come with, for every choice of parameters.

    Of designs that ask several questions it says nothing, unless there are no others.
    """
    own = [table for table in tables if table.answer == next(iter(ANSWERS))]
    one_question = [table for table in own if len(table.design.questions) == 1]
    chosen = one_question or own[:1]
    among = "; ".join(
        f"among {names(table.design.parameters)} {_shared_out(table)} ({table.cases} cases of set "
        f"{table.design.labelled_set})"
        for table in chosen
    )
    said = f"Of the differences between verdicts on the same case, {among}."
    if len({_largest(table) for table in chosen}) > 1:
        said += (
            " So whether the engine or the parameters matter more depends on the parameter sets "
            "that are compared."
        )
    return said


def _largest(table: SourceTable) -> tuple[str, ...]:
    """The factor with which most of the differences come, alone."""
    single = [share for share in table.shares if len(share.factors) == 1]
    return max(single, key=lambda share: share.whole.value).factors


def _shared_out(table: SourceTable) -> str:
    """Shares of single factors, the largest first, and of their combination, or of all of them."""
    ordered = sorted(table.shares, key=lambda share: (len(share.factors), -share.whole.value))
    single = [
        f"{percent(share.whole)} % come with the {share.factors[0]} alone"
        for share in ordered
        if len(share.factors) == 1
    ]
    rest = ordered[len(single) :]
    if len(rest) > 1:
        return names(
            [*single, f"{plain_percent(sum(r.whole.value for r in rest))} % with combinations"]
        )
    return names([*single, *(_combined(share) for share in rest)])


def _combined(share: SourceShare) -> str:
    return f"{percent(share.whole)} % with the combination of {' and '.join(share.factors)}"


def _about(table: SourceTable) -> str:
    parameters = names(table.design.parameters)
    asked = names([str(question) for question in table.design.questions])
    many = "questions" if len(table.design.questions) > 1 else "question"
    return f"Set {table.design.labelled_set}, {parameters}, {many} {asked}"


def _title(table: SourceTable) -> str:
    left = f", {table.left_out} left out for want of a verdict" if table.left_out else ""
    return (
        f"**{_about(table)}; verdicts as {table.answer}** ({table.cases} cases of "
        f"{table.item_lists} item lists{left})"
    )
