"""Frames of results as tables of pages."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import pandas as pd

from steadyload.errors import nearest
from steadyload.reports import table as forms
from steadyload.reports.columns import TableError
from steadyload.reports.frame_columns import COLUMNS
from steadyload.reports.frame_points import is_missing
from steadyload.reports.table import MISSING, Column, Table
from steadyload.statistics.estimate import NOTHING

_ESTIMATES = {
    name
    for name, said in COLUMNS.items()
    if said.form in (forms.percent, forms.milliseconds, forms.factor)
}


def table(
    frame: pd.DataFrame,
    chosen: str,
    caption: str = "",
    titles: Mapping[str, str] | None = None,
) -> Table | None:
    """A table of a frame of results; None without rows.

    Args:
        frame: of results.
        chosen: its columns, with spaces between them; ``NAME.n`` is the number of cases of one,
            ``NAME:*`` stands for all columns of :func:`across` under that name, of which there may
            be none.
        caption: a paragraph that stands before it.
        titles: by name, a header of this table alone.

    Raises:
        TableError: the frame has no column of such a name, or it has no title.
    """
    if frame.empty:
        return None
    columns: list[Column] = []
    cells: list[list[str]] = []
    for name in chosen.split():
        of, counted = (name[:-2], True) if name.endswith(".n") else (name, False)
        key = of.partition(":")[0]
        alike = of.endswith(":*")
        own = [c for c in frame if str(c).startswith(of[:-1])] if alike else [of]
        if key not in COLUMNS:
            raise TableError(f"table: no column {key!r}; {nearest(key, COLUMNS)}")
        if not alike and of not in frame:
            raise TableError(
                f"table: the frame has no {of!r}; {nearest(of, list(map(str, frame)))}"
            )
        said = COLUMNS[key]
        for column in own:
            title = "n" if counted else said.title.format(str(column).partition(":")[2])
            known = [None if is_missing(one) else one for one in frame[column]]
            first = next((one for one in known if one is not None), None)
            is_text = isinstance(first, str) and not alike
            left = (is_text if said.left is None else said.left) and not counted
            title = (titles or {}).get(name, title)
            columns.append(
                Column(title, len(columns), left=left, alike=alike, notable=said.notable)
            )
            read = _count if counted else said.form
            cells.append([MISSING if one is None else read(one) for one in known])
    return Table(list(zip(*cells, strict=True)), columns, caption)


def _count(found: Any) -> str:
    return str(found.n)


def across(
    found: pd.Series, by: str, name: str, counts: Mapping[Any, int] | pd.Series | None = None
) -> pd.DataFrame:
    """Values by two things as a frame: a column ``NAME:KEY`` for every value of one of them.

    Columns are in the order in which their keys appear, rows of one level likewise.

    Args:
        found: by two levels.
        by: the level that is laid across.
        name: of :data:`COLUMNS`.
        counts: by key, a number of cases that its title states; None for none.
    """
    wide = found.unstack(by)[list(found.index.unique(by))]
    if wide.index.nlevels == 1:
        wide = wide.loc[found.index.droplevel(by).unique()]
    numbers = {} if counts is None else {key: f" (n {counts[key]})" for key in wide.columns}
    return wide.rename(columns=lambda key: f"{name}:{key}{numbers.get(key, '')}")


def records(frame: pd.DataFrame, rows: Iterable[Any] | None = None) -> list[dict[str, Any]]:
    """Rows of a frame as charts read them, all or some; a missing estimate is none of no case."""
    own = frame if rows is None else frame.loc[list(rows)]
    return [
        {str(k): NOTHING if k in _ESTIMATES and is_missing(v) else v for k, v in row.items()}
        for row in own.to_dict("records")
    ]
