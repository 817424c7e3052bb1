"""Page that plays a loading."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Unpack

import numpy as np

from steadyload.app.check_defaults import GAPS_CM, default_method, default_methods
from steadyload.app.faults import fault_of
from steadyload.atomic import write_atomically
from steadyload.errors import UserError, nearest, required_list
from steadyload.layouts.files.record import Refused
from steadyload.layouts.files.sources import source_name
from steadyload.layouts.formats import Reading, scan_layouts
from steadyload.layouts.model.footing import gaps, largest
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import Layout, require_layout
from steadyload.layouts.model.naming import label_in, with_ids
from steadyload.methods.contract.method import Method
from steadyload.methods.registry import make_method
from steadyload.methods.session.recording import RecordedStep, Recording, record_loading
from steadyload.progress import NamedProgress, silent
from steadyload.reports.viewer.records import (
    Card,
    Gallery,
    Movement,
    Units,
    View,
    ViewedItem,
    ViewedLoading,
    ViewedStep,
)
from steadyload.runs.provenance import provenance_lines
from steadyload.statics.bearing.forces import ContactForces, contact_forces
from steadyload.transport.recording import record_ride
from steadyload.transport.rules import rule_named

Recorder = Callable[[Layout, Method], Recording]


class ViewError(UserError):
    """A missing layout."""


def require_library() -> None:
    """See that views can be written.

    Raises:
        ThreeJsError: the library that draws is missing.
    """
    from steadyload.reports.viewer.three_js import three_js

    three_js()


def write_view(
    layout: Layout,
    methods: Sequence[str | None] = (None,),
    output: str | Path = "view.html",
    *,
    record: Recorder = record_loading,
    frame: Frame | None = None,
) -> Path:
    """Judge a layout, and write one HTML page that plays its loading; returns the page's path.

    Args:
        layout: any layout.
        methods: one spec string, or two to be played side by side; None for the default one for so
            many boxes (:func:`steadyload.app.check_defaults.default_method`).
        output: path of the page.
        record: what is played of a layout and a method: its loading, or a ride, see
            :func:`riding`.
        frame: axes and units of all that is said: those of the file of the layout.

    Raises:
        LayoutError: it is no layout.
        SpecError, EngineNotInstalledError: a method does not exist, or its engine is missing.
        RecordingError: a method refuses the layout.
        ThreeJsError: the library that draws is missing.
        OSError: the page cannot be written.
    """
    require_layout(layout)
    # A caller that needs only the errors, as the command at its start, needs no templates.
    from steadyload.reports.viewer.page import view_html

    judges = [
        make_method(_named(spec, len(layout)))
        for spec in required_list("methods", methods, "a list of one or two methods")
    ]
    recordings = _recorded(layout, judges, record)
    shown = contact_forces(layout) if record is record_loading else None
    view = view_of(layout, recordings, provenance_lines(), shown, frame=frame)
    write_atomically(Path(output), view_html(view), follow=True)
    return Path(output)


def view_of(
    layout: Layout,
    recordings: Sequence[Recording],
    made: Mapping[str, str],
    forces: ContactForces | None = None,
    *,
    gaps_cm: float = GAPS_CM,
    frame: Frame | None = None,
) -> View:
    """The content of a page that plays loadings of a layout side by side.

    Args:
        layout: as planned.
        recordings: of its loadings.
        made: provenance, as a page shows it.
        forces: of the complete load, where they are to be shown.
        gaps_cm: how far a box that has nothing under it may drop [cm].
        frame: axes and units of all that is said.
    """
    gap, frame = largest(gaps(layout)), Frame.given(frame)
    return View(
        name=layout.name,
        weight=frame.spoken(float(layout.weights.sum())),
        pallet=layout.pallet.size,
        deck=layout.floor.height,
        items=_items(layout, frame),
        loadings=tuple(_loading(recording, layout) for recording in recordings),
        manifest=made,
        forces=np.empty((0, 4)) if forces is None else forces.resultants(),
        reasons=tuple(dict.fromkeys(filter(None, (_reason(r, layout, frame) for r in recordings)))),
        gap_note="" if gap is None else gap.sentence(layout, frame),
        hovering=gap is not None and gap.exceeds(gaps_cm),
        axes=frame.axes,
        units=Units(frame.unit, frame.cm, frame.decimals, frame.spoken_weight, frame.spoken_kg),
    )


def write_views(
    entries: Sequence[Layout | Refused],
    methods: Sequence[str | None] = (None,),
    output: str | Path = "view.html",
    *,
    record: Recorder = record_loading,
    frame: Frame | None = None,
    progress: NamedProgress = silent,
) -> Path:
    """Write one page of several layouts: a card each, which opens the player; returns its path.

    Args:
        entries: layouts, and those that are not valid.
        methods: as of :func:`write_view`; the first one's answer stands on the card.
        output: path of the page.
        record: as of :func:`write_view`.
        frame: likewise.
        progress: called before each layout is judged, with those done and those in all.

    Raises:
        as :func:`write_view`.
    """
    from steadyload.reports.viewer.gallery import gallery_html

    sizes = [len(entry) for entry in entries if isinstance(entry, Layout)]
    named = [default_methods(sizes) if spec is None else (spec,) for spec in methods]
    judges = {spec: make_method(spec) for specs in named for spec in specs}
    made = provenance_lines()
    cards: list[Card] = []
    for entry in entries:
        progress(f"judging {entry.name}", len(cards), len(entries))
        if isinstance(entry, Refused):
            cards.append(Card(entry.name, "bad input", str(entry.error)))
        else:
            own = [judges[_named(spec, len(entry))] for spec in methods]
            cards.append(_card(entry, own, made, record, frame or Frame()))
    gallery = Gallery(
        title="Loadings",
        summary=f"{len(cards)} layout{'s' if len(cards) != 1 else ''}, judged by "
        f"{' and '.join(judges)}.",
        kinds=("fails", "hovers", "no verdict", "bad input", "stands"),
        cards=tuple(cards),
        notes=("Every card plays the loading, box by box.",),
        manifest=made,
    )
    write_atomically(Path(output), gallery_html(gallery), follow=True)
    return Path(output)


def riding(rule: str, direction_deg: float) -> Recorder:
    """Recorder of rides, which :func:`write_view` plays in place of loadings.

    Args:
        rule: its name, or a TOML file of one.
        direction_deg: one of the rule's.

    Raises:
        TransportError: there is no such rule or direction.
    """
    asked = rule_named(rule)
    asked.level(direction_deg)
    return lambda layout, method: record_ride(layout, asked, direction_deg, method)


def _named(spec: str | None, boxes: int) -> str:
    return default_method(boxes) if spec is None else spec


def _recorded(layout: Layout, judges: Sequence[Method], record: Recorder) -> list[Recording]:
    for judge in judges:
        judge.prepare(len(layout))
    return [record(layout, judge) for judge in judges]


def _card(
    layout: Layout,
    judges: Sequence[Method],
    made: Mapping[str, str],
    record: Recorder,
    frame: Frame,
) -> Card:
    from steadyload.app.notebook_figures import load_picture
    from steadyload.reports.viewer.page import MARKS, player_html

    recordings = _recorded(layout, judges, record)
    view, verdict = view_of(layout, recordings, made, frame=frame), recordings[0].verdict
    headline, said = recordings[0].headline, replace(verdict, layout=layout).sentence(frame)
    reason = _reason(recordings[0], layout, frame)
    if reason and verdict.displacement is None:
        said = replace(verdict, layout=None, reason=reason).sentence(frame)
    kinds = {True: "stands", False: "fails" if verdict.failing_step is not None else "no verdict"}
    hovers = verdict.stable and view.hovering and not headline
    answer = headline or (f"hovers: {view.gap_note}" if hovers else said)
    told = [note for note in (reason, view.gap_note) if note and note not in answer]
    drawn, gap = load_picture(layout, verdict, frame), largest(gaps(layout))
    return Card(
        name=layout.name,
        kind="hovers" if hovers else kinds[verdict.stable],
        answer=answer,
        facts=(f"{len(layout)} box{'es' if len(layout) != 1 else ''}", *dict.fromkeys(told)),
        picture=replace(drawn, marked=gap.item) if hovers and gap is not None else drawn,
        player=player_html(view, MARKS),
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


def _items(layout: Layout, frame: Frame) -> tuple[ViewedItem, ...]:
    return tuple(
        ViewedItem(
            item.size,
            (
                item.position[0] + item.size[0] / 2.0,
                item.position[1] + item.size[1] / 2.0,
                item.position[2] + item.size[2] / 2.0,
            ),
            item.mass_offset,
            frame.spoken(item.weight),
            item.name,
            label_in(layout.items, item.sequence),
        )
        for item in layout.items
    )


def _reason(recording: Recording, layout: Layout, frame: Frame) -> str:
    """Why the load fails; empty where nothing fails, and for a ride."""
    fault = None
    if not recording.headline:
        fault = fault_of(layout, recording.verdict, recording.method)
    return "" if fault is None else fault.sentence(layout, frame)


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
        headline=recording.headline,
        crushed=recording.crushed,
    )


def _step(step: RecordedStep) -> ViewedStep:
    return ViewedStep(
        times=step.times,
        centres=step.poses.centres,
        quaternions=step.poses.quaternions,
        movements=tuple(Movement(m.item, m.displacement, m.rotation) for m in step.most_moved),
        judged=step.judged,
    )
