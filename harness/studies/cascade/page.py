"""The page of a cascade: its accuracy and cost, and the steps that each stage decides."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from steadyload.reports.page import Page, Picture, Section
from steadyload.reports.table import (
    Column,
    Table,
    compact,
    factor,
    general,
    markdown_table,
    milliseconds,
    names,
    percent,
    plain_percent,
    words,
)
from steadyload.runs.evaluation import MethodEvaluation
from steadyload.studies import method_sections as column
from steadyload.studies.cascade.figures import plot_sweep
from steadyload.studies.cascade.summary import CascadeStudy

WITHIN = 0.005
"""Largest difference of accuracy to the most accurate simulation."""

LIMIT = 1.0
"""Largest cost [ms a layout]."""

NEAR = 0.01
"""Largest difference to the best accuracy at which a simulation counts as accurate."""

TENTH = 0.1
"""Largest share of the cost of the cheapest accurate simulation."""


def cascade_page(study: CascadeStudy, manifest: Mapping[str, str]) -> Page:
    """Compose the page."""
    return Page(
        f"{study.cascade.method.title}: model only what a scene requires",
        f"{_answer(study)}\n\nA cascade asks the cheapest method first, of every step; what that "
        "is not sure of goes on to the next, and only the rest is simulated. The first step that "
        "is judged unstable ends the loading. What counts as sure was fitted on other item lists, "
        "for a budget of accuracy that the stages before the last may cost. Here all is judged on "
        f"{study.cases} cases of part `{study.part}` of the labelled set, packed from "
        f"{study.item_lists} item lists{_fitted_there(study)}. Brackets hold 95 % intervals, "
        "which stand on item lists. Differences are in percentage points, on the same cases.",
        [_aims(study), _comparison(study), _stages(study), _sweep(study), _fits(study)],
        {**manifest, **study.made_by},
    )


def _answer(study: CascadeStudy) -> str:
    own, best = study.cascade, _most_accurate(study)
    assert best.ahead is not None
    assert best.cost_ratio is not None
    return (
        f"{own.method.title} is right on {percent(own.accuracy)} % of {study.cases} cases at "
        f"{milliseconds(own.cpu)} ms of CPU time a layout: {percent(best.ahead)} points from the "
        f"most accurate simulation, {best.method.title}, at {factor(best.cost_ratio)} of its time."
    )


def _most_accurate(study: CascadeStudy) -> MethodEvaluation:
    return max(study.simulations, key=lambda m: m.accuracy.value)


def _fitted_there(study: CascadeStudy) -> str:
    """Sentence on whether the cases shown were used while thresholds were fitted."""
    if study.fitted_there:
        return ", **on which thresholds were fitted: accuracies are too high**"
    return "; nothing was fitted on them"


def _aims(study: CascadeStudy) -> Section:
    own, simulations = study.cascade, study.simulations
    best = _most_accurate(study)
    accurate = [m for m in simulations if m.accuracy.value >= best.accuracy.value - NEAR]
    cheapest = min(accurate, key=lambda m: m.cpu.value)
    assert best.ahead is not None
    assert cheapest.cost_ratio is not None
    rows = [
        (
            f"no more than {100 * WITHIN:g} points behind the most accurate simulation, "
            f"{best.method.title}",
            f"{percent(best.ahead)} points",
            _reached(-best.ahead.high, -best.ahead.low, WITHIN),
        ),
        (
            f"no more than {LIMIT:g} ms a layout",
            f"{milliseconds(own.cpu)} ms",
            _reached(own.cpu.low, own.cpu.high, LIMIT),
        ),
        (
            f"no more than {TENTH:g} of the CPU time of the cheapest simulation within "
            f"{100 * NEAR:g} point of the best, {cheapest.method.title}",
            factor(cheapest.cost_ratio),
            _reached(cheapest.cost_ratio.low, cheapest.cost_ratio.high, TENTH),
        ),
    ]
    return Section(
        "What was aimed at",
        f"{own.method.title}: {percent(own.accuracy)} % of cases right. An aim is reached (yes) "
        "if the whole 95 % interval meets it, missed (no) if no part of the interval does, and "
        f"open otherwise. {study.cost_source.explained()}",
        [markdown_table(("aim", "measured", "reached"), rows, left=3)],
    )


def _reached(low: float, high: float, most: float) -> str:
    """Whether an aim is reached, decided by the ends of an interval: a point proves nothing.

    Args:
        low: lower end of the interval of what should be small.
        high: its upper end.
        most: largest value that meets the aim.
    """
    if high <= most:
        return "yes"
    return "no" if low > most else "open"


def _comparison(study: CascadeStudy) -> Section:
    rows = [m for m in study.methods if m is study.cascade or m.method.spec not in study.budgets]
    columns = [
        *column.JUDGED, column.CPU,
        column.titled(column.AHEAD, "cascade ahead"),
        column.titled(column.COST_RATIO, "share of its time"),
        Column("substeps", lambda m: f"{m.substeps:.1f}" if m.substeps else None),
    ]  # fmt: skip
    return Section(
        "Beside other methods",
        "*Ahead*: accuracy of the cascade minus that of the method; an interval that holds 0 tells "
        "no difference. *Share of its time*: CPU time of the cascade over that of the method. "
        "*Substeps*: of the engine, mean a layout; they are the same on every machine.",
        [Table(rows, columns)],
    )


def _stages(study: CascadeStudy) -> Section:
    columns = [
        words("stage", "method.title"),
        Column("stable below", "low", partial(compact, digits=3)),
        Column("unstable above", lambda s: None if s.high is None else f"{s.high:.4f}"),
        Column("steps %", "steps", percent),
        Column("right %", "right", percent),
        Column("layouts %", "layouts", percent),
        Column("right %", "layouts_right", percent),
    ]
    return Section(
        "Who decided what",
        f"A layout has {study.steps_a_layout:.1f} steps that were asked for. A stage is sure of a "
        "step whose *risk*, on its own scale, is below *stable below* or above *unstable above*; "
        "the last one decides what is left. *Right*: of the steps that it decided, those where the "
        "label says the same (what comes after a label's failing step has none). *Layouts*: those "
        "that needed this stage and no later one.",
        [Table(study.stages, columns)],
    )


def _sweep(study: CascadeStudy) -> Section:
    budget = words("budget, points", lambda m: general(study.budgets[m.method.spec]))
    return Section(
        "Accuracy for time",
        "The same cascade with thresholds fitted for other budgets: the more accuracy the stages "
        "before the last may cost, the less is simulated.",
        [Table(study.swept, [budget, column.N, column.ACCURACY, column.CPU])],
        [
            Picture(
                "cascade-sweep",
                plot_sweep(study),
                "Accuracy over CPU time, with 95 % intervals; good methods stand at the upper "
                "left. Numbers at the line are budgets in percentage points.",
            )
        ],
    )


_BOUND = partial(plain_percent, digits=2)
_COST = partial(compact, digits=3)
_FITTED = (
    words("budget, points", "budget", general),
    words("stages before the last", lambda ladder: names(stage for stage, *_ in ladder.stages)),
    Column("lost (allowed)", lambda ladder: f"{ladder.lost} ({ladder.allowed})"),
    Column("gained"),
    Column("bound %", "bound", _BOUND),
    Column("95 % bound %", "sure_bound", _BOUND),
    Column("left out lost", lambda ladder: "{} of {}".format(*ladder.left_out)),
    Column("accuracy %", "accuracy", plain_percent),
    Column("last alone %", "accuracy_alone", plain_percent),
    Column("CPU ms", "cost", _COST),
    Column("last alone", "cost_alone", _COST),
)
_DECIDED = (
    words("stage", "method"),
    Column("steps"),
    Column("wrong"),
    Column("cases lost", "lost"),
)
_ELSEWHERE = (
    words("stage", "method"), Column("cases"), Column("item lists", "item_lists"), Column("steps"),
    Column("decided"), Column("wrong"),
)  # fmt: skip


def _fits(study: CascadeStudy) -> Section:
    first = study.ladders[0]
    decided = f"Steps that stages decided there, for {first.budget:g} points:"
    elsewhere = (
        "Stages that learnt nothing from labels, asked of every step of cases of the training part:"
    )
    return Section(
        "How thresholds were fitted",
        f"On {first.cases} cases of {first.item_lists} item lists, half of them stable. A case "
        f"is *lost* where {first.last} alone is right and the cascade is wrong, *gained* the other "
        "way round. Layouts of one item list are alike, so that the cases tell as much of losses "
        f"as {first.independent:.0f} independent ones. The budget holds for an upper bound of the "
        f"share of lost cases, at confidence {study.confidence:g}; the bound at 95 % stands "
        "beside it. *Left out*: lost cases where every item list is judged by thresholds that "
        "were fitted without it. That is what to expect of new item lists: thresholds are chosen "
        "so that few of the cases they are fitted on are lost. *CPU ms*: from the times of single "
        "steps, while thresholds were fitted.",
        [
            Table(study.ladders, _FITTED),
            Table(first.decided, _DECIDED, decided),
            *([Table(first.elsewhere, _ELSEWHERE, elsewhere)] if first.elsewhere else []),
        ],
    )
