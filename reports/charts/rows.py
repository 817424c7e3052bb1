"""Values of rows by the names of their fields, in the form in which charts draw them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from steadyload.errors import UserError, nearest
from steadyload.reports.charts.drawing import reach
from steadyload.reports.style import Identified
from steadyload.statistics.estimate import Estimate

Field = str
"""Name of a field or property of rows; a dotted one goes on into what it holds."""


class ChartError(UserError):
    """A chart names a field that its rows do not have, or an option that is not allowed."""


class Along(NamedTuple):
    """Values along an axis.

    Attributes:
        values: the numbers.
        reaches: half-widths of their intervals to both sides, shape (2, n); None where the field
            holds plain numbers.
    """

    values: list[float]
    reaches: NDArray[np.float64] | None


def value(row: Any, name: str) -> Any:
    """The value of a field or property of a row; a dotted name goes on into it, as in mappings.

    Raises:
        ChartError: there is no such field.
    """
    if isinstance(row, Inner):
        is_outer = name.partition(".")[0] in _names(row.outer)
        return value(row.outer if is_outer else row.inner, name)
    found = row
    for part in name.split("."):
        known = _names(found)
        if part not in known:
            raise ChartError(
                f"chart of rows of {type(row).__name__}: no field {name!r}; {nearest(part, known)}"
            )
        found = found[part] if isinstance(found, Mapping) else getattr(found, part)
    return found


def method_of(row: Any, name: str) -> Identified:
    """The method that a field holds.

    Raises:
        ChartError: there is no such field, or it holds something else.
    """
    found = value(row, name)
    if not all(hasattr(found, each) for each in ("title", "spec", "family", "engine")):
        raise _refused(row, name, found, "a method with its title, spec, family and engine")
    return cast(Identified, found)


def estimate_of(row: Any, name: str) -> Estimate:
    """The estimate that a field holds.

    Raises:
        ChartError: there is no such field, or it holds something else.
    """
    found = value(row, name)
    if not isinstance(found, Estimate):
        raise _refused(row, name, found, "an estimate")
    return found


def _refused(row: Any, name: str, found: object, allowed: str) -> ChartError:
    return ChartError(
        f"chart of rows of {type(row).__name__}: field {name!r} is {found!r}; allowed: {allowed}"
    )


def _names(record: Any) -> list[str]:
    """Names of the fields of a record, or of the keys of a mapping."""
    known = map(str, record) if isinstance(record, Mapping) else dir(record)
    return [name for name in known if not name.startswith("_")]


def grouped(rows: Iterable[Any], name: str) -> dict[Any, list[Any]]:
    """Rows by the value of a field, in the order in which values first appear.

    Without a name all rows are one group, under an empty text.

    Raises:
        ChartError: there are no rows.
    """
    found: dict[Any, list[Any]] = {}
    for row in rows:
        found.setdefault(value(row, name) if name else "", []).append(row)
    if not found:
        raise ChartError("chart of no rows; allowed: one row or more")
    return found


def chosen(word: str, allowed: Collection[str], option: str) -> str:
    """A word of those that are allowed.

    Raises:
        ChartError: it is none of them.
    """
    if word not in allowed:
        raise ChartError(f"chart with {option}={word!r}; {nearest(word, allowed)}")
    return word


def along(rows: Sequence[Any], name: str, scale: float = 1.0) -> Along:
    """Values of a field that holds numbers or estimates, times a scale.

    Raises:
        ChartError: there is no such field, or some value is neither.
    """
    found = [value(row, name) for row in rows]
    for row, one in zip(rows, found, strict=True):
        if isinstance(one, str) or not isinstance(one, Estimate | int | float | np.number):
            raise _refused(row, name, one, "a number or an estimate")
    if not any(isinstance(one, Estimate) for one in found):
        return Along([scale * one for one in found], None)
    estimates = [one if isinstance(one, Estimate) else Estimate(one, one, one, 1) for one in found]
    reaches = np.hstack([reach(one, scale) for one in estimates])
    return Along([scale * one.value for one in estimates], reaches)


class Inner(NamedTuple):
    """A record within a row; names are looked for in the row first."""

    outer: Any
    inner: Any


def flat(rows: Iterable[Any], within: str) -> list[Any]:
    """Records that a field of rows holds, each as an :class:`Inner`; without a name the rows."""
    if not within:
        return list(rows)
    return [Inner(row, record) for row in rows for record in value(row, within)]
