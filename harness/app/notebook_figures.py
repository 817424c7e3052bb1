"""Layouts, verdicts and answers as a notebook shows them."""

from __future__ import annotations

from functools import singledispatch

import numpy as np
from numpy.typing import NDArray

from steadyload.app.answers import Answer, Check, Reliability
from steadyload.app.repair_results import Outcome, Repair
from steadyload.config import stated
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.naming import label_in, with_ids
from steadyload.methods.contract.method import Status, Verdict
from steadyload.reports.table import brief_time, significant
from steadyload.reports.viewer.notebook import shown_html
from steadyload.reports.viewer.picture import LoadPicture
from steadyload.statistics.placed import items_placed


@singledispatch
def notebook_html(shown: object) -> str:
    """HTML of an object that shows itself: a line, values with units, and a picture.

    Raises:
        TypeError: of another class.
    """
    raise TypeError(f"{type(shown).__name__} does not show itself in a notebook")


@notebook_html.register
def _(layout: Layout) -> str:
    count, top = len(layout), float(layout.upper[:, 1].max())
    width, height, depth = layout.pallet.size
    facts = {
        "boxes": str(count),
        "weight": Frame().spoken(float(layout.weights.sum())),
        "height of the load": f"{significant(top)} cm of {height:g} cm",
        "pallet, width × depth": f"{width:g} × {depth:g} cm",
        "floor": str(layout.floor.kind),
    }
    line = f"{layout.name}: {count} box{'es' if count != 1 else ''}"
    return shown_html(line, facts, load_picture(layout))


@notebook_html.register
def _(verdict: Verdict) -> str:
    items = () if verdict.layout is None else verdict.layout.items
    line = with_ids(str(verdict), items)
    if verdict.layout is None:
        return shown_html(line, _facts(verdict))
    line = f"{verdict.layout.name}: {line}"
    return shown_html(line, _facts(verdict), load_picture(verdict.layout, verdict))


@notebook_html.register
def _(check: Check) -> str:
    facts = {"method": check.method}
    if check.reliability is not None:
        facts |= accuracy_fact(check.reliability)
    if check.notes:
        facts["in the plan"] = "; ".join(check.notes)
    said, line = check.verdict, f"{check.layout}: {check.sentence}"
    if said is None or said.layout is None:
        return shown_html(line, facts)
    return shown_html(line, facts | _facts(said), load_picture(said.layout, said, check.frame))


@notebook_html.register
def _(repair: Repair) -> str:
    facts = {"confirmed by": repair.judged_by or None, "before": None, "changes": None}
    if repair.before is not None:
        facts["before"] = repair.before.sentence
    if repair.changes:
        facts["changes"] = "; ".join(repair.sentences)
    line = f"{repair.name}: {repair.sentence}"
    return shown_html(line, stated(**facts), *repair_pictures(repair))


def repair_pictures(repair: Repair) -> tuple[LoadPicture, ...]:
    """The complete plan before a repair, the box at fault marked, and after it; those there are."""
    check = repair.before
    said = None if check is None else check.verdict
    if check is None or said is None or said.layout is None or repair.layout is None:
        return ()
    plan, now, at_fault = said.layout, repair.layout, said.item_at_fault
    if check.crushed is not None:
        at_fault = check.crushed.item
    elif check.gap is not None and check.answer is Answer.HOVERS:
        at_fault = check.gap.item
    caption = f"{plan.name} as planned"
    if at_fault is not None:
        caption += f", {label_in(plan.items, at_fault)} in red"
    axes = repair.frame.axes
    before = LoadPicture(plan.pallet.size, _drawn(plan), at_fault, axes=axes, caption=caption)
    if repair.outcome is not Outcome.REPAIRED:
        return (before,)
    moved = moved_boxes(repair)
    told = "repaired, moved boxes in amber" if moved else "repaired"
    return before, LoadPicture(now.pallet.size, _drawn(now), moved=moved, axes=axes, caption=told)


def moved_boxes(repair: Repair) -> frozenset[int]:
    """Numbers of the boxes of a repaired plan that are at another place than before."""
    return frozenset(
        change.new_step for change in repair.changes if change.moved and change.new_step is not None
    )


def accuracy_fact(found: Reliability) -> dict[str, str]:
    """The accuracy of a method, by a name which says that it is not that of one load."""
    name = f"accuracy on {found.cases} similar labelled pallets"
    return {name: f"{100.0 * found.accuracy.value:.1f} %"}


def _drawn(layout: Layout) -> NDArray[np.float64]:
    found: NDArray[np.float64] = np.hstack((layout.lower, layout.sizes))
    return found


def load_picture(
    layout: Layout, verdict: Verdict | None = None, frame: Frame | None = None
) -> LoadPicture:
    """The picture of a load: up to the item at whose placement it fails, the one at fault marked.

    Args:
        layout: the plan.
        verdict: None to draw all items, and to mark none.
        frame: names of the axes.
    """
    failing = None if verdict is None else verdict.failing_step
    placed = min(items_placed(failing, len(layout)) + 1, len(layout))
    caption = f"{layout.name}: {placed} of {len(layout)} boxes"
    at_fault = None if verdict is None else verdict.item_at_fault
    if at_fault is not None:
        caption += f", {label_in(layout.items, at_fault)} in red"
    return LoadPicture(
        layout.pallet.size, _drawn(layout)[:placed], at_fault, axes=(frame or Frame()).axes,
        caption=caption,
    )  # fmt: skip


def _facts(verdict: Verdict) -> dict[str, str]:
    """Values of a verdict with their units, by name; those that it has."""
    score, step, ignored = verdict.score, verdict.failing_step, ", ".join(verdict.ignored)
    placed = f"{verdict.items_placed} of {verdict.item_count} boxes placed safely"
    moved, turned = verdict.displacement, verdict.rotation
    timed = verdict.wall.total > 0.0  # a session states none unless it is asked to
    facts = {
        "status": None if verdict.status is Status.DONE else str(verdict.status),
        "score": None if score is None else f"{significant(score)} ({placed})",
        "fails at": None if step is None else f"box {step + 1} of {verdict.item_count}",
        "displacement": None if moved is None else f"{moved:.1f} cm",
        "rotation": None if turned is None else f"{turned:.1f} degrees",
        "ignored by the engine": ignored or None,
        "CPU time": brief_time(verdict.cpu.total) if timed else None,
    }
    return stated(**facts)
