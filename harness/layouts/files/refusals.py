"""Layouts that were refused while others were read: how many, and why the first of them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

_TOLD = 5


@dataclass
class Refusals:
    """Count of refused layouts, with the sentences of the first."""

    count: int = 0
    first: list[str] = field(default_factory=list)

    def add(self, reason: str) -> None:
        """Count one more."""
        self.count += 1
        if len(self.first) < _TOLD:
            self.first.append(reason)

    def sentences(self, read: int) -> list[str]:
        """Reasons of the first, then how many there are.

        Args:
            read: number of layouts that are valid.
        """
        if not self.count:
            return []
        more = self.count - len(self.first)
        rest = [f"... and {more} more"] if more else []
        total = self.count + read
        if total == 1:
            return self.first
        verb = "was" if self.count == 1 else "were"
        return [*self.first, *rest, f"{self.count} of {total} layouts {verb} refused"]

    def stated(self) -> dict[str, Any]:
        """The entry of a manifest."""
        return {"count": self.count, "first": self.first}

    @staticmethod
    def restated(entry: dict[str, Any] | None) -> Refusals:
        """Those of a manifest's entry; none where there is no entry."""
        return Refusals() if entry is None else Refusals(entry["count"], list(entry["first"]))
