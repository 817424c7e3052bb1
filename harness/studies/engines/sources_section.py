"""Section of the page of engines: where the differences between verdicts come from."""

from __future__ import annotations

from collections.abc import Sequence

from steadyload.methods.tuned import tuned_engines
from steadyload.reports.page import Picture, Section
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
        "set and, where two are named, for both questions. The differences between the verdicts on "
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
    single = [share for share in table.shares if len(share.factors) == 1]
    ordered = sorted(single, key=lambda share: -share.whole.value)
    return (
        f"- {_about(table)}: {plain_percent(table.differing)} % of {table.cases} cases have "
        f"verdicts that differ. Of the differences {names([_share(share) for share in ordered])}."
    )


def leading_source(tables: Sequence[SourceTable]) -> str:
    """Sentence on what most of the differences between verdicts come with, by the first table."""
    table = tables[0]
    single = [share for share in table.shares if len(share.factors) == 1]
    first = max(single, key=lambda share: share.whole.value)
    engine = next(share for share in single if share.factors == ("engine",))
    rest = "" if first is engine else f", and {_share(engine)}"
    return (
        f"Of the differences between verdicts on the same case {_share(first)}{rest} "
        f"({table.cases} cases of set {table.design.labelled_set})."
    )


def _share(share: SourceShare) -> str:
    return f"{percent(share.whole)} % come with the {share.factors[0]}"


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
