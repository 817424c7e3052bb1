"""The page of a cascade: what it reaches, at which cost, and who decided what."""

from __future__ import annotations

from collections.abc import Mapping

from steadyload.reports.page import Page, Picture, Section
from steadyload.reports.table import (
    MISSING,
    compact,
    factor,
    markdown_table,
    milliseconds,
    names,
    percent,
)
from steadyload.studies.cascade.figures import plot_sweep
from steadyload.studies.cascade.summary import CascadeStudy, FittedLadder

WITHIN = 0.005
"""What the cascade may be behind the most accurate simulation."""

LIMIT = 1.0
"""ms a layout that it may take."""

NEAR = 0.01
"""A simulation counts as accurate that is so close to the best."""

TENTH = 0.1
"""Of the cost of the cheapest accurate simulation it may cost so much."""


def cascade_page(study: CascadeStudy, manifest: Mapping[str, str]) -> Page:
    """Compose the page."""
    return Page(
        f"{study.cascade.method.title}: model only what a scene requires",
        "A cascade asks the cheapest judge first, of every step; what that is not sure of goes on "
        "to the next, and only the rest is simulated. The first step that is judged unstable ends "
        "the loading. What counts as sure was fitted on validation, for a budget of accuracy that "
        "the stages before the last may cost. Here all is judged on "
        f"{study.cases} cases of part `{study.part}` of the labelled set, packed from "
        f"{study.item_lists} item lists{_fitted_there(study)}. Brackets hold 95 % intervals, "
        "which stand on item lists. Differences are in percentage points, on the same cases.",
        [
            _aims(study),
            _comparison(study),
            _stages(study),
            _sweep(study),
            _fits(study),
        ],
        {**manifest, **study.made_by},
    )


def _fitted_there(study: CascadeStudy) -> str:
    """Whether what is shown was looked at while thresholds were fitted."""
    if study.part == "validation":
        return ", **on which thresholds were fitted: accuracies are too high**"
    return "; nothing was fitted on them"


def _aims(study: CascadeStudy) -> Section:
    own, simulations = study.cascade, study.simulations
    best = max(simulations, key=lambda m: m.accuracy.value)
    accurate = [m for m in simulations if m.accuracy.value >= best.accuracy.value - NEAR]
    cheapest = min(accurate, key=lambda m: m.cpu.value)
    assert best.ahead is not None
    assert cheapest.cost_ratio is not None
    rows = [
        (
            f"no more than {100 * WITHIN:g} points behind the most accurate simulation, "
            f"{best.method.title}",
            f"{percent(best.ahead)} points",
            _reached(best.ahead.value >= -WITHIN),
        ),
        (
            f"no more than {LIMIT:g} ms a layout",
            f"{milliseconds(own.cpu)} ms",
            _reached(own.cpu.value <= LIMIT),
        ),
        (
            f"no more than {TENTH:g} of the CPU time of the cheapest simulation within "
            f"{100 * NEAR:g} point of the best, {cheapest.method.title}",
            factor(cheapest.cost_ratio),
            _reached(cheapest.cost_ratio.value <= TENTH),
        ),
    ]
    return Section(
        "What was aimed at",
        f"{own.method.title}: {percent(own.accuracy)} % of cases right. "
        f"{study.cost_source.explained()}",
        [markdown_table(("aim", "measured", "reached"), rows, left=3)],
    )


def _reached(yes: bool) -> str:
    return "yes" if yes else "no"


def _comparison(study: CascadeStudy) -> Section:
    return Section(
        "Beside other methods",
        "*Ahead*: accuracy of the cascade minus that of the method; an interval that holds 0 tells "
        "no difference. *Share of its time*: CPU time of the cascade over that of the method. "
        "*Substeps*: of the engine, mean a layout; they are the same on every machine.",
        [
            markdown_table(
                ("method", "n", "accuracy %", "overestimated %", "underestimated %", "CPU ms",
                 "cascade ahead", "share of its time", "substeps"),
                [
                    (
                        m.method.title,
                        str(m.accuracy.n),
                        percent(m.accuracy),
                        percent(m.over),
                        percent(m.under),
                        milliseconds(m.cpu),
                        percent(m.ahead),
                        factor(m.cost_ratio),
                        f"{m.substeps:.1f}" if m.substeps else MISSING,
                    )
                    for m in study.methods
                    if m is study.cascade or m.method.spec not in study.budgets
                ],
            )
        ],
    )  # fmt: skip


