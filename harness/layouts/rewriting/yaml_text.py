"""Changed plans in the text of ACLPP schedules."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence

import yaml

from steadyload.layouts.files.plain_yaml import composed
from steadyload.layouts.files.record import Record, Refused
from steadyload.layouts.rewriting.edits import (
    Edit,
    Entry,
    Form,
    Replanned,
    Span,
    list_cuts,
    number_text,
    plan_edits,
)

_DECIMALS = 6
_KEYS = {
    "x": "start_lat", "y": "start_height", "z": "start_lng",
    "width": "lat", "height": "height", "depth": "lng",
}  # fmt: skip


def aclpp_edits(
    text: str, records: Sequence[Record | Refused], plans: Mapping[str, Replanned]
) -> list[Edit]:
    """Edits of a schedule: loaded pieces, and of what is left out the offloads and the weight.

    Raises:
        LayoutError: the schedule cannot state a plan.
    """
    edits: list[Edit] = []
    left = iter(records)
    for segment in _members(_members(composed(text))["segments"]).values():
        parts = _members(segment)
        gone = Counter[str]()
        for device in _members(parts.get("built_ulds")).values():
            record = next(left)
            if isinstance(record, Record) and record.name in plans:
                plan = plans[record.name]
                built = _members(device)
                nodes = built["loaded"].value
                edits += _loaded(text, nodes, record, plan)
                out = [item for item in record.items if item["sequence"] not in plan.kept]
                gone.update(
                    _text_of(text, _members(nodes[item["sequence"]])["piece"]) for item in out
                )
                weight = sum(item["weight"] for item in out)
                edits += _lighter(built.get("total_weight"), weight)
        if gone and isinstance(parts.get("offloads"), yaml.MappingNode):
            edits += _offloads(text, parts["offloads"], gone)
    return edits


def _loaded(
    text: str, nodes: Sequence[yaml.Node], record: Record, plan: Replanned
) -> Iterable[Edit]:
    spans = [_span(text, node) for node in nodes]
    cuts = list_cuts(spans, [item["sequence"] in plan.kept for item in record.items])
    numbers = [
        {key: _span(text, _members(node)[name]) for key, name in _KEYS.items()} for node in nodes
    ]
    entries = [Entry(*each) for each in zip(spans, cuts, numbers, strict=True)]
    return plan_edits(text, entries, record.items, plan, Form(_written, by_place=True))


def _written(_key: str, value: float, old: str) -> str:
    return number_text(value, _DECIMALS, old)


def _lighter(node: yaml.Node | None, weight: float) -> Iterator[Edit]:
    """Edit of a device's weight, where it has one."""
    if weight and isinstance(node, yaml.ScalarNode) and re.fullmatch(r"\d+(\.\d+)?", node.value):
        text = number_text(float(node.value) - weight, _DECIMALS, node.value)
        yield Edit(Span(node.start_mark.index, node.end_mark.index), text)


def _offloads(text: str, node: yaml.MappingNode, gone: Mapping[str, int]) -> Iterator[Edit]:
    """Edits of the counts of pieces that are not loaded."""
    stated = {_text_of(text, key): value for key, value in node.value}
    new = []
    for piece, count in gone.items():
        if piece in stated:
            yield Edit(_span(text, stated[piece]), str(int(stated[piece].value) + count))
        else:
            new.append(f"{piece}: {count}")
    if not new:
        return
    if node.flow_style:
        at = node.end_mark.index - 1
        yield Edit(Span(at, at), (", " if stated else "") + ", ".join(new))
    else:
        at = _span(text, node).end
        line = ("\r\n" if "\r\n" in text else "\n") + " " * node.start_mark.column
        yield Edit(Span(at, at), "".join(line + each for each in new))


def _members(node: yaml.Node | None) -> dict[str, yaml.Node]:
    pairs = node.value if isinstance(node, yaml.MappingNode) else ()
    return {key.value: value for key, value in pairs}


def _span(text: str, node: yaml.Node) -> Span:
    """Where a node stands, without the space after it, which PyYAML counts to blocks."""
    start, end = node.start_mark.index, node.end_mark.index
    return Span(start, start + len(text[start:end].rstrip()))


def _text_of(text: str, node: yaml.Node) -> str:
    return text[slice(*_span(text, node))]
