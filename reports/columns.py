"""Rows whose fields state how they are shown, the forms of their cells, and tables of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, field
from typing import Any, TypeVar, dataclass_transform

from steadyload.errors import UserError, nearest
from steadyload.escaping import markdown
from steadyload.reports.table import (
    Column,
    Table,
    cell,
    columns_for,
    compact,
    counts,
    decimal,
    duration,
    factor,
    fixed,
    general,
    least_shown,
    milliseconds,
    names,
    one_decimal,
    p_value,
    percent,
    plain_percent,
    significant,
    yes_no,
)

__all__ = [
    "cell", "column", "compact", "counts", "decimal", "duration", "factor", "fixed", "general",
    "least_shown", "markdown", "milliseconds", "names", "one_decimal", "p_value", "percent",
    "plain_percent", "row", "shown_column", "significant", "table", "yes_no",
]  # fmt: skip

Row = TypeVar("Row")

_COLUMN = "column"
"""Key of a field's metadata."""


class TableError(UserError):
    """A table names a field that its rows do not have."""


@dataclass(frozen=True, slots=True)
class _Declared:
    """How a field is shown; the meanings are those of :func:`column`."""

    title: str
    form: Callable[[Any], str]
    about: str = ""
    left: bool | None = None
    notable: bool = False


def column(
    title: str = "",
    form: Callable[[Any], str] = cell,
    about: str = "",
    *,
    left: bool | None = None,
    notable: bool = False,
    default: Any = MISSING,
    default_factory: Any = MISSING,
) -> Any:
    """A field of a row that is a column of tables.

    Args:
        title: header; empty for the field's name. Of a field that maps keys to values it holds
            ``{}`` in the place of a key: a column a key.
        form: makes the cell's text of the value.
        about: its meaning, where the title does not say it.
        left: whether its cells are aligned left; else texts alone are.
        notable: see :class:`steadyload.reports.table.Column`.
        default: of the field; none where it has to be given.
        default_factory: makes the default.
    """
    metadata = {_COLUMN: _Declared(title, form, about, left, notable)}
    return field(default=default, default_factory=default_factory, metadata=metadata)


def shown_column() -> Any:
    """The column beside a difference: the least one that the cases show."""
    return column(
        "shown", least_shown, "least difference that these cases show with a probability of 80 %"
    )


@dataclass_transform(frozen_default=True, field_specifiers=(column, shown_column, field))
def row(made: type[Row]) -> type[Row]:
    """Make a class the rows of a table: a frozen dataclass; fields of :func:`column` are shown."""
    return dataclass(frozen=True, slots=True)(made)


def table(
    rows: Sequence[Any],
    chosen: str = "",
    caption: str = "",
    titles: Mapping[str, str] | None = None,
) -> Table | None:
    """A table of rows; None where there are none.

    Args:
        rows: of one class.
        chosen: fields and properties that are shown: their names in their order, with spaces
            between them, dotted where they go on into what a field holds; else all fields of
            :func:`column`.
        caption: a paragraph that stands before it.
        titles: by name, a header of this table alone.

    Raises:
        TableError: a row has no field or property of such a name.
    """
    if not rows:
        return None
    columns: list[Column] = []
    for name in chosen.split() or _declared(rows[0]):
        *outer, last = path = name.split(".")
        found = next((one for row in rows if (one := _at(row, outer)) is not None), None)
        if found is not None and not hasattr(found, last):
            known = [each for each in dir(found) if not each.startswith("_")]
            raise TableError(
                f"table of rows of {type(rows[0]).__name__}: no field {name!r}; "
                + nearest(last, known)
            )
        said = _declared(found).get(last, _Declared("", cell))
        if titles and name in titles:
            said = dataclasses.replace(said, title=titles[name])
        columns += _columns(rows, path, said)
    return Table(rows, columns, caption)


def columns_of(one: type) -> dict[str, Column]:
    """The columns of a class of rows by the names of their fields, for pages without a template."""
    return {
        name: Column(
            said.title or name, name, said.form, left=bool(said.left), notable=said.notable
        )
        for name, said in _declared(one).items()
    }


def _declared(one: object) -> dict[str, _Declared]:
    """The columns of a row by name; empty for what is no row."""
    if not dataclasses.is_dataclass(one):
        return {}
    return {f.name: f.metadata[_COLUMN] for f in dataclasses.fields(one) if _COLUMN in f.metadata}


def _at(one: Any, path: Sequence[str]) -> Any:
    """The value at a path of fields; None where one of them holds None."""
    for name in path:
        one = None if one is None else getattr(one, name)
    return one


def _columns(rows: Sequence[Any], path: Sequence[str], said: _Declared) -> Iterator[Column]:
    """Columns of one field: one, or one a key of a mapping, or those of the row that it holds."""

    def value(one: Any) -> Any:
        return _at(one, path)

    title = said.title or path[-1]
    found = [each for each in map(value, rows) if each is not None]
    if "{}" in title:
        keys = dict.fromkeys(key for each in found for key in each)
        yield from columns_for(keys, title, lambda one, key: (value(one) or {}).get(key), said.form)
    elif found and (inner := _declared(found[0])):
        for name, part in inner.items():
            for each in _columns(rows, (*path, name), part):
                yield dataclasses.replace(each, title=f"{title}: {each.title}")
    else:
        left = said.left if said.left is not None else bool(found) and isinstance(found[0], str)
        yield Column(title, value, said.form, left=left, notable=said.notable)
