"""Page that plays a loading."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Unpack

import numpy as np

from steadyload.atomic import write_atomically
from steadyload.errors import UserError, nearest
from steadyload.layouts.formats import Reading, scan_layouts
from steadyload.layouts.model import Layout
from steadyload.layouts.naming import box_label, with_ids
from steadyload.layouts.record import Refused
from steadyload.layouts.sources import source_name
from steadyload.methods.method import Method
from steadyload.methods.recording import RecordedStep, Recording, record_loading
from steadyload.methods.registry import make_method
from steadyload.reports.viewer.records import (
    Card,
    Gallery,
    Movement,
    View,
    ViewedItem,
    ViewedLoading,
    ViewedStep,
)
from steadyload.runs.provenance import provenance_lines
from steadyload.studies.options import DEFAULT_METHOD


class ViewError(UserError):
    """A missing layout."""


def write_view(
    layout: Layout,
    methods: Sequence[str] = (DEFAULT_METHOD,),
    output: str | Path = "view.html",
) -> Path:
    """Judge a layout, and write one HTML page that plays its loading; returns the page's path.

    Args:
        layout: any layout.
        methods: one spec string, or two to be played side by side.
        output: path of the page.

    Raises:
        SpecError, EngineNotInstalledError: a method does not exist, or its engine is missing.
        RecordingError: a method refuses the layout.
        ThreeJsError: the library that draws is missing.
        OSError: the page cannot be written.
    """
    # A caller that needs only the errors, as the command at its start, needs no templates.
    from steadyload.reports.viewer.page import view_html

    judges = [make_method(spec) for spec in methods]
    for judge in judges:
        judge.prepare(len(layout))
    view = view_of(layout, [record_loading(layout, judge) for judge in judges])
    write_atomically(Path(output), view_html(view))
    return Path(output)


def view_of(layout: Layout, recordings: Sequence[Recording]) -> View:
    """The content of a page that plays loadings of a layout side by side."""
    return View(
        name=layout.name,
        pallet=layout.pallet.size,
        deck=layout.floor.height,
        items=_items(layout),
        loadings=tuple(_loading(recording, layout) for recording in recordings),
        manifest=provenance_lines(),
    )


def write_views(
    entries: Sequence[Layout | Refused],
    methods: Sequence[str] = (DEFAULT_METHOD,),
    output: str | Path = "view.html",
    *,
    progress: Callable[[str], None] = lambda name: None,
) -> Path:
    """Write one page of several layouts: a card each, which opens the player; returns its path.

    Args:
        entries: layouts, and those that are not valid.
        methods: as of :func:`write_view`; the first one's answer stands on the card.
        output: path of the page.
        progress: called with the name of each layout before it is judged.

    Raises:
        as :func:`write_view`.
    """
    from steadyload.reports.viewer.gallery import gallery_html

    judges = [make_method(spec) for spec in methods]
    cards = []
    for entry in entries:
        progress(entry.name)
        cards.append(_refused(entry) if isinstance(entry, Refused) else _card(entry, judges))
    gallery = Gallery(
        title="Loadings",
        summary=f"{len(cards)} layouts, judged by {' and '.join(methods)}.",
        kinds=("fails", "no verdict", "bad input", "stable"),
        cards=tuple(cards),
        notes=("Every card plays the loading, box by box.",),
        manifest=provenance_lines(),
    )
    write_atomically(Path(output), gallery_html(gallery))
    return Path(output)


def _refused(entry: Refused) -> Card:
    return Card(entry.name, "bad input", str(entry.error))


def _card(layout: Layout, judges: Sequence[Method]) -> Card:
    from steadyload.reports.viewer.page import MARKS, player_html

    for judge in judges:
        judge.prepare(len(layout))
    recordings = [record_loading(layout, judge) for judge in judges]
    verdict = recordings[0].verdict
    kinds = {True: "stable", False: "fails" if verdict.failing_step is not None else "no verdict"}
    placed = len(layout) if verdict.failing_step is None else verdict.failing_step + 1
    return Card(
        name=layout.name,
        kind=kinds[verdict.stable],
        answer=with_ids(str(verdict), layout.items),
        facts=(f"{len(layout)} box{'es' if len(layout) != 1 else ''}",),
        pallet=layout.pallet.size,
        boxes=np.hstack((layout.lower, layout.upper - layout.lower))[:placed],
        marked=verdict.failing_step if verdict.moved_item is None else verdict.moved_item,
        player=player_html(view_of(layout, recordings), MARKS),
    )


def pick_layouts(
    file: str | Path, names: Sequence[str] = (), **reading: Unpack[Reading]
) -> list[Layout | Refused]:
    """Some layouts of a file, or all. Those that are not asked for need not be valid.

    Args:
        file: in any known format; ``-`` for standard input.
        names: of the layouts, in the order in which they are wanted; empty for all.
        reading: see :class:`steadyload.layouts.formats.Reading`.

    Returns:
        The layouts; where there are several, with those that are not valid.

    Raises:
        ViewError: no layout has this name.
        LayoutError, OSError: the file cannot be read, or the only layout is not valid.
    """
    entries = {entry.name: entry for entry in scan_layouts(file, **reading)}
    for name in names:
        if name not in entries:
            raise ViewError(
                f"{source_name(file)} holds no layout {name!r}; {nearest(name, entries)}"
            )
    found = [entries[name] for name in dict.fromkeys(names or entries)]
    if len(found) == 1 and isinstance(found[0], Refused):
        raise found[0].error
    return found


def _items(layout: Layout) -> tuple[ViewedItem, ...]:
    return tuple(
        ViewedItem(
            item.size,
            (
                item.position[0] + item.size[0] / 2.0,
                item.position[1] + item.size[1] / 2.0,
                item.position[2] + item.size[2] / 2.0,
            ),
            item.mass_offset,
            item.weight,
            item.name,
            box_label(item.sequence, item.name),
        )
        for item in layout.items
    )


def _loading(recording: Recording, layout: Layout) -> ViewedLoading:
    said = recording.verdict
    return ViewedLoading(
        method=recording.method,
        status=str(said.status),
        score=said.score,
        failing_step=said.failing_step,
        moved_item=said.moved_item,
        displacement=said.displacement,
        rotation=said.rotation,
        reason=with_ids(said.reason, layout.items),
        seconds=said.cpu.total,
        ignored=said.ignored,
        simulates=recording.simulates,
        reseats=recording.reseats,
        planned=recording.planned,
        steps=tuple(_step(step) for step in recording.steps),
    )


def _step(step: RecordedStep) -> ViewedStep:
    return ViewedStep(
        times=step.times,
        centres=step.poses.centres,
        quaternions=step.poses.quaternions,
        movements=tuple(Movement(m.item, m.displacement, m.rotation) for m in step.most_moved),
        judged=step.judged,
    )
