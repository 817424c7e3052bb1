"""The page of a labelled set: contents, comparison with the paper's set, confidence of labels."""

from __future__ import annotations

import math
from collections.abc import Mapping

from steadyload.reports.page import Page, Picture, Section
from steadyload.reports.table import MISSING, markdown_table, percent
from steadyload.studies.benchmark.figures import (
    plot_agreement,
    plot_item_counts,
    plot_scores,
)
from steadyload.studies.benchmark.records import BenchmarkSummary, RobustDispute


def benchmark_page(found: BenchmarkSummary, manifest: Mapping[str, str], notes: str = "") -> Page:
    """Compose the page.

    Args:
        found: the summary; sections without results are left out.
        manifest: provenance of the set.
        notes: results of an inspection of the robust disputes one by one, as Markdown.
    """
    sections = [_contents(found), _natural(found), _failures(found)]
    if found.firmness:
        sections.append(_firmness(found))
    if found.judges:
        sections += [_agreement(found), _disputes(found, notes)]
    return Page(
        "The labelled set",
        f"{found.layouts} distinct geometries from {found.instances} item lists, each with the "
        f"centres of mass of every scenario: {found.cases} cases, {found.without_label} without a "
        "label. A label is the failing step by the reference simulator: every placement afresh "
        "from the planned positions, 0.3 s, 10 cm along one axis at a corner or 10 degrees about "
        "an axis, at the last sample. Brackets hold 95 % intervals; they resample item lists, "
        "since layouts of one list are no independent evidence.",
        sections,
        manifest,
    )


def _contents(found: BenchmarkSummary) -> Section:
    classes = markdown_table(
        ("class", "item lists", "layouts", "items a layout", "stable cases %"),
        [
            (
                str(c.item_class),
                str(c.instances),
                str(c.layouts),
                f"{c.items.value:.1f}",
                percent(c.stable),
            )
            for c in found.classes
        ],
    )
    splits = markdown_table(
        ("split", "scenario", "item lists", "cases", "stable", "unstable"),
        [
            (
                s.split or "in none",
                s.scenario,
                str(s.instances),
                str(s.cases),
                str(s.stable),
                str(s.cases - s.stable),
            )
            for s in found.splits
        ],
        left=2,
    )
    return Section(
        "What is in it",
        "All layouts of one item list, whatever heuristic or scenario, lie in one split. Cases of "
        "test and validation lists that balancing leaves over are in none, so that nothing of a "
        "test list is learnt from.",
        [classes, splits],
        [Picture("item_counts", plot_item_counts(found.item_counts), "Layouts by size.")],
    )


def _natural(found: BenchmarkSummary) -> Section:
    rows = [
        (
            n.scenario,
            str(n.stable.n),
            percent(n.stable),
            percent(n.packings),
            MISSING if n.published is None else f"{100.0 * n.published:.1f}",
            percent(n.criterion_paper),
            percent(n.other_label),
        )
        for n in found.natural
    ]
    return Section(
        "Natural shares of stable layouts",
        "Before anything is balanced, over all cases. The paper's shares are of its sub-dataset 2, "
        "in which a geometry counts as often as a heuristic gives it: *of packings* counts ours "
        "so, too, and how near that is tells how alike the packings are. Under the paper's other "
        "criterion (the geometric centre, at any sample) some labels differ.",
        [
            markdown_table(
                (
                    "scenario", "n", "stable %", "stable % of packings", "paper's %",
                    "stable % by the other criterion",
                    "other failing step %",
                ),
                rows,
            )
        ],
        [
            Picture(
                "scores",
                plot_scores(found.scores),
                "How far layouts can be loaded. Stable ones stand apart at the right.",
            )
        ],
    )  # fmt: skip


def _failures(found: BenchmarkSummary) -> Section:
    if not found.reasons:
        return Section("Why loadings fail", "No movements are recorded in this set.")
    scenarios = list(found.reasons[0].shares)
    return Section(
        "Why loadings fail",
        "Of the unstable cases, at the failing step.",
        [
            markdown_table(
                ("at the failing step", *(f"{s} %" for s in scenarios)),
                [(r.reason, *(percent(r.shares[s]) for s in scenarios)) for r in found.reasons],
            )
        ],
    )


def _firmness(found: BenchmarkSummary) -> Section:
    parts = list(found.firmness[0].parts)
    rows = [
        (
            f.split,
            f.scenario,
            str(f.robust.n),
            percent(f.robust),
            percent(f.confidence),
            *(percent(f.parts[p]) for p in parts),
        )
        for f in found.firmness
    ]
    return Section(
        "How sure the labels are",
        "*Confidence* is the share of an ensemble of changed references that names the same "
        "failing step; a label is *robust* when all do. *Numerical*: the same question solved "
        "otherwise; *model*: other friction, damping, stiffness; *limits*: thresholds and time "
        "10 % less or more.",
        [
            markdown_table(
                ("split", "scenario", "n", "robust %", "confidence %", *(f"{p} %" for p in parts)),
                rows,
                left=2,
            )
        ],
    )


def _agreement(found: BenchmarkSummary) -> Section:
    scenarios = list(found.judges[0].by_scenario)
    rows = [
        (
            j.judge,
            j.reason,
            *(percent(j.by_scenario[s]) for s in scenarios),
            percent(j.pooled),
            percent(j.robust),
            str(j.earlier),
            str(j.later),
            str(j.without_verdict),
        )
        for j in found.judges
    ]
    header = (
        "judge", "reason", *(f"{s} %" for s in scenarios), "all %", "robust labels %", "earlier",
        "later", "no verdict",
    )  # fmt: skip
    return Section(
        "Further judges",
        "Agreement with the labels of the test split. The first rows are the ensemble; then the "
        "state carried over from placement to placement, and other engines. *Earlier* and *later* "
        "count cases in which a judge names an earlier or a later step.",
        [markdown_table(header, rows, left=2)],
        [
            Picture(
                "judges",
                plot_agreement(found.judges),
                "Agreement with the labels of the test split, all scenarios.",
            )
        ],
    )


def _disputes(found: BenchmarkSummary, notes: str) -> Section:
    if not found.disputes:
        asked = any(
            j.reason == "engine" and j.robust is not None and j.robust.n for j in found.judges
        )
        text = "No engine disagrees with a robust label." if asked else "No engine was asked yet."
        return Section("Robust labels in dispute", text)
    judges = list(found.disputes[0].said)
    header = (
        "layout", "scenario", "items", "label", *judges, "step", "corner cm", "angle deg",
        "margin cm",
    )  # fmt: skip
    return Section(
        "Robust labels in dispute",
        "Every robust label of the test split that an engine disagrees with. *Step* is the first "
        "at which they part; how far the reference moves there, and the margin of equilibrium."
        + (f"\n\n{notes}" if notes else ""),
        [
            markdown_table(
                header,
                [
                    (
                        d.layout,
                        d.scenario,
                        str(d.item_count),
                        d.label,
                        *(d.said.get(j, MISSING) for j in judges),
                        str(d.step),
                        *_movement(d),
                    )
                    for d in found.disputes
                ],
                left=2,
            )
        ],
    )


def _movement(dispute: RobustDispute) -> tuple[str, str, str]:
    if math.isnan(dispute.corner) or dispute.margin is None:
        return (MISSING, MISSING, MISSING)
    margin = f"{dispute.margin:.2f}" if math.isfinite(dispute.margin) else "none"
    return (f"{dispute.corner:.1f}", f"{dispute.angle:.1f}", margin)
