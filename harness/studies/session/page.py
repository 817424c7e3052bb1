"""The page of loading sessions: cost of a placement, and gain for packing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from steadyload.reports.pages.page import Page, Picture, Section
from steadyload.reports.table import (
    MISSING,
    Column,
    Table,
    columns_for,
    milliseconds,
    percent,
    significant,
    words,
)
from steadyload.runs.costs import CostKind, CostSource
from steadyload.studies.method_sections import METHOD
from steadyload.studies.session.figures import plot_placement_costs
from steadyload.studies.session.packing_gains import PackingTask
from steadyload.studies.session.study import SessionCurve

_SHOWN = (40, 100, 200)
"""Numbers of loaded items for which the table shows the cost."""


def _two_digits(value: float | None) -> str:
    return significant(value, 2)


def _over_session(curve: SessionCurve) -> float | None:
    placement, whole = curve.placement(_SHOWN[-1]), curve.whole(_SHOWN[-1])
    return whole / placement if whole is not None and placement is not None else None


_COSTS = (
    words("scene"),
    METHOD,
    *columns_for(_SHOWN, "ms at {}", SessionCurve.placement, significant),
    Column("exponent", "exponent", lambda e: MISSING if e is None else f"{e:.2f}"),
    Column(f"whole layout, ms at {_SHOWN[-1]}", lambda curve: curve.whole(_SHOWN[-1]), significant),
    Column("over session", _over_session, _two_digits),
)
_GAINS = (
    words("rejected by", lambda gain: gain.method.title if gain.method else "nobody"),
    Column("stable %", "stable", percent),
    Column("mean score %", "score", percent),
    Column("bins a list", "bins.value", "{:.2f}".format),
    Column("ms an item", "cpu", milliseconds),
    Column("left out", "left_out"),
    Column("judged an item", lambda gain: gain.asked if gain.method else None, _two_digits),
    Column("rejected an item", lambda gain: gain.rejected if gain.method else None, _two_digits),
    Column("of this judging", lambda gain: gain.judging if gain.method else None, milliseconds),
)


def session_page(
    curves: Sequence[SessionCurve],
    scenes: Mapping[str, str],
    tasks: Sequence[PackingTask],
    manifest: Mapping[str, str],
) -> Page:
    """Compose the page; a part that was not measured is left out.

    Args:
        curves: costs of placements.
        scenes: descriptions of their scenes, by name.
        tasks: gains of packing heuristics.
        manifest: provenance of the page.
    """
    sections = []
    if curves:
        sections.append(_costs(curves, scenes))
    if tasks:
        sections.append(_gains(tasks))
    return Page(
        "Loading judged while it is planned",
        f"{_answer(tasks)}A loading session places items one after the other and judges "
        f"each at once (`LoadingSession`). {CostSource(CostKind.ONE_PROCESS).explained()}",
        sections,
        manifest,
    )


def _answer(tasks: Sequence[PackingTask]) -> str:
    """Paragraph on the method that gains most in the first task."""
    for task in tasks[:1]:
        nobody = next((gain for gain in task.gains if gain.method is None), None)
        best = max((g for g in task.gains if g.method), key=lambda g: g.stable.value, default=None)
        if nobody and best and best.method:
            return (
                f"Bins of {task.title} are stable in {percent(best.stable)} % where "
                f"{best.method.title} rejects placements while they are packed, and in "
                f"{percent(nobody.stable)} % where nobody does ({task.item_lists} item lists), at "
                f"{milliseconds(best.cpu)} ms an item; that takes {best.bins.value:.2f} bins a "
                f"list instead of {nobody.bins.value:.2f}.\n\n"
            )
    return ""


def _costs(curves: Sequence[SessionCurve], scenes: Mapping[str, str]) -> Section:
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
        [Table(curves, _COSTS)],
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
    first = tasks[0]
    tables = [
        Table(
            task.gains,
            _GAINS,
            f"**{task.title}**, {task.item_lists} lists of {task.items} items",
        )
        for task in tasks
    ]
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
