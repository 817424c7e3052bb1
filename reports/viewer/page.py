"""The page that plays a loading: one HTML file that needs nothing else, not even a network.

Our own scripts draw with three.js (see :mod:`steadyload.reports.viewer.three_js`). The library and
the poses stand in the page as gzip in base64, and the browser unpacks them. Two layers keep the
page
small: an item has a track in a step only where it moves by more than :data:`STILL_CM` or turns, and
numbers are whole hundredths of a millimetre.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from steadyload.reports.html import packed, rendered, template_text
from steadyload.reports.table import brief_time, significant
from steadyload.reports.viewer.records import Movement, Units, View, ViewedLoading, ViewedStep
from steadyload.reports.viewer.three_js import three_js
from steadyload.statistics.placed import items_placed

STILL_CM = 0.01
"""Items that move by less within a step are drawn at rest [cm]."""

_STILL_TURN = 1e-4
_PER_CM = 1000
_PER_UNIT = 10_000
_SCRIPTS = ("viewer/unpack.js", "viewer/lengths.js", "viewer/stage.js", "viewer/player.js")

MARKS = {name: f"<!--{name}-->" for name in ("style", "script", "library")}
"""Marks in the places of the shared texts, for pages that hold many players and the texts once;
escaped names cannot hold one."""


def view_html(view: View) -> str:
    """The page as text; the same view gives the same text.

    Raises:
        ThreeJsError: see :func:`steadyload.reports.viewer.three_js.three_js`.
    """
    return player_html(view, shared_texts())


def shared_texts() -> dict[str, str]:
    """Style, scripts and library of every page that plays a loading, by name.

    Raises:
        ThreeJsError: see :func:`steadyload.reports.viewer.three_js.three_js`.
    """
    return {
        "style": "\n".join(
            map(template_text, ("base.css", "viewer/viewer.css", "viewer/print.css"))
        ),
        "script": "\n".join(map(template_text, _SCRIPTS)),
        "library": packed(three_js()),
    }


def packed_shared_texts() -> str:
    """The shared texts with their :data:`MARKS`, for a page that fills in players when asked.

    Raises:
        ThreeJsError: see :func:`steadyload.reports.viewer.three_js.three_js`.
    """
    return packed(json.dumps({"marks": MARKS, "texts": shared_texts()}))


def player_html(view: View, texts: Mapping[str, str]) -> str:
    """The page as text.

    Args:
        view: what it plays.
        texts: those of :func:`shared_texts`, or marks in their places.
    """
    return rendered(
        "viewer/page.html.j2",
        view=view,
        summary=_summary(view),
        captions=[_caption(loading, view) for loading in view.loadings],
        texts=texts,
        data=packed(json.dumps(_plain(view), separators=(",", ":"))),
    )


def _summary(view: View) -> str:
    units, count = view.units, len(view.items)
    up = view.pallet[1] / units.cm
    sides = sorted((view.axes[k], view.pallet[k] / units.cm) for k in (0, 2))
    deck = f", its deck {view.deck / units.cm:g} {units.length} above the ground"
    return (
        f"{count} box{'es' if count != 1 else ''}, {view.weight}, on a pallet of "
        f"{' × '.join(f'{side:g}' for _, side in sides)} {units.length} loaded up to "
        f"{up:g} {units.length}{deck if view.deck else ''}"
    )


def _caption(loading: ViewedLoading, view: View) -> dict[str, Any]:
    """Caption above the scene of a method: its answer, and in small print how it came to that."""
    items, failing = view.items, loading.failing_step
    if loading.status != "done":
        kind, headline = "none", f"no verdict: {loading.status}"
    elif failing is None:
        kind, headline = ("fails", "hovers") if view.hovering else ("stands", "stands")
    else:
        kind, headline = "fails", f"fails at {items[failing].label}"
    if loading.headline:
        headline = loading.headline
    if loading.crushed:
        kind = "crushed"
    facts, notes = {}, []
    moved = loading.moved_item
    if moved is not None and loading.displacement is not None and loading.rotation is not None:
        how = "moved at most" if loading.headline else "moved"
        far = f"{loading.displacement / view.units.cm:.{view.units.decimals}f}"
        facts[f"{items[moved].label} {how}"] = f"{far} {view.units.length}, {loading.rotation:.1f}°"
    if not loading.headline:
        safe = items_placed(failing, len(items))
        score = "none" if loading.score is None else significant(loading.score)
        placed = "" if loading.score is None else f" ({safe} of {len(items)} placed)"
        notes.append(f"score {score}{placed}")
    if loading.seconds:
        notes.append(f"CPU time {brief_time(loading.seconds)}")
    if loading.reason and loading.displacement is None:
        notes.append(loading.reason)
    if not loading.simulates:
        notes.append("this method moves nothing: boxes are shown as planned")
    if loading.ignored:
        notes.append(f"the engine ignored {', '.join(loading.ignored)}")
    return {"kind": kind, "headline": headline, "facts": facts, "notes": "; ".join(notes)}


def _plain(view: View) -> dict[str, Any]:
    return {
        "pallet": view.pallet,
        "deck": view.deck,
        "axes": view.axes,
        "moved": sorted(view.moved),
        "units": asdict(view.units),
        "items": [
            {"size": i.size, "offset": i.mass_offset, "weight": i.weight, "label": i.label}
            for i in view.items
        ],
        "scale": [_PER_CM, _PER_UNIT],
        "forces": np.round(view.forces, 3).tolist(),
        "loadings": [_plain_loading(loading, view.units) for loading in view.loadings],
    }


def _plain_loading(loading: ViewedLoading, units: Units) -> dict[str, Any]:
    count = len(loading.planned)
    upright = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
    planned = np.hstack((loading.planned, upright))
    rest, steps = planned.copy(), []
    for step in loading.steps:
        if loading.reseats:
            rest = planned.copy()
        steps.append(_plain_step(step, planned, rest, units))
    if loading.status != "done":
        last = max(len(steps) - 1, 0)
    else:
        last = min(items_placed(loading.failing_step, count), count - 1)
    return {
        "method": loading.method,
        "planned": np.round(loading.planned, 3).tolist(),
        "last": last,
        "failing": loading.failing_step,
        "moved": loading.moved_item,
        "simulates": loading.simulates,
        "ride": bool(loading.headline) and not loading.crushed,
        "crushed": loading.crushed,
        "steps": steps,
    }


def _plain_step(
    step: ViewedStep, planned: NDArray[np.float64], rest: NDArray[np.float64], units: Units
) -> dict[str, Any]:
    """Tracks by item: a frame at the placement, then those recorded; one frame for what rests.

    ``rest`` holds where items are as the step begins, and is brought to where it ends.
    """
    tracks: dict[str, list[int]] = {}
    frames = np.concatenate((step.centres, step.quaternions), axis=2)
    for item in range(frames.shape[1]):
        track = np.vstack((rest[item], frames[:, item]))
        if _is_still(track, rest[item]):
            if not _is_still(rest[item][None], planned[item]):
                tracks[str(item)] = _whole(rest[item])
            continue
        tracks[str(item)] = _whole(track)
        rest[item] = track[-1]
    return {
        "times": [0.0, *np.round(step.times, 5).tolist()] if len(step.times) else [],
        "judged": step.judged,
        "tracks": tracks,
        "moved": [_plain_movement(m, units) for m in step.movements],
    }


def _is_still(track: NDArray[np.float64], at: NDArray[np.float64]) -> bool:
    away = np.abs(track - at)
    return bool(away[:, :3].max() <= STILL_CM and away[:, 3:].max() <= _STILL_TURN)


def _whole(track: NDArray[np.float64]) -> list[int]:
    scale = np.array([_PER_CM] * 3 + [_PER_UNIT] * 4)
    return [int(v) for v in np.rint(track * scale).ravel()]


def _plain_movement(movement: Movement, units: Units) -> tuple[int, float, float]:
    """As it is shown: rounded once, as the answer in a few words is."""
    far = round(movement.displacement / units.cm, units.decimals)
    return (movement.item, far, round(movement.rotation, 1))
