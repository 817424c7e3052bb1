"""The page of tuning: the parameters found for each engine, the searches, and the gain."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from steadyload.reports.pages.page import Page, Picture, Section
from steadyload.reports.table import (
    MISSING,
    Column,
    Table,
    columns_for,
    compact,
    general,
    names,
    percent,
    plain_percent,
    significant,
    words,
)
from steadyload.studies.tuning.change_sections import left_out, plausibility, transfer
from steadyload.studies.tuning.figures import plot_price
from steadyload.studies.tuning.knowledge_section import knowledge
from steadyload.studies.tuning.outcome_section import answer, came_out
from steadyload.studies.tuning.search_sections import algorithms, luck, searches
from steadyload.studies.tuning.summary import CostRow, GeneRow, PricePoint, Tuning

_GENES = (
    words("parameter", "name"),
    words("unit", lambda r: r.unit or MISSING),
    words("values"),
    Column("start"),
    Column("found"),
)
_CHOSEN = (
    words("engine"),
    Column("budget ms", "budget", general, left=True),
    words("parameters", "values"),
    Column("n", "test.accuracy.n"),
    Column("accuracy where chosen %", "validation", plain_percent),
)


def tuning_page(tuning: Tuning, manifest: Mapping[str, str]) -> Page:
    """Compose the page: a section for each part of the records that is not empty."""
    sections: list[Section] = []
    if tuning.tests:
        sections.append(came_out(tuning.tests))
    if tuning.knowledge:
        sections.append(knowledge(tuning.knowledge))
    if tuning.prices:
        sections.append(_prices(tuning))
    if tuning.parameters:
        sections.append(_found(tuning.parameters))
    if tuning.searches:
        sections.append(searches(tuning.searches))
        sections += algorithms(tuning.searches)
    if tuning.seeds:
        sections.append(luck(tuning.seeds))
    if tuning.left_out:
        sections.append(left_out(tuning.left_out))
    if tuning.plausibility:
        sections.append(plausibility(tuning.plausibility))
    sections += [transfer(table, k) for k, table in enumerate(tuning.transfer)]
    if tuning.costs:
        sections.append(_costs(tuning.costs))
    cases = "; ".join(
        f"{engine} {tuning.cases[engine]} of {_described(parts)}"
        for engine, parts in tuning.parts.items()
    )
    goals = ", ".join(f"{e} {significant(g)} ms" for e, g in tuning.goal.items())
    return Page(
        "Tuned simulations",
        f"{answer(tuning.tests)}The parameters of a simulation are searched, engine by engine, "
        "for the highest accuracy at a low cost. Searches judge a set of parameters, a "
        f"*genotype*, on cases of labelled sets, those that found the presets on {cases}; what is "
        "said of part `test` was not seen by a search. *Accuracy* is the share of cases on which a "
        "method names the label's failing step; *overestimated*: a later one, *underestimated*: "
        "an earlier one. *Cost* is the CPU time a layout that is modelled from what a simulation "
        "does, so that it does not depend on what else a machine was doing; *CPU* is measured. "
        f"{_source(tuning)}Being cheaper than 18.5 % of PS_3, or than a stated cost, is worth "
        f"nothing to a search{f': {goals}' if goals else ''}. Differences are in percentage "
        "points, on the same cases; brackets hold 95 % intervals.",
        sections,
        manifest,
    )


def _described(parts: Mapping[str | None, str]) -> str:
    """Parts and sets of the cases of a search."""
    return " and ".join(f"part `{part}` of {of or 'the large set'}" for of, part in parts.items())


def _source(tuning: Tuning) -> str:
    return f"{tuning.cost_source.explained()} " if tuning.cost_source else ""


def _prices(tuning: Tuning) -> Section:
    budgets = sorted({p.budget for p in tuning.prices})
    points = {(p.budget, p.engine): p for p in tuning.prices}
    matrix = Table(
        budgets,
        [
            Column("budget ms", lambda budget: budget, general, left=True),
            *columns_for(
                dict.fromkeys(p.engine for p in tuning.prices),
                "{}",
                lambda budget, engine: points.get((budget, engine)),
                _bought,
            ),
        ],
        "Accuracy % with its interval, then the measured CPU time:",
    )
    tables, bought = [matrix], [p for p in tuning.prices if p.test is not None]
    if bought:
        caption = "The parameters, and the number of cases they were tested on:"
        tables.append(Table(bought, _CHOSEN, caption))
    picture = Picture(
        "price",
        plot_price(tuning),
        "Accuracy against CPU time; good methods stand at the upper left. The axis of "
        "accuracy spreads the top. Steps are the fronts of all searches of an engine, at "
        "modelled cost and where the searches judged; points were measured on test, with "
        "95 % intervals; dotted lines are the budgets.",
    )
    return Section(
        "The price of accuracy",
        "\n".join(_best_buy(b, [p for p in tuning.prices if p.budget == b]) for b in budgets)
        + "\n\nA budget buys the most accurate of all parameter sets seen whose cost is below it; "
        "it was chosen where the searches judged, and then tested once on other cases. That cost "
        "is modelled, on the cases that the searches judged, which may be dearer than the cases of "
        "the test: a set above the budget there may be below it here. *Nothing*: no set is that "
        "cheap there.",
        tables,
        [picture],
    )


def _bought(point: PricePoint | None) -> str:
    if point is None:
        return MISSING
    if point.test is None:
        return "nothing"
    return f"{percent(point.test.accuracy)}, {significant(point.test.cpu.value)} ms"


def _best_buy(budget: float, points: Sequence[PricePoint]) -> str:
    bought = [(p.test.accuracy.value, p.engine, p.test) for p in points if p.test is not None]
    if not bought:
        return f"- {budget:g} ms a layout buys nothing on any engine."
    _, engine, test = max(bought, key=lambda b: b[:2])
    return (
        f"- {budget:g} ms a layout buys {percent(test.accuracy)} % on {engine}, at "
        f"{significant(test.cpu.value)} ms" + (", the most of all." if len(bought) > 1 else ".")
    )


def _found(parameters: Mapping[str, tuple[GeneRow, ...]]) -> Section:
    said = []
    for engine, rows in parameters.items():
        kept = [r.name for r in rows if r.start == r.found]
        said.append(
            f"- {engine}: {len(rows) - len(kept)} of {len(rows)} parameters left the value that a "
            f"search starts from" + (f"; {names(kept)} stayed." if kept else ".")
        )
    tables = [Table(rows, _GENES, f"**{engine}**") for engine, rows in parameters.items()]
    return Section("What was searched and found", "\n".join(said), tables)


def _costs(costs: Sequence[CostRow]) -> Section:
    columns = [
        words("engine"),
        Column("parameter sets", "parameter_sets"),
        Column("rank correlation", "correlation", "{:.3f}".format),
        Column("median error %", "error", plain_percent),
        *columns_for(
            dict.fromkeys(term for row in costs for term in row.terms),
            "{}",
            "terms",
            lambda microseconds: compact(microseconds, 3),
        ),
    ]
    worst = max(costs, key=lambda row: row.error)
    most = f"{plain_percent(worst.error)} % ({worst.engine})"
    return Section(
        "How cost is modelled",
        "A simulation counts what it does; each count costs an engine so many microseconds, fitted "
        "to measured CPU times of as many parameter sets as the table says. The median error is "
        + (f"at most {most}" if len(costs) > 1 else most)
        + ". *Rank correlation*: Spearman's, between modelled and measured times. The columns "
        "after the error are microseconds for each.",
        [Table(costs, columns)],
    )
