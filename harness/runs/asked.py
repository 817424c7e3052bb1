"""Units of work of which every field is part of the key, and the keeping of their rows.

This module imports neither what judges nor what stores, so that help on a command is quick.
"""

from __future__ import annotations

import dataclasses
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property, partial
from pathlib import Path
from typing import (
    TYPE_CHECKING,
    Any,
    ClassVar,
    Generic,
    NamedTuple,
    Self,
    TypeVar,
    dataclass_transform,
)

from steadyload.config import bind
from steadyload.progress import Progress, silent

if TYPE_CHECKING:
    from steadyload.runs.labels import Case
    from steadyload.runs.pool import Executor

R = TypeVar("R")

_WORD, _SAID = "word of the key", "value in the key"
_MADE_WITH = "made_with"


def asked(word: str = "", *, said: Callable[[Any], Any] | None = None) -> Any:
    """A field of a :class:`Keyed` that is in the key in its own way, as earlier rows have it.

    Args:
        word: in the place of the field's name; empty for that.
        said: makes what the key holds of the value, which JSON can hold; None for all of it.
    """
    return field(metadata={_WORD: word, _SAID: said})


@dataclass_transform(frozen_default=True, field_specifiers=(asked,))
class Keyed:
    """Base of units of work whose key is all of their fields, and what the class states:
    ``class Size(Asked[Point], what="scale", methods=METHODS)``.

    Attributes:
        stated: what is measured, and constants that results depend on, by their word in the key.
        prefix: of the key, as earlier rows have it.
    """

    stated: ClassVar[Mapping[str, Any]]
    prefix: ClassVar[str]

    def __init_subclass__(cls, *, what: str = "", prefix: str = "", **constants: Any) -> None:
        super().__init_subclass__()
        dataclass(frozen=True)(cls)
        cls.stated, cls.prefix = {"question": what, **constants}, prefix

    @cached_property
    def key(self) -> str:
        """The key of its results."""
        from steadyload.runs.provenance import key_of

        own = {}
        for one in dataclasses.fields(self):  # type: ignore[arg-type]
            value, said = getattr(self, one.name), one.metadata.get(_SAID)
            own[one.metadata.get(_WORD) or one.name] = (
                said(value) if said else _of_field(one, value)
            )
        return self.prefix + key_of({**self.stated, **own})

    def describe(self, part: int) -> str:
        """Description for messages."""
        return ", ".join(f"{name} {value}" for name, value in _values(self).items())


class Asked(Keyed, ABC, Generic[R]):
    """Base of what is measured once and kept: a unit of one part, with one row."""

    @abstractmethod
    def measure(self) -> R:
        """The row that is found; its fields are kept."""

    def __len__(self) -> int:
        return 1

    def without(self, done: int) -> Self:
        """See :meth:`steadyload.runs.pool.WorkUnit.without`."""
        return self


def measured(unit: Asked[R]) -> Iterator[R]:
    """Measure a unit: the work of :meth:`steadyload.runs.store.Store.complete`."""
    yield unit.measure()


def _named(cases: Sequence[Case]) -> list[list[str]]:
    return [[scenario, layout.name, layout.content_hash()] for scenario, layout in cases]


class AskedCases(Keyed):
    """Base of units of cases, which are their parts: each is judged once, and its row kept."""

    cases: tuple[Case, ...] = asked(said=_named)

    def __len__(self) -> int:
        return len(self.cases)

    def without(self, done: int) -> Self:
        """See :meth:`steadyload.runs.pool.WorkUnit.without`."""
        return dataclasses.replace(self, cases=self.cases[done:])

    def in_shards(self, size: int) -> list[Self]:
        """Units of its cases, at most so many in each."""
        starts = range(0, len(self), size)
        return [dataclasses.replace(self, cases=self.cases[k : k + size]) for k in starts]

    def describe(self, part: int) -> str:
        """Description of a case for messages."""
        scenario, layout = self.cases[part]
        return f"layout {layout.name!r} ({scenario})"


def _values(unit: Any) -> dict[str, Any]:
    """The fields of a dataclass, by name."""
    return {one.name: getattr(unit, one.name) for one in dataclasses.fields(unit)}


