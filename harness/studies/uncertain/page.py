"""The page of uncertain verdicts: probabilities that loads stand, and their calibration."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from steadyload.reports.pages.page import Page, Picture, Section
from steadyload.reports.pages.reliability_figures import plot_reliability, plot_risk
from steadyload.reports.pages.reliability_tables import (
    abstention_table,
    bins_table,
    errors_table,
)
from steadyload.reports.table import (
    MISSING,
    Column,
    Table,
    compact,
    counts,
    factor,
    milliseconds,
    names,
    percent,
    plain_percent,
    significant,
    words,
    yes_no,
)
from steadyload.runs.costs import CostKind, CostSource
from steadyload.statistics.estimate import Estimate
from steadyload.studies.method_sections import METHOD
from steadyload.studies.uncertain.summary import Check, Uncertain, UncertainRow

_FEW = 10
"""Smallest number of cases of which a mean is shown."""


def _enough(estimate: Estimate) -> str:
    return percent(estimate) if estimate.n >= _FEW else MISSING


def _with_n(title: str, value: str) -> tuple[Column, Column]:
    return Column(title, value, _enough), Column("n", f"{value}.n")


_ACCURACY = (
    METHOD,
    Column("n", "plan.n"),
    Column("plan %", "plan", percent),
    Column("likeliest step %", "likeliest", percent),
    Column("ahead (points)", "ahead", percent),
    Column("Brier, plan", "plan_brier", factor),
    Column("Brier, P", "stands.brier", factor),
)
_FIRM = (
    METHOD,
    *_with_n("unsure %", "unsure"),
    *_with_n("changed %", "changed"),
    *_with_n("robust %", "changed_robust"),
    *_with_n("fragile %", "changed_fragile"),
)
_ALONE = (
    words("deviates", "what"),
    Column("n", "changed.n"),
    Column("changed %", "changed", percent),
    Column("unsure %", "unsure", percent),
)
_COST = (
    METHOD,
    Column("n", "samples.n"),
    Column("samples", "samples", lambda e: f"{e.value:.0f} [{e.low:.0f}, {e.high:.0f}]"),
    Column("CPU ms, plan", "plan_cpu", milliseconds),
    Column("CPU ms, all samples", "cpu", milliseconds),
    Column("sampling ended", "endings", counts),
    Column("samples without a verdict", "lost"),
    Column("cases without one", "unjudged"),
)
_CHECKED = (
    words("layout"),
    words("scenario"),
    Column("samples"),
    Column("P %", lambda row: percent(Estimate(row.stands, row.low, row.high, row.samples))),
    Column("random samples %", "random", plain_percent),
    Column("inside", "inside", yes_no),
)


def uncertain_page(found: Uncertain, manifest: Mapping[str, str]) -> Page:
    """Compose the page."""
    sections = [_shows(found), _accuracy(found.rows), _firm(found.rows)]
    if found.alone:
        sections.append(_alone(found))
    sections += [_calibration(found.rows), _cost(found)]
    if found.check is not None:
        sections.append(_check(found.check))
    return Page(
        "How sure verdicts are",
        f"{_answer(found)}Cases of part `{found.part}` of the labelled set are judged as planned, "
        f"and again and again with deviations from the plan: `{found.uncertainty}`, standard "
        "deviations, lengths in cm (what deviates how: docs/uncertainty.md). *P* is the "
        "probability that the whole load stands, sampled until it is known to "
        f"{found.half_width:g}, with at most {found.most} samples; the *likeliest* failing step "
        "is the one that most samples have. Labels are of the plans. Half of the cases are "
        "stable, more than half in nature. Brackets hold 95 % intervals, which stand on the "
        f"{found.item_lists} item lists.",
        sections,
        manifest,
    )


def _answer(found: Uncertain) -> str:
    """Sentence on the most accurate of the methods that were asked of most cases."""
    if not found.rows:
        return ""
    row = max(found.rows, key=lambda one: (one.plan.n, one.plan.value))
    return (
        f"Where a load deviates from its plan by `{found.uncertainty}`, it fails at another step "
        f"than the plan in {percent(row.changed)} % of samples, and whether it stands is unsure "
        f"for {percent(row.unsure)} % of {row.plan.n} cases, by {row.method.title}.\n\n"
    )


def _shows(found: Uncertain) -> Section:
    said = [
        f"- {row.method.title} (n {row.plan.n}): the likeliest step is right for "
        f"{_one(row.likeliest)} % of the cases, the plan's for {_one(row.plan)} %. "
        f"{_one(row.changed)} % of the samples fail at another step than the plan"
        f"{_by_label(row)}; P lies from 5 to 95 % for {_one(row.unsure)} % of the cases. Of the "
        f"tenth that it is least sure of it gets {_one(row.abstention.unsure)} % right, of the "
        f"others {_one(row.abstention.sure)} %."
        for row in found.rows
    ]
    said += [f"- {title} has no verdict on any of its cases." for title in found.silent]
    if found.alone:
        most = max(found.alone, key=lambda each: each.changed.value)
        said.append(
            f"- Of {names(f'`{each.what}`' for each in found.alone)}, each alone, `{most.what}` "
            f"changes most: {_one(most.changed)} % of the failing steps of "
            f"{found.alone_method.title} (n {most.changed.n})."
        )
    if found.check is not None:
        inside = sum(row.inside for row in found.check.rows)
        said.append(
            f"- On {len(found.check.rows)} layouts of which some samples stand and some fall, "
            f"{found.check.random} random samples a layout give a probability within the interval "
            f"of {inside}; a quasi-random sample is worth {compact(found.check.gain.value)} "
            "random ones there."
        )
    return Section("What it shows", "\n".join(said))


def _by_label(row: UncertainRow) -> str:
    robust, fragile = row.changed_robust, row.changed_fragile
    if min(robust.n, fragile.n) < _FEW:
        return ""
    return f", {_one(fragile)} % where the label is fragile and {_one(robust)} % where it is robust"


def _accuracy(rows: Sequence[UncertainRow]) -> Section:
    return Section(
        "Accuracy",
        "Share of cases on which the failing step is the label's: the one of the plan, and the "
        "likeliest one. *Ahead*: the latter minus the former, on the same cases; an interval that "
        "holds 0 tells no difference. *Brier*: mean square of the distance between what is said "
        "of standing (stable or not, 1 or 0, or P) and the label, 1 or 0; 0 is best, and saying "
        "one half always is 0.25. A case without a verdict counts as wrong.",
        [Table(rows, _ACCURACY)],
    )


def _firm(rows: Sequence[UncertainRow]) -> Section:
    return Section(
        "How firm a plan's verdict is",
        "*Unsure*: P lies from 5 to 95 %. *Changed*: mean share of samples with another failing "
        "step than the plan, over all cases, and over those whose label is *robust* (all judges "
        f"of its ensemble name the same step) or *fragile* (one does not); fewer than {_FEW} cases "
        "tell no mean.",
        [Table(rows, _FIRM)],
    )


def _alone(found: Uncertain) -> Section:
    return Section(
        "What matters",
        f"One thing alone deviates, judged by {found.alone_method.title}.",
        [Table(found.alone, _ALONE)],
    )


def _calibration(rows: Sequence[UncertainRow]) -> Section:
    kinds = {
        "the load stands": {row.method.title: row.stands for row in rows},
        "the likeliest step is right": {row.method.title: row.right for row in rows},
    }
    abstaining = {row.method.title: row.abstention for row in rows}
    return Section(
        "Calibration, and not judging the unsure",
        "Whether of the cases with a P of 80 % so many stand by their labels, and whether the "
        "likeliest step is right as often as its share says. A label is one verdict on the plan: "
        "P says what may become of the plan, so a P of 50 % promises no coin toss of the label, "
        "only that the label could easily be another. *Expected calibration error*: the distance "
        "between mean probability and share that happened, over the bins below, weighted; noise "
        "alone makes it larger than 0.",
        [
            errors_table(kinds),
            abstention_table(
                abstaining,
                "Accuracy of the likeliest step without the tenth of the cases of which it has the "
                "smallest share:",
            ),
            bins_table(kinds),
        ],
        [
            Picture(
                "reliability",
                plot_reliability(kinds),
                "What the labels say against the probability that was given, with 95 % intervals; "
                "the diagonal keeps what it says.",
            ),
            Picture(
                "risk",
                plot_risk(abstaining),
                "Share of wrong likeliest steps against the share of cases that are judged, the "
                "surest first.",
            ),
        ],
    )


def _cost(found: Uncertain) -> Section:
    return Section(
        "Cost",
        "A case and all of its samples; drawing what deviates is part of it. "
        f"{CostSource(CostKind.JUDGING).explained()} *Ended*: cases by why there were not more "
        "samples; *narrow*: the interval is as narrow as asked for; "
        "*spent*: there were as many as there may be.",
        [Table(found.rows, _COST)],
    )


def _check(check: Check) -> Section:
    farthest = max(abs(row.stands - row.random) for row in check.rows)
    return Section(
        "Against many random samples",
        f"{check.method.title}, the {len(check.rows)} first layouts, scenarios in turn, of which "
        "some samples stand and some fall (other samples than those shown, so that nothing is "
        f"chosen by its own luck); {check.random} random samples a layout, drawn apart. "
        f"Their share lies in the interval for {percent(check.inside)} % of the layouts (by chance "
        "it may miss for one in twenty); at most the two are "
        f"{significant(100 * farthest, 2)} points apart. One quasi-random sample is worth "
        f"{factor(check.gain)} random ones: p (1 - p) / n over the variance of the mean, which "
        "shows in how far the answers of independent scramblings lie apart.",
        [Table(check.rows, _CHECKED)],
    )


def _one(estimate: Estimate) -> str:
    return MISSING if estimate.n == 0 else f"{100 * estimate.value:.1f}"
