"""Changes of a text: what is not named in one stays as it is, to the character."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from steadyload.escaping import shown
from steadyload.layouts.files.record import FormatError
from steadyload.layouts.model.layout import Item, Layout, LayoutError
from steadyload.layouts.model.naming import box_label

SAME = 1e-6
"""Lengths [cm] that differ by no more are the same, and their text stays."""

_FIXED = 3
"""Decimals that a file may have for all numbers alike; more come of a conversion."""

POSITION = ("x", "y", "z")
SIDES = ("width", "height", "depth")
OFFSETS = ("offset_x", "offset_y", "offset_z")


class Span(NamedTuple):
    """A part of a text."""

    start: int
    end: int


class Edit(NamedTuple):
    """A part of a text, and the text in its place."""

    span: Span
    text: str


@dataclass(frozen=True)
class Replanned:
    """A changed plan: boxes may be elsewhere, loaded in another order, turned a quarter about the
    vertical, or left out; nothing else of them may differ.

    Args:
        layout: the plan, under the name that it was read with.
        origins: for each item of ``layout``, the step of the same box in the plan as it was read.

    Raises:
        LayoutError: not one origin an item, or one stands there twice.
    """

    layout: Layout
    origins: tuple[int, ...]

    def __post_init__(self) -> None:
        if len(self.origins) != len(self.layout) or len({*self.origins}) != len(self.origins):
            raise LayoutError(
                f"has the origins {shown(self.origins)}; allowed: for each of its "
                f"{len(self.layout)} items another step",
                layout=self.layout.name,
            )

    @cached_property
    def kept(self) -> frozenset[int]:
        """Steps of the boxes that are not left out, in the plan as it was read."""
        return frozenset(self.origins)


@dataclass(frozen=True)
class Entry:
    """Where a text states a box.

    Attributes:
        span: of the row or the value that is the box's.
        cut: what goes with the box where it is left out.
        numbers: spans of its numbers, by the keys of an item of a record.
        code: letters of axes by which the box is turned, of which a quarter turn about the vertical
            swaps the first two; None where the file has none.
    """

    span: Span
    cut: Span
    numbers: Mapping[str, Span]
    code: Span | None = None


@dataclass(frozen=True)
class Form:
    """How a file states boxes.

    Attributes:
        write: text of a number: of its key, its value [cm] or sequence number, and the text that it
            replaces.
        by_place: the order of the boxes is that of loading.
        centre: positions are those of centres.
        axes: letters of a code of turning; empty where the file has none.
    """

    write: Callable[[str, float, str], str]
    by_place: bool = False
    centre: bool = False
    axes: str = ""


def applied(text: str, edits: Iterable[Edit], within: Span | None = None) -> str:
    """A text, or a part of it, with edits that do not overlap."""
    at, end = within or Span(0, len(text))
    parts = []
    for span, new in sorted(edits):
        parts += [text[at : span.start], new]
        at = span.end
    return "".join([*parts, text[at:end]])


def plan_edits(
    text: str,
    entries: Sequence[Entry],
    items: Sequence[Mapping[str, Any]],
    plan: Replanned,
    form: Form,
) -> list[Edit]:
    """Edits that make of a plan's boxes those of a changed plan; none where nothing differs.

    Args:
        text: of the file.
        entries: of the boxes, in the order of the file.
        items: what the reader has read of each: items of a record.
        plan: the changed plan.
        form: of the file.

    Raises:
        LayoutError: the file cannot state the plan.
    """
    steps = [int(item["sequence"]) for item in items]
    unknown = {*plan.origins} - {*steps}
    if unknown:
        raise LayoutError(
            f"has the origin {min(unknown)}; allowed: 0 to {len(steps) - 1}, the steps of the plan "
            "as it was read",
            layout=plan.layout.name,
        )
    new = dict(zip(plan.origins, plan.layout.items, strict=True))
    edits, texts, slots = [], {}, []
    for entry, stated, step in zip(entries, items, steps, strict=True):
        if step not in new:
            edits.append(Edit(entry.cut, ""))
            continue
        try:
            changes = _box_edits(text, entry, stated, new[step], form)
        except LayoutError as error:
            label = box_label(step, str(stated.get("name", "")))
            raise error.located(layout=plan.layout.name, item=label) from None
        texts[step] = applied(text, changes, entry.span)
        slots.append((entry, step))
    order = [step for _, step in slots]
    if form.by_place:
        order.sort(key=lambda step: new[step].sequence)
    for (entry, _), step in zip(slots, order, strict=True):
        if texts[step] != text[entry.span.start : entry.span.end]:
            edits.append(Edit(entry.span, texts[step]))
    return edits


def _box_edits(
    text: str, entry: Entry, stated: Mapping[str, Any], item: Item, form: Form
) -> list[Edit]:
    """Edits of the numbers of a box that are no longer the same."""
    old = {key: float(stated.get(key, 0.0)) for key in (*POSITION, *SIDES, *OFFSETS, "sequence")}
    values = (*item.position, *item.size, *item.mass_offset, item.sequence)
    new = dict(zip((*POSITION, *SIDES, *OFFSETS, "sequence"), map(float, values), strict=True))
    turned = abs(new["width"] - old["width"]) > SAME
    if form.centre:
        for axis, side in zip(POSITION, SIDES, strict=True):
            old[axis] += old[side] / 2.0
            new[axis] += new[side] / 2.0
    sides = {key: text[slice(*span)] for key, span in entry.numbers.items() if key in SIDES}
    edits = []
    for key, span in entry.numbers.items():
        if abs(new[key] - old[key]) <= SAME:
            continue
        # A side that was turned keeps its text.
        own = [told for side, told in sides.items() if abs(new[key] - old[side]) <= SAME]
        written = own[0] if own and key in SIDES else form.write(key, new[key], text[slice(*span)])
        edits.append(Edit(span, written))
    if turned and entry.code is not None:
        edits.append(Edit(entry.code, _turned(text[slice(*entry.code)], form.axes)))
    return edits


def _turned(code: str, axes: str) -> str:
    """The code of the same box after a quarter turn; that of one without a code stays empty."""
    if code and sorted(code) != sorted(axes):
        raise FormatError(
            f"is turned, and states how by {shown(code)}; allowed: the letters {', '.join(axes)} "
            "in some order, or another format for the changed plan, such as native"
        )
    return code[1:2] + code[:1] + code[2:]


def list_cuts(spans: Sequence[Span], kept: Sequence[bool]) -> list[Span]:
    """Part to cut out of a list with each element: it, and a mark between two."""
    cuts, before = [], False
    for place, span in enumerate(spans):
        after = spans[place + 1].start if place + 1 < len(spans) else span.end
        cuts.append(Span(spans[place - 1].end, span.end) if before else Span(span.start, after))
        before = before or kept[place]
    return cuts


def number_text(value: float, decimals: int, old: str, mark: str = ".") -> str:
    """A number to so many decimals at most, and no fewer than the few of what it replaces."""
    rounded = f"{value:.{decimals}f}"
    whole, _, fraction = rounded.partition(".")
    has = len(old.replace(",", ".").partition(".")[2]) if "e" not in old.casefold() else 0
    fraction = fraction.rstrip("0").ljust(min(has, _FIXED), "0")
    whole = "0" if whole == "-0" and not fraction.strip("0") else whole
    return f"{whole}{mark}{fraction}" if fraction else whole
