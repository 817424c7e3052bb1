"""Entries than which no cheaper one is better."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeVar

T = TypeVar("T")


def undominated(
    entries: Iterable[T], cost: Callable[[T], float], loss: Callable[[T], float]
) -> list[T]:
    """Entries than which no cheaper one has as small a loss, by rising cost; of equals the first.

    Args:
        entries: what is compared.
        cost: a number that should be small.
        loss: another one.
    """
    found: list[T] = []
    for entry in sorted(entries, key=lambda one: (cost(one), loss(one))):
        if not found or loss(entry) < loss(found[-1]):
            found.append(entry)
    return found
