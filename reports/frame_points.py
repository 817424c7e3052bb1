"""Series of results as the points of charts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from steadyload.statistics.estimate import NOTHING, Estimate


def is_missing(value: Any) -> bool:
    """Whether a cell of a frame of results has no value."""
    if isinstance(value, Estimate | Mapping):
        return False
    return value is None or bool(pd.isna(value))


def cells(
    found: pd.Series, lines: Mapping[Any, str], places: Mapping[Any, str]
) -> list[dict[str, Any]]:
    """Estimates by two things as the cells of a chart of kind ``heat``.

    Args:
        found: by two levels.
        lines: what stands beside the chart, by value of the first level: the order of its rows.
        places: what stands below it, by value of the second level.
    """
    return [
        {
            "line": line,
            "place": place,
            "value": NOTHING if is_missing(one := found.get((row, column))) else one,
        }
        for row, line in lines.items()
        for column, place in places.items()
    ]


def points(found: pd.DataFrame, x: Mapping[Any, Any], values: pd.Series) -> list[dict[str, Any]]:
    """Values by method and something else as the points of a chart of kind ``curves``.

    Args:
        found: a row a method, with ``key`` and ``title``.
        x: place on the axis, by value of the second level.
        values: by method and that; missing where there is no point.
    """
    return [
        {"key": row.key, "title": row.title, "x": place, "value": values[row.Index, at]}
        for row in found.itertuples()
        for at, place in dict(x).items()
        if (row.Index, at) in values.index and not is_missing(values[row.Index, at])
    ]
