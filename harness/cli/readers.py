"""Values of flags from their texts: times, shares, settings; a ValueError refuses one."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from steadyload.config import number_of

_SECONDS = {"": 1.0, "s": 1.0, "m": 60.0, "h": 3600.0}
_MILLISECONDS = {"us": 1e-3, "ms": 1.0, "s": 1e3}


def duration(text: str) -> float:
    """Seconds, from ``90``, ``90s``, ``20m`` or ``1.5h``."""
    return _time(text, r"(\d+(?:\.\d+)?)([smh]?)", _SECONDS, "90s, 20m or 1.5h")


def milliseconds(text: str) -> float:
    """Milliseconds, from ``5ms``, ``0.01s`` or ``300us``."""
    return _time(text, r"(\d+(?:\.\d+)?|\.\d+)(us|ms|s)", _MILLISECONDS, "5ms, 0.01s or 300us")


def _time(text: str, form: str, units: Mapping[str, float], such_as: str) -> float:
    match = re.fullmatch(form, text)
    if match is None or not float(match[1]):
        raise ValueError(f"{text!r}; allowed: a time such as {such_as}")
    return float(match[1]) * units[match[2]]


def share(text: str) -> float:
    """A share above 0, from ``0.95`` or ``95%``."""
    match = re.fullmatch(r"(\d+(?:\.\d+)?|\.\d+)(%?)", text)
    value = float(match[1]) * (0.01 if match[2] else 1.0) if match else 0.0
    if not 0.0 < value <= 1.0:
        raise ValueError(f"{text!r}; allowed: above 0, to 1, or per cent")
    return value


def half_share(text: str) -> float:
    """A share from 0 to 0.5."""
    value = number_of(text)
    if not 0.0 <= value <= 0.5:
        raise ValueError(f"{text!r}; allowed: a number from 0 to 0.5")
    return value


def setting(text: str) -> tuple[str, str]:
    """Key and value, from ``KEY=VALUE``."""
    key, equals, value = text.partition("=")
    if not (key and equals and value):
        raise ValueError(f"{text!r}; allowed: KEY=VALUE, such as hidden=100")
    return key, value


def positive(text: str) -> float:
    """A number above 0."""
    value = number_of(text)
    if not 0.0 < value < math.inf:
        raise ValueError(f"{text!r}; allowed: a number above 0")
    return value