def _of_field(one: dataclasses.Field[Any], value: Any) -> Any:
    """The value of a field as JSON can hold it; 20 and 20.0 are the same number in it."""
    kinds = [kind for kind in (int, float) if re.search(rf"\b{kind.__name__}\b", str(one.type))]
    return _plain(value, kinds[0] if len(kinds) == 1 else None)


def _plain(value: Any, kind: type[float] | None) -> Any:
    """A value as JSON can hold it; of a layout the hash of its content.

    Args:
        value: any.
        kind: of the numbers in it; None leaves them as they are.
    """
    if hasattr(value, "content_hash"):
        return value.content_hash()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        own = dataclasses.fields(value)
        return {one.name: _of_field(one, getattr(value, one.name)) for one in own}
    if isinstance(value, Mapping):
        return {key: _plain(inner, kind) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(inner, kind) for inner in value]
    if kind is not None and type(value) in (int, float) and kind(value) == value:
        return kind(value)
    return str(value) if isinstance(value, Path) else value


class Measured(NamedTuple, Generic[R]):
    """Rows in the order in which they were asked for, and the provenance of the last one."""

    rows: list[R]
    made_with: Mapping[str, str]


def kept_rows(
    folder: Path,
    units: Sequence[Asked[R]],
    row: type[R],
    *,
    measure: Callable[[Any], R] | None = None,
    workers: int | Executor = 0,
    progress: Progress = silent,
) -> Measured[R]:
    """Measure what is not kept yet, and read the rest, however fast the code has become.

    Args:
        folder: of the rows; the folder that it lies in is locked.
        units: one or more.
        row: class of the rows. Fields of a row that are named as fields of what is asked are not
            stored twice.
        measure: measures a unit that is to be given something besides its fields; None for
            :meth:`Asked.measure`.
        workers: see :func:`steadyload.runs.pool.run_units`.
        progress: called with rows done and rows in all.

    Raises:
        ResultsError: another run is at work in the folder, or a unit ended its process.
        ConfigError: a row that is kept is of another form.
    """
    from steadyload.runs.store import JSON, Store, locked

    with locked(folder.parent):
        store: Store[dict[str, Any], list[dict[str, Any]]] = Store(folder, JSON)
        store.complete(units, partial(_kept, measure), workers=workers, progress=progress)
        found = [store.read(unit.key)[0] for unit in units]
    rows = [_bound(unit, stored, row) for unit, stored in zip(units, found, strict=True)]
    return Measured(rows, found[-1].get(_MADE_WITH, {}))


def rows_so_far(folder: Path, units: Sequence[Asked[R]], row: type[R]) -> list[R | None]:
    """The rows that are kept; nothing is measured.

    Args:
        folder: of the rows; it need not exist.
        units: any number.
        row: class of the rows.

    Returns:
        A row a unit; None where none is kept.

    Raises:
        ConfigError: a row that is kept is of another form.
        DamagedError: its file has changed since it was written.
    """
    from steadyload.runs.store import JSON, Store

    store: Store[dict[str, Any], list[dict[str, Any]]] = Store(folder, JSON)
    return [
        _bound(unit, store.read(unit.key)[0], row) if unit.key in store else None for unit in units
    ]


def _bound(unit: Asked[R], stored: Mapping[str, Any], row: type[R]) -> R:
    """The row of what is stored; fields of the unit that bear the same name are its own, too."""
    known = {**_values(unit), **stored}
    names = [one.name for one in dataclasses.fields(row)]  # type: ignore[arg-type]
    return bind(row, {name: known[name] for name in names if name in known}, f"kept row {unit.key}")


@cache
def _made_with_here() -> Mapping[str, str]:
    """Provenance of the code of this process, as it is when that measures for the first time."""
    from steadyload.runs.provenance import provenance_lines

    return provenance_lines()


def _kept(measure: Callable[[Any], Any] | None, unit: Asked[Any]) -> Iterator[dict[str, Any]]:
    made_with = _made_with_here()
    row = unit.measure() if measure is None else measure(unit)
    found, known = dataclasses.asdict(row), _values(unit)
    own = {k: v for k, v in found.items() if k not in known or known[k] != v}
    yield {**own, _MADE_WITH: made_with}
