"""Names of boxes in messages: by their ids, where they have some, and by their turns."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

_ITEM = re.compile(r"\bitem ([0-9]{1,9})\b")
_LONGEST = 60
_ENDINGS = {1: "st", 2: "nd", 3: "rd"}


class Named(Protocol):
    """A box with an id, which is empty where it has none."""

    @property
    def name(self) -> str:
        """The id."""


@dataclass(frozen=True)
class _Nameless:
    name: str = ""


NAMELESS = _Nameless()
"""A box without an id."""


def box_label(step: int, name: str, count: int | None = None) -> str:
    """A box as messages name it: "box SKU-2002 (6th of 60)", and "box 6 of 60" without an id.

    Args:
        step: of the box, from 0.
        name: its id; empty where it has none.
        count: boxes of the layout; None where that is not known: "box SKU-2002 (6th)", and
            "item 5" without an id.
    """
    named = bool(name) and name.isprintable()
    if step < 0 or (count is None and not named):
        return f"item {step}"
    if not named:
        return f"box {step + 1} of {count}"
    short = name if len(name) <= _LONGEST else name[: _LONGEST - 3] + "..."
    of_all = "" if count is None else f" of {count}"
    return f"box {short} ({ordinal(step + 1)}{of_all})"


def label_in(items: Sequence[Named], step: int) -> str:
    """See :func:`box_label`, of a box of a layout.

    Args:
        items: of the layout.
        step: of the box.
    """
    return box_label(step, items[step].name, len(items))


def ordinal(number: int) -> str:
    """A number from 1 in a sentence: "1st", "22nd", "113th"."""
    last = 0 if 10 <= number % 100 < 20 else number % 10
    return f"{number}{_ENDINGS.get(last, 'th')}"


def box_id(items: Sequence[Named], step: int | None) -> str | None:
    """The id of the box of a step; None for no step, and without an id."""
    return items[step].name or None if step is not None and step < len(items) else None


def with_ids(sentence: str, items: Sequence[Named]) -> str:
    """A sentence of a method in which boxes that have ids are named by them.

    Methods name boxes by their steps, so that what they say of equal layouts is equal.
    """

    def label(found: re.Match[str]) -> str:
        step = int(found[1])
        return label_in(items, step) if step < len(items) else found[0]

    return _ITEM.sub(label, sentence)
