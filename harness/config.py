"""Fields of a configuration: quantities with their form on the command line."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Collection
from types import MappingProxyType
from typing import Any

from steadyload.engines.quantities import quantity
from steadyload.numbers import POSITIVE, is_positive

NAMES, METAVAR, READ, OPERAND, FEWEST, BARE = (
    "names", "metavar", "read", "operand", "fewest", "bare"
)  # fmt: skip
"""Keys of a field's metadata, beside those of :func:`steadyload.engines.quantities.quantity`."""


def option(
    default: Any,
    about: str,
    *,
    names: tuple[str, ...] = (),
    metavar: str = "",
    unit: str = "",
    least: float = -math.inf,
    most: float = math.inf,
    choices: Collection[str] | str = (),
    read: Callable[[str], Any] | None = None,
    fewest: int | None = None,
    bare: str | None = None,
) -> Any:
    """A field of a configuration: its default, its meaning, and its form as a flag.

    Args:
        default: ``dataclasses.MISSING`` where it has to be given.
        about: its meaning; the command's help prints it.
        names: flags, such as ``("--method", "-m")``; else the field's name with dashes.
        metavar: placeholder of the value in the help; else a word for its type.
        unit: of a number.
        least: smallest number that is allowed.
        most: largest number that is allowed.
        choices: allowed words, or ``"module:name"`` of a collection or an enumeration of them,
            which is imported when they are needed.
        read: converts the text after the flag to the value; raises ValueError to refuse it.
        fewest: of a tuple, the smallest number of values after one flag; else one value follows,
            and the flag is repeated.
        bare: the value of a flag without a text after it.
    """
    return _named(
        quantity(default, about, unit=unit, least=least, most=most, choices=choices),
        {NAMES: names, METAVAR: metavar, READ: read, FEWEST: fewest, BARE: bare, OPERAND: False},
    )


def operand(
    default: Any,
    about: str,
    *,
    metavar: str,
    read: Callable[[str], Any] | None = None,
) -> Any:
    """A positional field without a flag; the last one may be a tuple of one value or more."""
    return _named(
        quantity(default, about),
        {NAMES: (), METAVAR: metavar, READ: read, FEWEST: None, BARE: None, OPERAND: True},
    )


def methods_option(about: str) -> Any:
    """A field of spec strings of methods; the flag ``--method``, ``-m`` is repeated."""
    return option((), about, names=("--method", "-m"), metavar="SPEC")


def set_option(default: str = "") -> Any:
    """A field for a labelled set, as :func:`steadyload.layouts.benchmark.dataset.set_named` takes.

    Args:
        default: a word of the package, or empty for its large set.
    """
    about = "folder of a labelled set, or a set of the package, such as lists"
    return option(default, f"{about} (default: {default or 'the large one'})", metavar="DIR")


REQUIRED = dataclasses.MISSING
"""The default of a field that must be given."""


def _named(made: Any, more: dict[str, Any]) -> Any:
    made.metadata = MappingProxyType({**made.metadata, **more})
    return made


def positive_number(text: str) -> float:
    """A number from text: one of :func:`steadyload.numbers.is_positive`.

    Raises:
        ValueError: the text is no such number.
    """
    value = _number(text)
    if not is_positive(value):
        raise ValueError(f"{text!r}; allowed: a number {POSITIVE}")
    return value


def number_from_zero(text: str) -> float:
    """A number of 0 or more, below 100,000, from text.

    Raises:
        ValueError: the text is no such number.
    """
    value = _number(text)
    if not 0.0 <= value < 1e5:
        raise ValueError(f"{text!r}; allowed: a number, 0 or more, below 100,000")
    return value


def _number(text: str) -> float:
    """The number that a text states; not a number where it states none."""
    try:
        return float(text)
    except ValueError:
        return math.nan
