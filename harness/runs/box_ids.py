"""Ids of the boxes that a run's rows name by their steps: looked up in its layouts."""

from __future__ import annotations

import math
from pathlib import Path

import pandas as pd

from steadyload.layouts.formats import read_written
from steadyload.layouts.model.naming import box_id
from steadyload.runs.results import kept_layouts


def with_box_ids(rows: pd.DataFrame, directory: str | Path) -> pd.DataFrame:
    """Rows of a run with the ids of boxes, in the columns ``failing_box`` and ``moved_box``.

    Rows themselves hold no ids, so that they are kept whatever boxes are called.

    Args:
        rows: of :func:`steadyload.runs.results.load_results`, with the columns ``layout``,
            ``failing_step`` and ``moved_item``.
        directory: the run folder.

    Raises:
        ResultsError: the folder has no layouts, or damaged ones.
    """
    steps = {
        column: rows[number].to_numpy(dtype=float, na_value=math.nan)
        for column, number in (("failing_box", "failing_step"), ("moved_box", "moved_item"))
    }
    places = rows.groupby("layout").indices
    found: dict[str, list[str | None]] = {column: [None] * len(rows) for column in steps}
    for layout in read_written(kept_layouts(directory), places):
        for column, numbers in steps.items():
            for place in places[layout.name]:
                step = None if math.isnan(numbers[place]) else int(numbers[place])
                found[column][place] = box_id(layout.items, step)
    return rows.assign(**{name: pd.array(ids, dtype="string") for name, ids in found.items()})
