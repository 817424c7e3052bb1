"""Section of the page of Table 5 on the costs of errors."""

from __future__ import annotations

from steadyload.reports.pages.page import Picture, Section
from steadyload.reports.table import Column, Table, columns_for, compact, factor, percent, words
from steadyload.runs.evaluation import MethodEvaluation
from steadyload.statistics.error_costs import CheapestRange
from steadyload.statistics.estimate import Estimate
from steadyload.studies import method_sections as column
from steadyload.studies.table5.cost_figures import plot_error_costs
from steadyload.studies.table5.summary import ErrorCosts, JudgedSet

_RATIOS = (0.01, 0.1, 1.0, 10.0, 100.0)


def errors_and_costs(own: JudgedSet) -> Section:
    """Expected costs over the ratio of costs, and the cheapest method by ratio."""
    costs = own.error_costs
    rows = {m.method.spec: m for m in costs.methods}

    def percentage(name: str, title: str) -> Column:
        return Column(title, lambda each: getattr(rows[each.method], name), percent)

    cheapest = [
        Column("ratio from", lambda each: compact(each.least)),
        Column("to", lambda each: compact(each.most)),
        words("cheapest method", lambda each: costs.title(each.method)),
        Column("n", lambda each: rows[each.method].over.n),
        percentage("over", "overestimated %"),
        percentage("under_or_none", "underestimated or no verdict %"),
    ]
    methods = [
        column.METHOD,
        column.N,
        *columns_for(_RATIOS, "cost at {:g}", _cost, factor),
    ]
    return Section(
        "What errors cost",
        "An overestimation calls a layout safer than it is, and a pallet falls; an underestimation "
        "throws a good layout away. The *ratio* is the cost of the first over that of the second, "
        "and the expected cost a layout is the ratio times the share of overestimated cases, plus "
        "the share of those that are underestimated or without a verdict, in units of the cost of "
        "an underestimation. At a ratio of 1 it is the share of wrong cases. Whoever loads no "
        "layout at all pays at most 1. Intervals are put together from those of the two shares, "
        "taken as independent: they are rather too wide. That of a method which overestimates no "
        "case is widest, since so few item lists allow for many such cases on others.",
        [
            Table(costs.cheapest, cheapest, "Of all methods, by ratio:"),
            Table(costs.methods, methods, "The methods of the chart:"),
        ],
        [
            Picture(
                "error_costs",
                plot_error_costs(costs),
                "Expected cost of errors a layout over the ratio of the cost of an overestimation "
                "to that of an underestimation; good methods lie low. Methods on the front of "
                "accuracy and cost, and those that are the cheapest at some ratio. Bands are 95 % "
                "intervals; dotted lines part the ranges of the cheapest methods.",
            )
        ],
    )


def _cost(row: MethodEvaluation, ratio: float) -> Estimate | None:
    return None if row.errors is None else row.errors.cost(ratio)


def cheapest_in_words(costs: ErrorCosts) -> str:
    """The cheapest methods by ratio, in one sentence."""

    def said(each: CheapestRange) -> str:
        return f"{costs.title(each.method)} from {compact(each.least)} to {compact(each.most)}"

    return "; ".join(map(said, costs.cheapest)) + "."
