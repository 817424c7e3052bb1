"""The page of loading sessions: what a placement costs, and what packing gains."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from steadyload.reports.page import Page, Picture, Section
from steadyload.reports.table import (
    MISSING,
    markdown_table,
    milliseconds,
    percent,
    significant,
)
from steadyload.runs.costs import CostKind, CostSource
from steadyload.studies.session.figures import plot_placement_costs
from steadyload.studies.session.records import PackingGain, PackingTask, SessionCurve

_SHOWN = (40, 100, 200)
"""Items loaded where the table tells the cost."""


def session_page(
    curves: Sequence[SessionCurve],
    scenes: Mapping[str, str],
    tasks: Sequence[PackingTask],
    manifest: Mapping[str, str],
) -> Page:
    """Compose the page; a part that was not measured is left out.

    Args:
        curves: what placements cost.
        scenes: what their scenes are, by name.
        tasks: what packing heuristics gain.
        manifest: what the page was made with.
    """
    sections = []
    if curves:
        sections.append(_costs(curves, scenes))
    if tasks:
        sections.append(_gains(tasks))
    return Page(
        "Loading judged while it is planned",
        "A loading session places items one after the other and judges each at once "
        f"(`LoadingSession`). {CostSource(CostKind.ONE_PROCESS).explained()}",
        sections,
        manifest,
    )


def _costs(curves: Sequence[SessionCurve], scenes: Mapping[str, str]) -> Section:
    header = (
        "scene", "method", *(f"ms at {items}" for items in _SHOWN), "exponent",
        f"whole layout, ms at {_SHOWN[-1]}", "over session",
    )  # fmt: skip
    rows = []
    for curve in curves:
        at = {p.items: p for p in curve.points}
        last = at.get(_SHOWN[-1])
        cells = [curve.scene, curve.method.title]
        cells += [significant(at[n].placement) if n in at else MISSING for n in _SHOWN]
        cells.append(MISSING if curve.exponent is None else f"{curve.exponent:.2f}")
        if last is None or last.whole is None:
            cells += [MISSING, MISSING]
        else:
            cells += [significant(last.whole), significant(last.whole / last.placement, 2)]
        rows.append(tuple(cells))
    about = "; ".join(f"*{name}*: {text}" for name, text in scenes.items())
    return Section(
        "What a placement costs",
        "Boxes with sides of 5 to 25 cm that stand on four fifths of their bases or more; what a "
        f"method rejects is left out. {about}. The cost is that of `try_place` in whole: the item "
        "is checked, its neighbours are looked up, it is judged. Each number is the median of 20 "
        "placements in each of three draws, and of each placement the least of up to nine runs. "
        "*Exponent*: from 100 items on the cost grows as this power of the items loaded, 0 is "
        "flat, 1 is in proportion. *Whole layout*: judging all of it anew, which says the same. A "
        "curve ends where a session has taken too long.",
        [markdown_table(header, rows, left=2)],
        [
            Picture(
                "placements",
                plot_placement_costs(curves),
                "In a session a placement costs what it changes: a rule looks at what carries the "
                "new item, a simulation at what it may move.",
            )
        ],
    )


def _gains(tasks: Sequence[PackingTask]) -> Section:
    header = (
        "rejected by", "stable %", "mean score %", "bins a list", "left out", "judged an item",
        "rejected an item", "ms an item", "of this judging",
    )  # fmt: skip
    first = tasks[0]
    tables = []
    for task in tasks:
        tables.append(f"**{task.title}**, {task.item_lists} lists of {task.items} items")
        tables.append(markdown_table(header, [_gain(gain) for gain in task.gains]))
    return Section(
        "What packing gains",
        "Item lists of the paper's three classes, sides in whole centimetres, packed by the "
        f"heuristics {', '.join(first.heuristics)} with and without a session that rejects "
        "placements. Where one is rejected, the heuristic goes on to the next place that it would "
        "take: the next way to turn the item, the next space, the next bin. "
        f"`{first.judge}` judges the bins that come of it; it rejected nothing itself. Brackets "
        "hold 95 % intervals over item lists. *Judged* and *rejected* are placements.\n\n"
        "A heuristic that tries places until one is accepted finds the errors of whoever accepts: "
        "of a hundred places it takes the one that is wrongly called stable. So a method that is "
        "right on nearly all layouts of a test set may be worth less here than a strict rule, "
        "whose errors are all on the safe side.",
        tables,
    )


def _gain(gain: PackingGain) -> tuple[str, ...]:
    asked = (MISSING, MISSING)
    if gain.method is not None:
        asked = (significant(gain.asked, 2), significant(gain.rejected, 2))
    return (
        "nobody" if gain.method is None else gain.method.title,
        percent(gain.stable),
        percent(gain.score),
        f"{gain.bins.value:.2f}",
        str(gain.left_out),
        *asked,
        milliseconds(gain.cpu),
        MISSING if gain.method is None else milliseconds(gain.judging),
    )
