"""Numbers that an engine may be given: whether they are finite and in their range."""

from __future__ import annotations

from typing import Any


def are_within(values: Any, least: float, most: float) -> bool:
    """True for three finite numbers in a range, both ends allowed."""
    try:
        three: tuple[Any, ...] = tuple(values)
    except TypeError:
        return False
    return len(three) == 3 and all(is_within(value, least, most) for value in three)


def is_within(value: Any, least: float, most: float) -> bool:
    """True for a number in a range, both ends allowed."""
    try:
        return bool(least <= value <= most)
    except (TypeError, ValueError):
        return False
