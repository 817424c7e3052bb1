"""Page that plays a loading."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from steadyload.atomic import write_atomically
from steadyload.errors import UserError, nearest
from steadyload.layouts.floor import FloorKind
from steadyload.layouts.formats import read_layouts
from steadyload.layouts.model import Layout
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


class ViewError(UserError):
    """A missing layout, or no name where a file holds several."""


def write_view(layout: Layout, methods: Sequence[str], output: str | Path) -> Path:
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
    loadings = tuple(_loading(record_loading(layout, judge)) for judge in judges)
    view = View(
        name=layout.name,
        pallet=layout.pallet.size,
        deck=layout.floor.height,
        items=_items(layout),
        loadings=loadings,
        manifest=provenance_lines(),
    )
    write_atomically(Path(output), view_html(view))
    return Path(output)


def pick_layout(
    file: str | Path,
    name: str | None = None,
    *,
    overhang: float | None = None,
    floor: FloorKind | str | None = None,
) -> Layout:
    """One layout of a file.

    Args:
        file: in any known format.
        name: of the layout; None where the file holds only one.
        overhang: as of :func:`steadyload.layouts.formats.read_layouts`.
        floor: likewise.

    Raises:
        ViewError: no layout has this name, or there are several and none is named.
        LayoutError, OSError: the file cannot be read.
    """
    found = read_layouts(file, overhang=overhang, floor=floor)
    layouts = {layout.name: layout for layout in found}
    if name is None:
        if len(layouts) > 1:
            raise ViewError(
                f"{file} holds {len(layouts)} layouts; name one with --layout, for example "
                f"{next(iter(layouts))!r}"
            )
        return next(iter(layouts.values()))
    if name not in layouts:
        raise ViewError(f"{file} holds no layout {name!r}; {nearest(name, layouts)}")
    return layouts[name]


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
        )
        for item in layout.items
    )


def _loading(recording: Recording) -> ViewedLoading:
    said = recording.verdict
    return ViewedLoading(
        method=recording.method,
        status=str(said.status),
        score=said.score,
        failing_step=said.failing_step,
        moved_item=said.moved_item,
        displacement=said.displacement,
        rotation=said.rotation,
        reason=said.reason,
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
