"""Failing steps and items placed safely: one outcome of a loading, stated in two ways.

Steps count from 0. A load that fails at step k has k items placed safely; a stable load has no
failing step, and all of its items are placed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd


def items_placed(failing_step: int | None, item_count: int) -> int:
    """Number of items placed safely.

    Args:
        failing_step: None for a stable load.
        item_count: of the load.
    """
    return item_count if failing_step is None else failing_step


def failing_step_of(placed: int, item_count: int) -> int | None:
    """The failing step; None for a stable load.

    Args:
        placed: number of items placed safely.
        item_count: of the load.
    """
    return placed if placed < item_count else None


def items_placed_by_case(failing_steps: pd.Series, item_counts: pd.Series) -> pd.Series:
    """Number of items placed safely in every case of a table, as 64-bit integers.

    Args:
        failing_steps: missing where the load is stable, and where there is no verdict.
        item_counts: of the same cases.
    """
    return failing_steps.astype("Int64").fillna(item_counts.astype("Int64")).astype("int64")
