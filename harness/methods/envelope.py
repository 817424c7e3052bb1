"""Envelopes: the extremes each engine was measured to hold, and how a layout goes beyond them.

``envelopes.json`` beside this file is written by ``steadyload study extremes --write-envelope``
and says what it was made with. It is no part of a verdict: a layout beyond an envelope is judged
like any other, and whoever asked is told.

Measured at the label's thresholds (10 cm, 10 degrees) over one placement of 0.3 s, at friction 0.5
and restitution 0, on cubes of 10 cm where the size is not what is swept, each axis by itself. Not
covered: axes that go to their ends together (a tall tower of small cubes with a heavy one on top),
other friction or restitution, options that change what an engine is given (shrink, scope, margin,
damping), the shape of items beyond their thinnest and longest edge.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cache
from typing import Any

import numpy as np

from steadyload.layouts.model.contacts import FLOOR
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import FloatArray, Layout
from steadyload.methods.contract.method import Method
from steadyload.reading import own_file
from steadyload.stored import REMEDY, StoredFileError, stored_object

ENVELOPES = "envelopes.json"
"""The file beside this module that :func:`envelopes` reads."""


@dataclass(frozen=True, slots=True)
class Envelope:
    """Extremes that one engine holds at one frequency; numbers are the largest measured that held.

    Attributes:
        tower_height: cubes on top of each other; with all lower towers.
        heavy_on_light: mass of a cube over that of the one (or two) that carry it.
        light_on_heavy: mass of a cube over that of the one on top of it.
        least_size, most_size: edges of cubes [cm], two and five on top of each other.
        item_count: cubes without gaps.
        sees_falls: a plate beyond an edge falls, one before it stays.

    A number is 0 where nothing was held.
    """

    tower_height: int
    heavy_on_light: float
    light_on_heavy: float
    least_size: float
    most_size: float
    item_count: int
    sees_falls: bool


class Limit(StrEnum):
    """The limits of an envelope that a layout can exceed."""

    FALLS = "seeing falls"
    HEIGHT = "items on top of each other"
    HEAVY = "heavy on light"
    LOAD = "load on an item"
    LIGHT = "light on heavy"
    THIN = "thinnest edge"
    LONG = "longest edge"
    COUNT = "number of items"


@dataclass(frozen=True, slots=True)
class Extent:
    """Position of a layout along the axes of an envelope.

    Attributes:
        height: items in the longest chain of items that stand on each other.
        heavy_on_light, light_on_heavy: the largest mass ratio of two items of which one stands on
            the other; 1 or less where there is none.
        load: the largest load on an item over its own weight; a load spreads over the items that
            carry it by contact area.
        thinnest, longest: edges [cm].
        item_count: J.
    """

    height: int
    heavy_on_light: float
    light_on_heavy: float
    load: float
    thinnest: float
    longest: float
    item_count: int


@cache
def envelopes(*, at_rest: bool = False) -> Mapping[str, tuple[tuple[float | None, Envelope], ...]]:
    """All that was measured: rows of (frequency [Hz], envelope) by engine, frequencies rising.

    The frequency is None, and the only one, for an engine that chooses its own steps.

    Args:
        at_rest: nothing may move by 1 mm or half a degree, instead of a label's thresholds.
    """
    file = own_file("steadyload.methods", ENVELOPES)
    which = "rests" if at_rest else "holds"
    found = stored_object(file, REMEDY)
    try:
        return {name: _rows(entry["rows"], which) for name, entry in found.items()}
    except (LookupError, TypeError):
        raise StoredFileError(file, REMEDY) from None


def _rows(rows: list[dict[str, Any]], which: str) -> tuple[tuple[float | None, Envelope], ...]:
    return tuple((row["frequency"], Envelope(**row[which])) for row in rows)


def envelope(engine: str, frequency: float | None, *, at_rest: bool = False) -> Envelope | None:
    """Envelope of an engine at a frequency: the row measured at it, or at the next one below.

    Args:
        engine: a registered name.
        frequency: substeps a second [Hz]; of no matter for an engine that chooses its own steps.
        at_rest: see :func:`envelopes`.

    Returns:
        None where nothing was measured: for that engine, or at so low a frequency.
    """
    found = None
    for measured_at, row in envelopes(at_rest=at_rest).get(engine, ()):
        if measured_at is None or (frequency is not None and measured_at <= frequency + 1e-9):
            found = row
    return found


def envelope_of(method: Method, *, at_rest: bool = False) -> Envelope | None:
    """The envelope of the engine and frequency that a method uses; None for one without."""
    if method.spec.engine is None:
        return None
    frequency = getattr(method.parameters, "frequency", None)
    return envelope(method.spec.engine, frequency, at_rest=at_rest)


def extent(layout: Layout) -> Extent:
    """Extent of a layout; takes a tenth of a millisecond for tens of items."""
    contacts, weights, base = layout.contacts, layout.weights, layout.lower[:, 1]
    rising = np.argsort(base[contacts.above], kind="stable")
    rising = rising[contacts.below[rising] != FLOOR]
    above, below, areas = (of[rising] for of in (contacts.above, contacts.below, contacts.areas))
    pairs = list(zip(above.tolist(), below.tolist(), strict=True))
    return replace(
        farthest(layout),
        height=_longest_chain(len(layout), pairs),
        heavy_on_light=float((weights[above] / weights[below]).max(initial=1.0)),
        light_on_heavy=float((weights[below] / weights[above]).max(initial=1.0)),
        load=float((_loads(weights, pairs, areas) / weights).max()),
    )


def farthest(layout: Layout) -> Extent:
    """Bounds of the extent of a layout, whatever stands on what; no contacts are looked for."""
    weights, edges = layout.weights, layout.upper - layout.lower
    most, least = float(weights.max()), float(weights.min())
    return Extent(
        height=len(layout),
        heavy_on_light=most / least,
        light_on_heavy=most / least,
        load=(float(weights.sum()) - least) / least,
        thinnest=float(edges.min()),
        longest=float(edges.max()),
        item_count=len(layout),
    )


_Pairs = Sequence[tuple[int, int]]
"""Items, and one that each stands on, from the lowest base to the highest."""


def _longest_chain(count: int, pairs: _Pairs) -> int:
    """Items of the longest chain of items that stand on each other."""
    heights = [1] * count
    for above, below in pairs:
        heights[above] = max(heights[above], heights[below] + 1)
    return max(heights)


def _loads(weights: FloatArray, pairs: _Pairs, areas: FloatArray) -> FloatArray:
    """The weight that rests on every item [kg], shape (J,), spread by the contact areas of pairs.

    Args:
        weights: of the items.
        pairs: of items.
        areas: of their contacts.
    """
    carried = [0.0] * len(weights)
    for (above, _), area in zip(pairs, areas.tolist(), strict=True):
        carried[above] += area
    own, loads = weights.tolist(), [0.0] * len(weights)
    for (above, below), area in zip(reversed(pairs), reversed(areas.tolist()), strict=True):
        loads[below] += area / carried[above] * (loads[above] + own[above])
    return np.array(loads)


def beyond(extent: Extent, held: Envelope, frame: Frame | None = None) -> dict[Limit, str]:
    """In which ways an extent goes beyond an envelope: a sentence each.

    A load is compared with that on the lowest cube of the tallest tower, too. Lengths are in the
    unit of the frame.
    """
    frame = frame or Frame()
    load = max(held.heavy_on_light, held.tower_height - 1.0)
    found = {
        Limit.FALLS: "a plate beyond an edge is not seen to fall" if not held.sees_falls else "",
        Limit.HEIGHT: _more("{} items on top of each other", extent.height, held.tower_height),
        Limit.HEAVY: _more(
            "an item {} times as heavy as one below it", extent.heavy_on_light, held.heavy_on_light
        ),
        Limit.LOAD: _more("a load of {} times the weight of the item below it", extent.load, load),
        Limit.LIGHT: _more(
            "an item {} times as heavy as one on top of it",
            extent.light_on_heavy,
            held.light_on_heavy,
        ),
        Limit.THIN: _less(
            f"a thinnest edge of {{}} {frame.unit}",
            extent.thinnest / frame.cm,
            held.least_size / frame.cm,
        ),
        Limit.LONG: _more(
            f"a longest edge of {{}} {frame.unit}",
            extent.longest / frame.cm,
            held.most_size / frame.cm,
        ),
        Limit.COUNT: _more("{} items", extent.item_count, held.item_count),
    }
    return {limit: sentence for limit, sentence in found.items() if sentence}


def leaves(
    layout: Layout, method: Method, *, at_rest: bool = False, frame: Frame | None = None
) -> tuple[str, ...]:
    """In which ways a layout leaves the envelope of the engine and frequency that a method uses.

    Args:
        layout: any layout.
        method: any method.
        at_rest: see :func:`envelopes`.
        frame: unit of the sentences.

    Returns:
        A sentence each; none for a method without an engine, or where nothing was measured
        (:func:`envelope_of` tells these apart from a layout that stays inside).
    """
    held = envelope_of(method, at_rest=at_rest)
    if held is None or not beyond(farthest(layout), held):
        return ()
    return tuple(beyond(extent(layout), held, frame).values())


_ROUNDING = 1e-9
"""Edges are differences of corners: 10.000000000000002 cm is 10 cm."""


def _more(what: str, found: float, most: float) -> str:
    if found <= most * (1.0 + _ROUNDING):
        return ""
    held = f"up to {most:.4g}" if most else "at none"
    return f"{what.format(f'{found:.4g}')}; measured to hold {held}"


def _less(what: str, found: float, least: float) -> str:
    # A range that holds nothing is said once, by its upper end.
    if not least or found >= least * (1.0 - _ROUNDING):
        return ""
    return f"{what.format(f'{found:.4g}')}; measured to hold down to {least:.4g}"
