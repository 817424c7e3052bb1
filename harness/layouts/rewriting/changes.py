"""A changed plan, and the boxes of a parsed file with the numbers that it changes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from operator import itemgetter
from typing import Any

from steadyload.escaping import shown
from steadyload.layouts.files.record import FormatError
from steadyload.layouts.model.layout import Item, Layout, LayoutError
from steadyload.layouts.model.naming import box_label

SAME = 1e-6
"""Lengths [cm] that differ by no more are the same, and what states them stays."""

DECIMALS = 6
"""Of a length [cm] that is written."""

_FIXED = 3
"""Decimals that a file may have for all numbers alike; more come of a conversion."""

POSITION = ("x", "y", "z")
SIDES = ("width", "height", "depth")
OFFSETS = ("offset_x", "offset_y", "offset_z")
_KEYS = (*POSITION, *SIDES, *OFFSETS, "sequence")

Path = tuple[Any, ...]
"""Keys and places by which one comes from a box to a number of it."""


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
class Form:
    """How a parsed file states boxes, each of which is a list or a mapping.

    Attributes:
        paths: of the numbers of a box, by the keys of an item of a record; a box may lack some.
        write: what stands for a number: of its key, its value [cm] or sequence number, and what
            stood there before.
        by_place: the order of the boxes is that of loading.
        centre: positions are those of centres.
        code: path of the letters of axes by which a box is turned, of which a quarter turn about
            the vertical swaps the first two; None where the file has none.
        axes: these letters.
    """

    paths: Mapping[str, Path]
    write: Callable[[str, float, Any], Any]
    by_place: bool = False
    centre: bool = False
    code: Path | None = None
    axes: str = ""


def is_changed(items: Sequence[Mapping[str, Any]], plan: Replanned) -> bool:
    """Whether a plan differs from the one that the reader has read, item by item of the record."""
    before = sorted(items, key=itemgetter("sequence"))
    return plan.origins != tuple(range(len(items))) or any(
        abs(new - old) > SAME
        for stated, item in zip(before, plan.layout.items, strict=True)
        for old, new in zip(_stated(stated).values(), _numbers(item).values(), strict=True)
    )


def changed_boxes(
    boxes: Sequence[Any], items: Sequence[Mapping[str, Any]], plan: Replanned, form: Form
) -> list[Any]:
    """The boxes of a changed plan, in the order of the file; they are changed in place.

    Args:
        boxes: all of the plan as it was read, in the order of the file.
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
    kept = []
    for box, stated, step in zip(boxes, items, steps, strict=True):
        if step not in new:
            continue
        try:
            _change(box, stated, new[step], form)
        except LayoutError as error:
            label = box_label(step, str(stated.get("name", "")))
            raise error.located(layout=plan.layout.name, item=label) from None
        kept.append((new[step].sequence, box))
    return [box for _, box in (sorted(kept, key=itemgetter(0)) if form.by_place else kept)]


def _change(box: Any, stated: Mapping[str, Any], item: Item, form: Form) -> None:
    """Change the numbers of a box that are no longer the same."""
    old, new = _stated(stated), _numbers(item)
    turned = abs(new["width"] - old["width"]) > SAME
    if form.centre:
        for axis, side in zip(POSITION, SIDES, strict=True):
            old[axis] += old[side] / 2.0
            new[axis] += new[side] / 2.0
    there = {key: found for key, path in form.paths.items() for found in _at(box, path)}
    for key, before in there.items():
        if abs(new[key] - old[key]) <= SAME:
            continue
        # A side that was turned is stated as it was.
        own = [there[s] for s in SIDES if key in SIDES and abs(new[key] - old[s]) <= SAME]
        _put(box, form.paths[key], own[0] if own else form.write(key, new[key], before))
    if turned and form.code is not None:
        for code in _at(box, form.code):
            _put(box, form.code, _turned(code, form.axes))


def _stated(box: Mapping[str, Any]) -> dict[str, float]:
    """The numbers of an item of a record."""
    return {key: float(box.get(key, 0.0)) for key in _KEYS}


def _numbers(item: Item) -> dict[str, float]:
    """The same of an item of a layout."""
    values = (*item.position, *item.size, *item.mass_offset, item.sequence)
    return dict(zip(_KEYS, map(float, values), strict=True))


def _at(box: Any, path: Path) -> Iterator[Any]:
    """The value at the end of a path; none where the box has no such number."""
    for step in path:
        if box is None or (isinstance(box, Mapping) and step not in box):
            return
        box = box[step]
    yield box


def _put(box: Any, path: Path, value: Any) -> None:
    for step in path[:-1]:
        box = box[step]
    box[path[-1]] = value


def _turned(code: object, axes: str) -> str:
    """The code of the same box after a quarter turn; that of one without a code stays empty."""
    if not isinstance(code, str) or (code and sorted(code) != sorted(axes)):
        raise FormatError(
            f"is turned, and states how by {shown(code)}; allowed: the letters {', '.join(axes)} "
            "in some order, or another format for the changed plan, such as native"
        )
    return code[1:2] + code[:1] + code[2:]


def number_text(value: float, decimals: int, old: str, mark: str = ".") -> str:
    """A number to so many decimals at most, and no fewer than the few of what it replaces."""
    rounded = f"{value:.{decimals}f}"
    whole, _, fraction = rounded.partition(".")
    has = len(old.replace(",", ".").partition(".")[2]) if "e" not in old.casefold() else 0
    fraction = fraction.rstrip("0").ljust(min(has, _FIXED), "0")
    whole = "0" if whole == "-0" and not fraction.strip("0") else whole
    return f"{whole}{mark}{fraction}" if fraction else whole
