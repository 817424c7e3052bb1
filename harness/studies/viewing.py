"""Page that plays a loading."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Unpack

from steadyload.atomic import write_atomically
from steadyload.errors import UserError, nearest
from steadyload.layouts.formats import Reading, scan_layouts
from steadyload.layouts.model import Layout
from steadyload.layouts.naming import box_label, with_ids
from steadyload.layouts.record import Refused
from steadyload.layouts.sources import source_name
from steadyload.methods.recording import RecordedStep, Recording, record_loading
from steadyload.methods.registry import make_method
from steadyload.reports.viewer.records import (
    Movement,
    View,
    ViewedItem,
    ViewedLoading,
    ViewedStep,
)
from steadyload.runs.provenance import provenance_lines
from steadyload.studies.options import DEFAULT_METHOD


class ViewError(UserError):
    """A missing layout, or no name where a file holds several."""


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


def pick_layout(file: str | Path, name: str | None = None, **reading: Unpack[Reading]) -> Layout:
    """One layout of a file. The others need not be valid.

    Args:
        file: in any known format; ``-`` for standard input.
        name: of the layout; None where the file holds only one.
        reading: see :class:`steadyload.layouts.formats.Reading`.

    Raises:
        ViewError: no layout has this name, or there are several and none is named.
        LayoutError, OSError: the file cannot be read.
    """
    entries = {entry.name: entry for entry in scan_layouts(file, **reading)}
    if name is None:
        if len(entries) > 1:
            raise ViewError(
                f"{source_name(file)} holds {len(entries)} layouts; name one with --layout, for "
                f"example {next(iter(entries))!r}"
            )
        name = next(iter(entries))
    if name not in entries:
        raise ViewError(f"{source_name(file)} holds no layout {name!r}; {nearest(name, entries)}")
    entry = entries[name]
    if isinstance(entry, Refused):
        raise entry.error
    return entry


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
