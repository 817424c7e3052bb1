"""Fields that say what they mean: unit, range and meaning stand beside the default, once."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection
from typing import Any


def quantity(
    default: Any,
    about: str,
    *,
    unit: str = "",
    least: float = -math.inf,
    most: float = math.inf,
    choices: Collection[str] = (),
) -> Any:
    """A field of a dataclass of parameters: its default, meaning, unit and inclusive range.

    ``choices`` are the names that a field of type ``frozenset[str]`` may hold.
    """
    metadata = {"about": about, "unit": unit, "least": least, "most": most, "choices": choices}
    if isinstance(default, frozenset):
        return dataclasses.field(default_factory=lambda: default, metadata=metadata)
    return dataclasses.field(default=default, metadata=metadata)
