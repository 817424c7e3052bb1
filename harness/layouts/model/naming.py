"""Names of boxes in messages: by their ids, where they have some, and by their steps."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Protocol

_ITEM = re.compile(r"\bitem ([0-9]{1,9})\b")
_LONGEST = 60


class Named(Protocol):
    """A box with an id, which is empty where it has none."""

    @property
    def name(self) -> str:
        """The id."""


def box_label(step: int | str, name: str) -> str:
    """A box as messages name it: "box SKU-2002 (step 5)", and "item 5" without an id."""
    if not name or not name.isprintable():
        return f"item {step}"
    return f"box {name if len(name) <= _LONGEST else name[: _LONGEST - 3] + '...'} (step {step})"


def box_id(items: Sequence[Named], step: int | None) -> str | None:
    """The id of the box of a step; None for no step, and without an id."""
    return items[step].name or None if step is not None and step < len(items) else None


def with_ids(sentence: str, items: Sequence[Named]) -> str:
    """A sentence of a method in which boxes that have ids are named by them.

    Methods name boxes by their steps, so that what they say of equal layouts is equal.
    """

    def label(found: re.Match[str]) -> str:
        step = int(found[1])
        return box_label(step, items[step].name) if step < len(items) else found[0]

    return _ITEM.sub(label, sentence)
