"""Changed plans in the text of steadyload JSON and of job files."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence

from steadyload.layouts.files.record import Record, Refused
from steadyload.layouts.rewriting.edits import (
    OFFSETS,
    POSITION,
    SIDES,
    Edit,
    Entry,
    Form,
    Replanned,
    Span,
    list_cuts,
    number_text,
    plan_edits,
)

_DECODER = json.JSONDecoder()
_BETWEEN = re.compile(r"[ \t\n\r,:]*")
_DECIMALS = 6


def native_edits(
    text: str, records: Sequence[Record | Refused], plans: Mapping[str, Replanned]
) -> list[Edit]:
    """Edits of a file of ours.

    Raises:
        LayoutError: the file cannot state a plan.
    """
    return _edits(text, records, plans, "layouts", "items", _native)


def job_edits(
    text: str, records: Sequence[Record | Refused], plans: Mapping[str, Replanned]
) -> list[Edit]:
    """Edits of a job file.

    Raises:
        LayoutError: the file cannot state a plan.
    """
    return _edits(text, records, plans, "ulds", "placedItems", _job)


def _edits(
    text: str,
    records: Sequence[Record | Refused],
    plans: Mapping[str, Replanned],
    layouts: str,
    items: str,
    numbers_of: Callable[[str, Span], dict[str, Span]],
) -> list[Edit]:
    """Edits of a file whose members of these names hold the layouts, and each the items."""
    edits = []
    for record, span in zip(records, elements(text, top(text)[layouts]), strict=True):
        if isinstance(record, Record) and record.name in plans:
            spans = elements(text, members(text, span)[items])
            numbers = [numbers_of(text, item) for item in spans]
            edits += _edits_of(text, spans, numbers, record, plans[record.name])
    return edits


def _native(text: str, span: Span) -> dict[str, Span]:
    stated = members(text, span)
    numbers = {"sequence": stated["sequence"]}
    for key, words in (("position", POSITION), ("size", SIDES), ("mass_offset", OFFSETS)):
        if key in stated:
            numbers |= zip(words, elements(text, stated[key]), strict=True)
    return numbers


def _job(text: str, span: Span) -> dict[str, Span]:
    stated = members(text, span)
    numbers = {key: stated[key] for key in ("sequence", *POSITION)}
    shape = members(text, stated["shape"])
    numbers |= {side: shape[side] for side in SIDES}
    if "centerOfMass" in stated and text[stated["centerOfMass"].start] == "{":
        offset = members(text, stated["centerOfMass"])
        numbers |= zip(OFFSETS, map(offset.__getitem__, POSITION), strict=True)
    return numbers


def _edits_of(
    text: str,
    spans: Sequence[Span],
    numbers: Iterable[Mapping[str, Span]],
    record: Record,
    plan: Replanned,
) -> list[Edit]:
    cuts = list_cuts(spans, [item["sequence"] in plan.kept for item in record.items])
    entries = [Entry(*each) for each in zip(spans, cuts, numbers, strict=True)]
    return plan_edits(text, entries, record.items, plan, Form(_written))


def _written(key: str, value: float, old: str) -> str:
    return str(int(value)) if key == "sequence" else number_text(value, _DECIMALS, old)


def members(text: str, span: Span) -> dict[str, Span]:
    """Values of an object of valid JSON, by name."""
    spans = elements(text, span)
    names = (json.loads(text[slice(*name)]) for name in spans[::2])
    return dict(zip(names, spans[1::2], strict=True))


def elements(text: str, span: Span) -> list[Span]:
    """Values of a list of valid JSON; those of an object with their names before them."""
    found = []
    at = _after(text, span.start + 1)
    while at < span.end - 1:
        end = _DECODER.raw_decode(text, at)[1]
        found.append(Span(at, end))
        at = _after(text, end)
    return found


def top(text: str) -> dict[str, Span]:
    """Members of the object that a text is."""
    start = text.index("{")
    return members(text, Span(start, text.rindex("}") + 1))


def _after(text: str, at: int) -> int:
    found = _BETWEEN.match(text, at)
    return found.end() if found else at
