"""Units in which files may state lengths and weights."""

from __future__ import annotations

from collections.abc import Mapping
from decimal import Decimal

UNITS: Mapping[str, Decimal] = {
    "mm": Decimal("0.1"), "cm": Decimal(1), "m": Decimal(100), "in": Decimal("2.54"),
}  # fmt: skip
"""Units of lengths, in centimetres."""

WEIGHT_UNITS: Mapping[str, Decimal] = {
    "g": Decimal("0.001"), "kg": Decimal(1), "lb": Decimal("0.45359237"),
}  # fmt: skip
"""Units of weights, in kilograms."""
