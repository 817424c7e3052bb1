"""Boxes in tables of scores: the failing one by its id."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from steadyload.layouts.model.naming import box_label


def named_reason(record: Mapping[str, Any]) -> str:
    """The reason of a record's verdict, with the box of the failing step, if it has an id."""
    reason, box = str(record["reason"]), record["failing_box"]
    if box is None:
        return reason
    label = box_label(record["failing_step"], box)
    return reason if label in reason else ": ".join(filter(None, (label, reason)))
