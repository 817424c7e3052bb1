"""Changed plans in ACLPP schedules."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence

import yaml

from steadyload.layouts.files.plain_yaml import composed, serialized
from steadyload.layouts.files.record import Record, Refused
from steadyload.layouts.rewriting.changes import (
    DECIMALS,
    Form,
    Replanned,
    changed_boxes,
    number_text,
)

_HEAD = re.compile(r"(?:[ \t]*(?:#.*)?\r?\n)*")
"""Comments before the first value."""


class _Mapping(dict[str, yaml.Node]):
    """A mapping of a schedule by name."""

    def __init__(self, node: yaml.MappingNode) -> None:
        super().__init__(_members(node))
        self._node = node

    def put_back(self) -> yaml.MappingNode:
        """The node, with the values that stand here by now."""
        self._node.value = [(key, self[key.value]) for key, _ in self._node.value]
        return self._node


def _number(value: float, old: yaml.ScalarNode) -> yaml.ScalarNode:
    """A number in the place of another."""
    text = number_text(value, DECIMALS, old.value)
    return yaml.ScalarNode(f"tag:yaml.org,2002:{'float' if '.' in text else 'int'}", text)


_FORM = Form(
    {
        "x": ("start_lat",), "y": ("start_height",), "z": ("start_lng",),
        "width": ("lat",), "height": ("height",), "depth": ("lng",),
    },
    lambda _key, value, old: _number(value, old),
    by_place=True,
)  # fmt: skip


def changed_yaml(
    text: str, records: Sequence[Record | Refused], plans: Mapping[str, Replanned]
) -> str:
    """The text of a schedule with changed plans: loaded pieces, offloads, and weights of devices.

    Comments before the first value stay; others are lost, since PyYAML reads none.

    Raises:
        LayoutError: the schedule cannot state a plan.
    """
    content = composed(text)
    left = iter(records)
    for segment in _members(_members(content)["segments"]).values():
        parts = _members(segment)
        gone = Counter[tuple[str, str]]()
        for device in _members(parts.get("built_ulds")).values():
            record = next(left)
            if isinstance(record, Record) and record.name in plans:
                gone.update(_change(device, record, plans[record.name]))
        if gone and isinstance(parts.get("offloads"), yaml.MappingNode):
            _offload(parts["offloads"], gone)
    head = _HEAD.match(text)
    written = serialized(content)
    return (head[0] if head else "") + (
        written.replace("\n", "\r\n") if "\r\n" in text else written
    )


def _change(device: yaml.Node, record: Record, plan: Replanned) -> list[tuple[str, str]]:
    """Change a device; the tags and texts of the pieces that are left out."""
    built = _Mapping(device)
    boxes = [_Mapping(node) for node in built["loaded"].value]
    kept = changed_boxes(boxes, record.items, plan, _FORM)
    built["loaded"].value = [box.put_back() for box in kept]
    out = [item for item in record.items if item["sequence"] not in plan.kept]
    weight, total = sum(item["weight"] for item in out), built.get("total_weight")
    if weight and isinstance(total, yaml.ScalarNode) and re.fullmatch(r"\d+(\.\d+)?", total.value):
        built["total_weight"] = _number(float(total.value) - weight, total)
        built.put_back()
    pieces = [boxes[item["sequence"]]["piece"] for item in out]
    return [(piece.tag, piece.value) for piece in pieces]


def _offload(node: yaml.MappingNode, gone: Mapping[tuple[str, str], int]) -> None:
    """Count the pieces that are not loaded."""
    stated = {(key.tag, key.value): value for key, value in node.value}
    for (tag, piece), count in gone.items():
        before = stated.get((tag, piece))
        if before is not None:
            before.value = str(int(before.value) + count)
        else:
            number = yaml.ScalarNode("tag:yaml.org,2002:int", str(count))
            node.value.append((yaml.ScalarNode(tag, piece), number))


def _members(node: yaml.Node | None) -> dict[str, yaml.Node]:
    pairs = node.value if isinstance(node, yaml.MappingNode) else ()
    return {key.value: value for key, value in pairs}
