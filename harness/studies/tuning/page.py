"""The page of tuning: what was found for each engine, how, and what it is worth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from steadyload.reports.page import Page, Picture, Section
from steadyload.reports.table import (
    MISSING,
    compact,
    factor,
    markdown_table,
    milliseconds,
    names,
    percent,
    significant,
)
from steadyload.runs.evaluation import MethodEvaluation
from steadyload.studies.tuning.change_sections import left_out, plausibility, transfer
from steadyload.studies.tuning.figures import plot_price
from steadyload.studies.tuning.records import (
    CostRow,
    GeneRow,
    PricePoint,
    TunedTable,
    Tuning,
)
from steadyload.studies.tuning.search_sections import algorithms, luck, searches

_HELD_AGAINST = {"ps3": "PS_3", "ps5": "PS_5"}
"""Families that a tuned method is to beat."""

_DEAR = "ps3"
"""The family of which a tuned method may cost a share."""

_START = "label"
"""The family of what a search begins with."""

_AS_LABELS = {"t_max=0.3", "eps_t=10", "eps_r=10", "between_steps=reseat", "criterion=adams"}
"""What a simulation is told that asks the question of the labels."""

_SHARE_OF_COST = 0.2
_ACCURATE = 0.98


def tuning_page(tuning: Tuning, manifest: Mapping[str, str]) -> Page:
    """Compose the page: a section for each part of the records that is not empty."""
    sections: list[Section] = []
    if tuning.tests:
        sections.append(_came_out(tuning.tests))
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
    goals = ", ".join(f"{e} {significant(g)} ms" for e, g in tuning.goal.items())
    return Page(
        "Tuned simulations",
        "The parameters of a simulation are searched, engine by engine, for the highest accuracy "
        "at a low cost. Searches judge a set of parameters, a *genotype*, on "
        f"part `{tuning.part}` of the labelled set, {tuning.cases} cases; what is said of other "
        "parts was not seen by a search. *Accuracy* is the share of cases on which a method names "
        "the label's failing step; *overestimated*: a later one, *underestimated*: an earlier one. "
        "*Cost* is the CPU time a layout that is modelled from what a simulation does, so that it "
        "does not depend on what else a machine was doing; *CPU* is measured. "
        f"{_source(tuning)}Being cheaper than "
        f"18.5 % of PS_3 is worth nothing to a search{f': {goals}' if goals else ''}. "
        "Differences are in percentage points, on the same cases; brackets hold 95 % intervals.",
        sections,
        manifest,
    )


def _source(tuning: Tuning) -> str:
    return f"{tuning.cost_source.explained()} " if tuning.cost_source else ""


@dataclass(frozen=True, slots=True)
class _Bar:
    """What a tuned method is to reach, and whether it does."""

    title: str
    met: bool
    said: str


def _bars(table: TunedTable) -> list[_Bar]:
    """Only those that the record can answer."""
    bars = [
        _Bar(
            f"beats {_HELD_AGAINST[other.method.family]}",
            other.ahead.low > 0.0,
            f"{percent(other.ahead)} points",
        )
        for other in table.others
        if other.method.family in _HELD_AGAINST and other.ahead is not None
    ]
    ratios = [
        other.cost_ratio
        for other in table.others
        if other.method.family == _DEAR and other.cost_ratio is not None
    ]
    bars += [
        _Bar(
            "costs at most a fifth of PS_3's CPU time",
            ratio.value <= _SHARE_OF_COST,
            f"{factor(ratio)} of it{_unsure(ratio.low, _SHARE_OF_COST, ratio.high)}",
        )
        for ratio in ratios
    ]
    accuracy = table.tuned.accuracy
    bars.append(
        _Bar(
            f"accuracy of at least {100 * _ACCURATE:g} %",
            accuracy.value >= _ACCURATE,
            f"{percent(accuracy)} %{_unsure(accuracy.low, _ACCURATE, accuracy.high)}",
        )
    )
    return bars


def _unsure(low: float, bar: float, high: float) -> str:
    return ", the interval holds the bar" if low < bar < high else ""


def _came_out(tests: Sequence[TunedTable]) -> Section:
    parts = list(dict.fromkeys(t.part for t in tests))
    said, tables = [], []
    for part in parts:
        mine = [t for t in tests if t.part == part]
        said.append(_verdict(part, mine))
        said.append("\n".join(_sentence(t) for t in mine))
        said += _begun(mine)
        table = _outcome_table(mine)
        tables.append(table if len(parts) == 1 else f"**Part {part}**\n\n{table}")
    return Section("What came out", "\n\n".join(said), tables)


def _verdict(part: str, tests: Sequence[TunedTable]) -> str:
    missed = {t.engine: [b.title for b in _bars(t) if not b.met] for t in tests}
    met = [engine for engine, titles in missed.items() if not titles]
    said = f"On part `{part}` the tuned parameters meet every bar on {names(met)}"
    if not met:
        said = f"On part `{part}` the tuned parameters meet every bar on no engine"
    failed = [f"{e} ({', '.join(titles)})" for e, titles in missed.items() if titles]
    said += f"; they miss one or more on {'; '.join(failed)}." if failed else "."
    if len(tests) > 1:
        mean = sum(t.tuned.accuracy.value for t in tests) / len(tests)
        place = "at least" if mean >= _ACCURATE else "below"
        said += (
            f" Their mean accuracy over {len(tests)} engines is {100 * mean:.1f} %, {place} "
            f"{100 * _ACCURATE:g} %."
        )
    return said


def _sentence(table: TunedTable) -> str:
    bars = _bars(table)
    groups = [
        f"{word}: {'; '.join(f'{b.title} ({b.said})' for b in bars if b.met is met)}."
        for word, met in (("Met", True), ("Missed", False))
        if any(b.met is met for b in bars)
    ]
    tuned = table.tuned
    return (
        f"- {table.engine}: {100 * tuned.accuracy.value:.1f} % accurate at "
        f"{significant(tuned.cpu.value)} ms of CPU time a layout. {' '.join(groups)}"
    )


def _begun(tests: Sequence[TunedTable]) -> list[str]:
    """What a search begins with is right on, and what the search adds to that."""
    starts = {t.engine: o for t in tests for o in t.others if o.method.family == _START}
    gains = {e: o.ahead for e, o in starts.items() if o.ahead is not None}
    if not gains:
        return []
    asked = [set(o.method.spec.partition(":")[2].split(",")) for o in starts.values()]
    own = (
        " They follow the label's own protocol (reseat, corner markers, 10 cm, 10 degrees, 0.3 s)."
        if all(given >= _AS_LABELS for given in asked)
        else ""
    )
    alone = "; ".join(f"{percent(starts[e].accuracy)} % on {e}" for e in gains)
    added = "; ".join(f"{percent(gain)} points on {e}" for e, gain in gains.items())
    unsure = [e for e, gain in gains.items() if gain.low <= 0.0 <= gain.high]
    sure = [e for e in gains if e not in unsure]
    told = [f"The interval of this gain includes 0 on {names(unsure)}."] if unsure else []
    told += [f"The interval of this gain excludes 0 on {names(sure)}."] if sure else []
    return [
        "The parameters that a search begins with are judged as well, in the rows *start of the "
        f"search*.{own} Alone they are right on {alone}. To that the tuned parameters add {added}. "
        + " ".join(told)
    ]


def _outcome_table(tests: Sequence[TunedTable]) -> str:
    robust = any(o.robust.n for t in tests for o in (t.tuned, *t.others))
    header = (
        "method", "n", "accuracy %", "tuned minus it", "CPU ms", "tuned CPU / its",
        "overestimated %", "underestimated %", *(("robust labels %",) if robust else ()),
    )  # fmt: skip
    rows = [
        (
            row.method.title,
            str(row.accuracy.n),
            percent(row.accuracy),
            percent(row.ahead),
            milliseconds(row.cpu),
            factor(row.cost_ratio),
            percent(row.over),
            percent(row.under),
            *((percent(row.robust),) if robust else ()),
        )
        for table in tests
        for row in (table.tuned, *table.others)
    ]
    return markdown_table(header, rows)


def _prices(tuning: Tuning) -> Section:
    prices = tuning.prices
    engines = list(dict.fromkeys(p.engine for p in prices))
    budgets = sorted({p.budget for p in prices})
    cells = {(p.engine, p.budget): _bought(p.test) for p in prices}
    matrix = markdown_table(
        ("budget ms", *engines),
        [(f"{b:g}", *(cells.get((e, b), MISSING) for e in engines)) for b in budgets],
    )
    chosen = markdown_table(
        ("engine", "budget ms", "parameters", "n", "accuracy where chosen %"),
        [
            (
                p.engine,
                f"{p.budget:g}",
                p.values,
                str(p.test.accuracy.n),
                f"{100 * p.validation:.1f}",
            )
            for p in prices
            if p.test is not None
        ],
        left=3,
    )
    tables = [f"Accuracy % with its interval, then the measured CPU time:\n\n{matrix}"]
    if any(p.test is not None for p in prices):
        tables.append(f"The parameters, and the number of cases they were tested on:\n\n{chosen}")
    return Section(
        "The price of accuracy",
        "\n".join(_best_buy(b, [p for p in prices if p.budget == b]) for b in budgets)
        + "\n\nA budget buys the most accurate of all parameter sets seen whose cost is below it; "
        "it was chosen where the searches judged, and then tested once on other cases. *Nothing*: "
        "no set is that cheap.",
        tables,
        [
            Picture(
                "price",
                plot_price(tuning),
                "Accuracy against CPU time; good methods stand at the upper left. The axis of "
                "accuracy spreads the top. Steps are the fronts of all searches of an engine, at "
                "modelled cost and where the searches judged; points were measured on test, with "
                "95 % intervals; dotted lines are the budgets.",
            )
        ],
    )


def _bought(test: MethodEvaluation | None) -> str:
    if test is None:
        return "nothing"
    return f"{percent(test.accuracy)}, {significant(test.cpu.value)} ms"


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
    said, tables = [], []
    for engine, rows in parameters.items():
        kept = [r.name for r in rows if r.start == r.found]
        said.append(
            f"- {engine}: {len(rows) - len(kept)} of {len(rows)} parameters left the value that a "
            f"search starts from" + (f"; {names(kept)} stayed." if kept else ".")
        )
        table = markdown_table(
            ("parameter", "unit", "values", "start", "found"),
            [(r.name, r.unit or MISSING, r.values, r.start, r.found) for r in rows],
            left=3,
        )
        tables.append(f"**{engine}**\n\n{table}")
    return Section("What was searched and found", "\n".join(said), tables)


def _costs(costs: Sequence[CostRow]) -> Section:
    terms = list(dict.fromkeys(term for row in costs for term in row.terms))
    table = markdown_table(
        ("engine", "parameter sets", "rank correlation", "median error %", *terms),
        [
            (
                row.engine,
                str(row.parameter_sets),
                f"{row.correlation:.3f}",
                f"{100 * row.error:.1f}",
                *(compact(row.terms[t], 3) if t in row.terms else MISSING for t in terms),
            )
            for row in costs
        ],
    )
    worst = max(costs, key=lambda row: row.error)
    most = f"{100 * worst.error:.1f} % ({worst.engine})"
    return Section(
        "How cost is modelled",
        "A simulation counts what it does; each count costs an engine so many microseconds, fitted "
        "to measured CPU times of as many parameter sets as the table says. The median error is "
        + (f"at most {most}" if len(costs) > 1 else most)
        + ". *Rank correlation*: Spearman's, between modelled and measured times. The columns "
        "after the error are microseconds for each.",
        [table],
    )
