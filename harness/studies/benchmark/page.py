"""The page of a labelled set: contents, comparison with the paper's set, confidence of labels."""

from __future__ import annotations

import math
from collections.abc import Mapping

from steadyload.reports.pages.page import Page, Picture, Section
from steadyload.reports.table import (
    MISSING,
    Column,
    Table,
    columns_for,
    percent,
    plain_percent,
    words,
)
from steadyload.studies.benchmark.figures import (
    plot_agreement,
    plot_item_counts,
    plot_scores,
)
from steadyload.studies.benchmark.summary import BenchmarkSummary, RobustDispute

_CLASSES = (
    words("class", "item_class"),
    Column("item lists", "instances"),
    Column("layouts"),
    Column("items a layout", "items.value", "{:.1f}".format),
    Column("stable cases %", "stable", percent),
)
_SPLITS = (
    words("split", lambda s: s.split or "in none"),
    words("scenario"),
    Column("item lists", "instances"),
    Column("cases"),
    Column("stable"),
    Column("unstable", lambda s: s.cases - s.stable),
)
_NATURAL = (
    words("scenario"),
    Column("n", "stable.n"),
    Column("stable %", "stable", percent),
    Column("stable % of packings", "packings", percent),
    Column("paper's %", "published", plain_percent),
    Column("stable % by the other criterion", "criterion_paper", percent),
    Column("other failing step %", "other_label", percent),
)


def benchmark_page(found: BenchmarkSummary, manifest: Mapping[str, str], notes: str = "") -> Page:
    """Compose the page.

    Args:
        found: the summary; sections without results are left out.
        manifest: provenance of the set.
        notes: results of an inspection of the robust disputes one by one, as Markdown.
    """
    sections = [_contents(found), _natural(found), _failures(found)]
    if found.both_labels:
        sections.insert(2, _both_labels(found))
    if found.firmness:
        sections.append(_firmness(found))
    if found.judges:
        sections += [_agreement(found), _disputes(found, notes)]
    return Page(
        "The labelled set",
        f"{_answer(found)}{found.layouts} distinct geometries from {found.instances} item lists, "
        f"each with the centres of mass of every scenario: {found.cases} cases, "
        f"{found.without_label} without a label. A label is the failing step by the "
        "reference simulator: every placement afresh from the planned positions, 0.3 s, "
        "10 cm along one axis at a corner or 10 degrees about an axis, at the last sample. "
        "Brackets hold 95 % intervals; they resample item lists, since "
        "layouts of one list are no independent evidence.",
        sections,
        manifest,
    )


def _answer(found: BenchmarkSummary) -> str:
    """Sentence on the labels of the part that is compared on; empty without an ensemble."""
    shares = [row.robust for row in found.firmness if row.split == "test"]
    if not shares:
        return ""
    least, most = (f(shares, key=lambda share: share.value) for f in (min, max))
    return (
        f"Of the labels of the test part {percent(least)} to {percent(most)} %, by scenario, are "
        f"robust (n = {sum(share.n for share in shares)}): a whole ensemble of changed reference "
        "simulations names the same failing step.\n\n"
    )


def _contents(found: BenchmarkSummary) -> Section:
    return Section(
        "What is in it",
        "All layouts of one item list, whatever heuristic or scenario, lie in one split. Cases of "
        "test and validation lists that balancing leaves over are in none, so that nothing of a "
        "test list is learnt from.",
        [Table(found.classes, _CLASSES), Table(found.splits, _SPLITS)],
        [Picture("item_counts", plot_item_counts(found.item_counts), "Layouts by size.")],
    )


def _natural(found: BenchmarkSummary) -> Section:
    return Section(
        "Natural shares of stable layouts",
        "Before anything is balanced, over all cases. The paper's shares are of its sub-dataset 2, "
        "in which a geometry counts as often as a heuristic gives it: *of packings* counts ours "
        "so, too, and how near that is tells how alike the packings are. Under the paper's other "
        "criterion (the geometric centre, at any sample) some labels differ.",
        [Table(found.natural, _NATURAL)],
        [
            Picture(
                "scores",
                plot_scores(found.scores),
                "How far layouts can be loaded. Stable ones stand apart at the right.",
            )
        ],
    )