def _stages(study: CascadeStudy) -> Section:
    return Section(
        "Who decided what",
        f"A layout has {study.steps_a_layout:.1f} steps that were asked for. A stage is sure of a "
        "step whose *risk*, on its own scale, is below *stable below* or above *unstable above*; "
        "the last one decides what is left. *Right*: of the steps that it decided, those where the "
        "label says the same (what comes after a label's failing step has none). *Layouts*: those "
        "that needed this stage and no later one.",
        [
            markdown_table(
                ("stage", "stable below", "unstable above", "steps %", "right %", "layouts %",
                 "right %"),
                [
                    (
                        s.method.title,
                        MISSING if s.low is None else compact(s.low, 3),
                        MISSING if s.high is None else f"{s.high:.4f}",
                        percent(s.steps),
                        percent(s.right),
                        percent(s.layouts),
                        percent(s.layouts_right),
                    )
                    for s in study.stages
                ],
            )
        ],
    )  # fmt: skip


def _sweep(study: CascadeStudy) -> Section:
    return Section(
        "Accuracy for time",
        "The same cascade with thresholds fitted for other budgets: the more accuracy the stages "
        "before the last may cost, the less is simulated.",
        [_budgets(study)],
        [
            Picture(
                "cascade-sweep",
                plot_sweep(study),
                "Accuracy over CPU time, with 95 % intervals; good methods stand at the upper "
                "left. Numbers at the line are budgets in percentage points.",
            )
        ],
    )


def _budgets(study: CascadeStudy) -> str:
    return markdown_table(
        ("budget, points", "n", "accuracy %", "CPU ms"),
        [
            (
                f"{study.budgets[m.method.spec]:g}",
                str(m.accuracy.n),
                percent(m.accuracy),
                milliseconds(m.cpu),
            )
            for m in study.swept
        ],
    )


def _fits(study: CascadeStudy) -> Section:
    first = study.ladders[0]
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
            markdown_table(
                ("budget, points", "stages before the last", "lost (allowed)", "gained", "bound %",
                 "95 % bound %", "left out lost", "accuracy %", "last alone %", "CPU ms",
                 "last alone"),
                [_fitted(ladder) for ladder in study.ladders],
                left=2,
            ),
            f"Steps that stages decided there, for {first.budget:g} points:\n\n"
            + markdown_table(
                ("stage", "steps", "wrong", "cases lost"),
                [(d.method, str(d.steps), str(d.wrong), str(d.lost)) for d in first.decided],
            ),
            *_elsewhere(first),
        ],
    )  # fmt: skip


def _fitted(ladder: FittedLadder) -> tuple[str, ...]:
    lost, cases = ladder.left_out
    return (
        f"{ladder.budget:g}",
        names(method for method, _, _ in ladder.stages),
        f"{ladder.lost} ({ladder.allowed})",
        str(ladder.gained),
        f"{100 * ladder.bound:.2f}",
        f"{100 * ladder.sure_bound:.2f}",
        f"{lost} of {cases}",
        f"{100 * ladder.accuracy:.1f}",
        f"{100 * ladder.accuracy_alone:.1f}",
        compact(ladder.cost, 3),
        compact(ladder.cost_alone, 3),
    )


def _elsewhere(ladder: FittedLadder) -> list[str]:
    if not ladder.elsewhere:
        return []
    return [
        "Stages that learnt nothing from labels, asked of every step of cases of the training "
        "part:\n\n"
        + markdown_table(
            ("stage", "cases", "item lists", "steps", "decided", "wrong"),
            [
                tuple(map(str, (h.method, h.cases, h.item_lists, h.steps, h.decided, h.wrong)))
                for h in ladder.elsewhere
            ],
        )
    ]
