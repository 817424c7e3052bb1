"""Numbers that callers of the library give: one check for all of them."""

from __future__ import annotations

import math
from typing import Any

from steadyload.errors import UserError
from steadyload.escaping import shown

_LIMIT = 1e9

POSITIVE = f"above 0 and below {_LIMIT:,.0f}"
"""The range of :func:`is_positive` in words."""


class NumberError(UserError):
    """A value that is no number, is not finite, or is out of range; says what is allowed."""


def number_within(
    name: str,
    value: Any,
    least: float = -math.inf,
    most: float = math.inf,
    *,
    unit: str = "",
    error: type[UserError] = NumberError,
) -> float:
    """A finite number, as a float.

    Args:
        name: of the value, for the message.
        value: as given.
        least: smallest number that is allowed.
        most: largest number that is allowed.
        unit: of the number, for the message.
        error: what is raised.

    Raises:
        UserError: of the class ``error``: the value is not such a number.
    """
    number = _number(value)
    if not (math.isfinite(number) and least <= number <= most):
        raise error(
            f"{name} is {shown(value)}; allowed: {_range(least, most)}{unit and ' ' + unit}"
        )
    return number


def is_positive(number: float) -> bool:
    """True for a number above 0 that is small enough for a limit on a time [s]."""
    return 0.0 < number < _LIMIT


def seconds_allowed(value: Any, name: str = "timeout") -> float | None:
    """A limit on a time [s]: a number as :func:`is_positive` allows, or None for no limit.

    Raises:
        NumberError: it is another value.
    """
    if value is None:
        return None
    number = _number(value)
    if not is_positive(number):
        raise NumberError(
            f"{name} is {shown(value)}; allowed: a number of seconds {POSITIVE}, or None for no "
            "limit"
        )
    return number


def seconds_above_zero(name: str, value: Any) -> float:
    """A time [s] that has to be limited: a number as :func:`is_positive` allows.

    Raises:
        NumberError: it is another value, such as None.
    """
    number = _number(value)
    if not is_positive(number):
        raise NumberError(f"{name} is {shown(value)}; allowed: a number of seconds {POSITIVE}")
    return number


def _number(value: Any) -> float:
    """The value as a float; not a number where it is none that a float can hold."""
    if isinstance(value, bool | str | bytes):
        return math.nan
    try:
        return float(value)
    except (OverflowError, TypeError, ValueError):
        return math.nan


def _range(least: float, most: float) -> str:
    if math.isinf(most):
        return "a finite number" if math.isinf(least) else f"a finite number, {least:g} or more"
    return f"a finite number, {least:g} to {most:g}"