def _both_labels(found: BenchmarkSummary) -> Section:
    columns = [
        words("split"),
        words("scenario"),
        Column("n", "same.n"),
        Column("stable within 0.3 s %", "within", percent),
        Column("stands %", "stands", percent),
        Column("same step %", "same", percent),
        Column("falls earlier %", "earlier", percent),
        Column("falls later %", "later", percent),
        Column("cases"),
        Column("unsettled"),
        Column("no label", "failed"),
    ]
    return Section(
        "Within 0.3 s, and until everything rests",
        "The label asks, as the paper does, what has moved too far 0.3 s after a placement. Who "
        "loads a pallet asks whether it *stands*: the same thresholds at every look (each 0.03 s) "
        "until 3 s after the placement. What then still moves faster than 1 cm/s is *unsettled*: "
        "it has no label of this question. Validation, test and some training cases have both.",
        [Table(found.both_labels, columns)],
    )


def _failures(found: BenchmarkSummary) -> Section:
    if not found.reasons:
        return Section("Why loadings fail", "No movements are recorded in this set.")
    columns = columns_for(found.reasons[0].shares, "{} %", "shares", percent)
    return Section(
        "Why loadings fail",
        "Of the unstable cases, at the failing step.",
        [Table(found.reasons, [words("at the failing step", "reason"), *columns])],
    )


def _firmness(found: BenchmarkSummary) -> Section:
    columns = [
        words("split"),
        words("scenario"),
        Column("n", "robust.n"),
        Column("robust %", "robust", percent),
        Column("confidence %", "confidence", percent),
        *columns_for(found.firmness[0].parts, "{} %", "parts", percent),
    ]
    return Section(
        "How sure the labels are",
        "*Confidence* is the share of an ensemble of changed references that names the same "
        "failing step; a label is *robust* when all do. *Numerical*: the same question solved "
        "otherwise; *model*: other friction, damping, stiffness; *limits*: thresholds and time "
        "10 % less or more.",
        [Table(found.firmness, columns)],
    )


def _agreement(found: BenchmarkSummary) -> Section:
    columns = [
        words("judge"),
        words("reason"),
        *columns_for(found.judges[0].by_scenario, "{} %", "by_scenario", percent),
        Column("all %", "pooled", percent),
        Column("robust labels %", "robust", percent),
        Column("earlier"),
        Column("later"),
        Column("no verdict", "without_verdict"),
    ]
    return Section(
        "Further judges",
        "Agreement with the labels of the test split. The first rows are the ensemble; then the "
        "state carried over from placement to placement, and other engines. *Earlier* and *later* "
        "count cases in which a judge names an earlier or a later step.",
        [Table(found.judges, columns)],
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
    columns = [
        words("layout"),
        words("scenario"),
        Column("items", "item_count"),
        Column("label"),
        *columns_for(found.disputes[0].said, "{}", "said"),
        Column("step"),
        Column("corner cm", lambda d: _movement(d, d.corner)),
        Column("angle deg", lambda d: _movement(d, d.angle)),
        Column("margin cm", lambda d: _movement(d, d.margin, 2)),
    ]
    return Section(
        "Robust labels in dispute",
        "Every robust label of the test split that an engine disagrees with. *Step* is the first "
        "at which they part; how far the reference moves there, and the margin of equilibrium."
        + (f"\n\n{notes}" if notes else ""),
        [Table(found.disputes, columns)],
    )


def _movement(dispute: RobustDispute, value: float | None, digits: int = 1) -> str:
    """A movement, or the margin, where the reference recorded the step."""
    if math.isnan(dispute.corner) or dispute.margin is None or value is None:
        return MISSING
    return f"{value:.{digits}f}" if math.isfinite(value) else "none"
