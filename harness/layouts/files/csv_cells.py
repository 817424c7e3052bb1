"""Cells of CSV files: texts that a spreadsheet takes for no formula, and numbers."""

from __future__ import annotations

import re
from decimal import Context, Decimal

from steadyload.layouts.files.limits import MAX_NUMBER_LENGTH

_FORMULA = re.compile(r"'*[=+\-@\t\r]")
_GUARDED = re.compile(r"'+[=+\-@\t\r]")

_NUMBER = re.compile(
    r"[+-]?(?:[0-9]+(?:[.,][0-9]*)?|[.,][0-9]+)(?:[eE][+-]?[0-9]{1,6})?|[+-]?(?:nan|inf|infinity)",
    re.I,
)
_EXACT = Context(prec=2 * MAX_NUMBER_LENGTH, traps=[])


def harmless(text: str) -> str:
    """A text as it is written to a cell: never the beginning of a formula.

    A spreadsheet evaluates a cell that begins with ``=``, ``+``, ``-`` or ``@``; an apostrophe
    before it prevents that. :func:`unguarded` takes it off again.
    """
    return f"'{text}" if _FORMULA.match(text) else text


def unguarded(cell: str) -> str:
    """The text of a cell that :func:`harmless` may have written."""
    return cell[1:] if _GUARDED.match(cell) else cell


def number(cell: str) -> Decimal | None:
    """The number that a cell states, with a decimal point or comma; None for another text."""
    text = cell.strip()
    if len(text) > MAX_NUMBER_LENGTH or not _NUMBER.fullmatch(text):
        return None
    return Decimal(text.replace(",", "."))


def times(value: Decimal, factor: Decimal) -> Decimal:
    """Exact product."""
    return _EXACT.multiply(value, factor)


def minus_half(value: Decimal, size: Decimal) -> Decimal:
    """Exact difference of a number and half of another."""
    return _EXACT.subtract(value, _EXACT.multiply(size, Decimal("0.5")))
