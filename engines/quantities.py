"""Fields of parameters: default, unit, range and meaning are declared once, in one place."""

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
    later: bool = False,
) -> Any:
    """A field of a dataclass of parameters: its default, meaning, unit and inclusive range.

    ``choices`` are the names that a field of type ``frozenset[str]`` may hold. ``later``: the
    parameter was added when there were stored verdicts, and its default changes none of them: they
    stay valid.
    """
    metadata = {
        "about": about,
        "unit": unit,
        "least": least,
        "most": most,
        "choices": choices,
        "later": later,
    }
    if isinstance(default, frozenset):
        return dataclasses.field(default_factory=lambda: default, metadata=metadata)
    return dataclasses.field(default=default, metadata=metadata)


def check_ranges(made: Any) -> None:
    """Refuse a dataclass of quantities whose numbers are not in their ranges; None is no number.

    Raises:
        ValueError: a number is out of its range, or not a number.
    """
    for field in dataclasses.fields(made):
        value = getattr(made, field.name)
        if value is None or isinstance(value, str):
            continue
        least, most = field.metadata["least"], field.metadata["most"]
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not least <= number <= most:
            told = value if math.isfinite(number) else number
            raise ValueError(f"{field.name} is {told}; allowed: {least:g} to {most:g}")
