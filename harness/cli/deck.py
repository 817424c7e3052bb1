"""Flags of commands that read layouts: how far boxes may overhang the deck, and the floor."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from steadyload.studies.options import option


def _from_zero(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 <= value < 1e5:
        raise ValueError(f"{text!r}; allowed: a number, 0 or more")
    return value


@dataclass(frozen=True, kw_only=True)
class Deck:
    """Floor that boxes stand on, and how far they may stand out over its edges."""

    overhang: float | None = option(
        None, "how far boxes may overhang the deck (default: as in the file, else 10)",
        metavar="CM", read=_from_zero,
    )  # fmt: skip
    floor: str | None = option(
        None, "what boxes stand on: the deck, beyond whose edges nothing carries, an infinite "
        "plane, or the deck where a box overhangs it (default: as in the file, else auto)",
        choices="steadyload.layouts.floor:FloorKind",
    )  # fmt: skip

    @property
    def deck(self) -> dict[str, Any]:
        """Arguments on the deck of whoever reads layouts."""
        return {"overhang": self.overhang, "floor": self.floor}
