"""Configurations: fields with their form as a flag, and the binding of mappings to dataclasses."""

from __future__ import annotations

import dataclasses
import importlib
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from enum import Enum
from functools import cache
from pathlib import Path
from types import MappingProxyType, NoneType, UnionType
from typing import Any, NoReturn, TypeVar, Union, get_args, get_origin, get_type_hints

from steadyload.engines.quantities import quantity
from steadyload.errors import UserError, nearest
from steadyload.escaping import printable, shown
from steadyload.numbers import POSITIVE, is_positive

T = TypeVar("T")

NAMES, METAVAR, READ, OPERAND, FEWEST, BARE = (
    "names", "metavar", "read", "operand", "fewest", "bare"
)  # fmt: skip
"""Keys of a field's metadata, beside those of :func:`steadyload.engines.quantities.quantity`."""

_KEY = 40
"""Characters of the key of an element in a message."""


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


def output_option(default: Any, about: str, *, metavar: str = "") -> Any:
    """A field for a file or folder that is written; the flag is ``--output``, ``-o``."""
    return option(default, about, names=("--output", "-o"), metavar=metavar)


def set_option(default: str = "") -> Any:
    """A field for a labelled set, as :func:`steadyload.layouts.benchmark.dataset.set_named` takes.

    Args:
        default: a word of the package, or empty for its large set.
    """
    about = "folder of a labelled set, or a set of the package, such as lists"
    return option(default, f"{about} (default: {default or 'the large one'})", metavar="DIR")


REQUIRED = dataclasses.MISSING
"""The default of a field that must be given."""


def stated(**values: Any) -> dict[str, Any]:
    """The values that are stated: all but None."""
    return {name: value for name, value in values.items() if value is not None}


def _named(made: Any, more: dict[str, Any]) -> Any:
    made.metadata = MappingProxyType({**made.metadata, **more})
    return made


def positive_number(text: str) -> float:
    """A number from text: one of :func:`steadyload.numbers.is_positive`.

    Raises:
        ValueError: the text is no such number.
    """
    value = number_of(text)
    if not is_positive(value):
        raise ValueError(f"{text!r}; allowed: a number {POSITIVE}")
    return value


def number_from_zero(text: str) -> float:
    """A number of 0 or more, below 100,000, from text.

    Raises:
        ValueError: the text is no such number.
    """
    value = number_of(text)
    if not 0.0 <= value < 1e5:
        raise ValueError(f"{text!r}; allowed: a number, 0 or more, below 100,000")
    return value


def number_of(text: str) -> float:
    """The number that a text states; not a number where it states none."""
    try:
        return float(text) if text.isascii() else math.nan
    except ValueError:
        return math.nan


def choices_of(metadata: Mapping[str, Any]) -> Sequence[str]:
    """Allowed words of a field, by its metadata; empty where all are allowed."""
    named = metadata.get("choices") or ()
    if not isinstance(named, str):
        return sorted(named)
    module, _, name = named.partition(":")
    return [str(word) for word in getattr(importlib.import_module(module), name)]


def numbers_allowed(kind: type[float], least: float, most: float, unit: str = "") -> str:
    """The numbers of a range in words; a bound that is infinite is none."""
    what = "a whole number" if kind is int else "a number"
    if math.isinf(least):
        found = what if math.isinf(most) else f"{what} of at most {_bound(most)}"
    else:
        to = "or more" if math.isinf(most) else f"to {_bound(most)}"
        found = f"{what}, {_bound(least)} {to}"
    return f"{found} [{unit}]" if unit else found


def _bound(number: float) -> str:
    return f"{number:,}" if isinstance(number, int) else f"{number:g}"


_TABLE = "keys with values"

_MOST = 2**63 - 1
"""Of a whole number of an :func:`option`: what libraries count with."""


class ConfigError(UserError):
    """A key or value of a configuration that is not allowed; says where, which, and what is."""


def bind(
    cls: type[T],
    mapping: object,
    where: str,
    error: type[UserError] = ConfigError,
    /,
    **given: Any,
) -> T:
    """A dataclass of the values of a mapping, such as a TOML file or a JSON object.

    Fields may be texts, truth values, numbers, paths, enumerations, dataclasses, tuples, lists,
    sets and mappings of these, and optional. Ranges, choices and readers of :func:`option` hold.

    Args:
        cls: a dataclass.
        mapping: values by name of a field.
        where: what the mapping is, for messages.
        error: what is raised.
        given: fields that the mapping may not state, with their values.

    Raises:
        UserError: of the class ``error``: no mapping, an unknown or missing key, a value that is
            not allowed, or values that the class refuses.
    """
    values = {**values_of(cls, mapping, where, error, apart=given), **given}
    refuse_missing(cls, values, where, error)
    try:
        return cls(**values)
    except ValueError as refused:
        raise error(f"{where}: {refused}") from None


def values_of(
    cls: type,
    mapping: object,
    where: str,
    error: type[UserError] = ConfigError,
    *,
    apart: Collection[str] = (),
    beside: Collection[type] = (),
) -> dict[str, Any]:
    """The fields of a dataclass that a mapping states, by name; see :func:`bind`.

    Args:
        cls: a dataclass.
        mapping: values by name of a field.
        where: what the mapping is, for messages.
        error: what is raised.
        apart: names of fields that the mapping may not state.
        beside: dataclasses whose fields it may state, too.
    """
    if not isinstance(mapping, Mapping):
        raise error(f"{where} is {shown(mapping)}; allowed: {_TABLE}")
    known: dict[str, tuple[dataclasses.Field[Any], Any]] = {}
    for each in (cls, *beside):
        known |= {name: (one, _hints(each)[name]) for name, one in _fields(each).items()}
    known = {name: one for name, one in known.items() if name not in apart}
    for key in mapping:
        if key not in known:
            raise error(f"{where}: unknown key {shown(key)}; {nearest(str(key), known)}")
    found = {}
    for name, stated in mapping.items():
        one, hint = known[name]
        found[name] = _Field(where, name, one.metadata, error).value(hint, stated)
    return found


def refuse_missing(
    cls: type, names: Collection[str], where: str, error: type[UserError] = ConfigError
) -> None:
    """Refuse names of stated fields that lack one without a default."""
    for name, one in _fields(cls).items():
        has_default = one.default is not REQUIRED or one.default_factory is not REQUIRED
        if not has_default and name not in names:
            allowed = _Field(where, name, one.metadata, error).allowed(_hints(cls)[name])
            raise error(f"{where}: {name} is missing; allowed: {allowed}")


def check(made: Any, where: str, error: type[UserError] = ConfigError) -> None:
    """Refuse a dataclass that :func:`bind` would not make; for one that Python code makes, too."""
    values_of(type(made), {name: getattr(made, name) for name in _fields(type(made))}, where, error)


@cache
def _hints(cls: type) -> Mapping[str, Any]:
    return get_type_hints(cls)


def _fields(cls: type) -> dict[str, dataclasses.Field[Any]]:
    """The fields that a dataclass is made of, by name."""
    return {one.name: one for one in dataclasses.fields(cls) if one.init}


class _Field:
    """A field, or an element of one, that is bound: where it stands, and what is allowed there."""

    def __init__(
        self, where: str, name: str, metadata: Mapping[str, Any], error: type[UserError]
    ) -> None:
        self.where, self.name, self.metadata, self.error = where, name, metadata, error

    def value(self, kind: Any, stated: object) -> Any:
        """The value of a type."""
        origin, inner = _parts(kind)
        if origin is None:
            if stated is None and NoneType in get_args(kind):
                return None
            return self.value(inner[0], stated)
        if self.metadata.get(READ) is not None and not inner:
            return self._read(kind, stated)
        if origin in (tuple, list, frozenset):
            return self._elements(kind, stated)
        if origin is dict:
            return self._mapping(kind, stated)
        if isinstance(kind, type) and dataclasses.is_dataclass(kind):
            if not isinstance(stated, Mapping):
                self._refuse(kind, stated)
            return bind(kind, stated, f"{self.where}: {self.name}", self.error)
        return stated if kind is Any else self._single(kind, stated)

    def allowed(self, kind: Any) -> str:
        """The allowed values of a type in words."""
        origin, inner = _parts(kind)
        if origin is None:
            return self.allowed(inner[0])
        if kind is Any or (self.metadata.get(READ) is not None and not inner):
            return "a text" if kind is str else "a value"
        if origin is tuple and ... not in inner:
            return f"a list of {len(inner)} values"
        if origin in (tuple, list, frozenset):
            return f"a list of {fewest} or more" if (fewest := self._fewest()) else "a list"
        if origin is dict or dataclasses.is_dataclass(kind):
            names = self._names(get_args(kind)[0]) if origin is dict else ()
            what = "one value or more" if self._fewest() else "values"
            return f"{what} by {', '.join(sorted(map(str, names)))}" if names else _TABLE
        if kind in (int, float):
            return numbers_allowed(kind, *self._range(), self.metadata.get("unit", ""))
        if names := self._names(kind):
            return ", ".join(sorted(map(str, names)))
        if kind is bool:
            return "true or false"
        return "a path" if kind is Path else "a text"

    def _refuse(self, kind: Any, stated: object) -> NoReturn:
        self._say(f"{shown(stated)}; allowed: {self.allowed(kind)}")

    def _say(self, what: str) -> NoReturn:
        raise self.error(f"{self.where}: {self.name} is {what}") from None

    def _at(self, key: object) -> _Field:
        name = f"{self.name}[{printable(str(key), _KEY)}]"
        return _Field(self.where, name, self.metadata, self.error)

    def _fewest(self) -> int:
        """The smallest number of elements that a list may have."""
        return self.metadata.get(FEWEST) or 0

    def _names(self, kind: Any) -> Sequence[str]:
        """Allowed words, or numbers of an enumeration; empty where all are allowed."""
        is_enum = isinstance(kind, type) and issubclass(kind, Enum)
        return choices_of(self.metadata) or ([one.value for one in kind] if is_enum else ())

    def _range(self) -> tuple[float, float]:
        return self.metadata.get("least", -math.inf), self.metadata.get("most", math.inf)

    def _elements(self, kind: Any, stated: object) -> Sequence[Any]:
        origin, inner = _parts(kind)
        if not isinstance(stated, list | tuple | frozenset) or len(stated) < self._fewest():
            self._refuse(kind, stated)
        kinds = inner if origin is tuple and ... not in inner else inner[:1] * len(stated)
        if len(kinds) != len(stated):
            self._refuse(kind, stated)
        found = [
            self._at(k).value(each, one)
            for k, (each, one) in enumerate(zip(kinds, stated, strict=True))
        ]
        return origin(found)

    def _mapping(self, kind: Any, stated: object) -> dict[Any, Any]:
        if not isinstance(stated, Mapping) or len(stated) < self._fewest():
            self._refuse(kind, stated)
        key, value = get_args(kind)
        return {
            self._at(name).value(key, name): self._at(name).value(value, one)
            for name, one in stated.items()
        }

    def _read(self, kind: Any, stated: object) -> Any:
        """The value of a text, or of a number in its place, by the field's own reader."""
        texts = str if kind is str else str | int | float
        if not isinstance(stated, texts) or isinstance(stated, bool):
            self._refuse(kind, stated)
        try:
            return self.metadata[READ](str(stated))
        except ValueError as error:
            self._say(str(error))

    def _single(self, kind: Any, stated: object) -> Any:
        if kind in (int, float):
            return self._number(kind, stated)
        if kind is bool:
            return stated if isinstance(stated, bool) else self._refuse(kind, stated)
        names = self._names(kind)
        texts = str | int if issubclass(kind, Enum) else str | kind
        no_path = kind is Path and (stated == "" or "\0" in str(stated))
        if not isinstance(stated, texts) or no_path:
            self._refuse(kind, stated)
        if names and stated not in names:
            self._say(f"{shown(stated)}; {nearest(str(stated), names)}")
        return kind(stated)

    def _number(self, kind: Any, stated: Any) -> float:
        is_right = type(stated) is int or (kind is float and type(stated) is float)
        if is_right and "least" in self.metadata:
            least, most = self._range()
            if kind is int and stated > _MOST < most:
                self._say(f"{shown(stated)}; allowed: a whole number of at most {_MOST}")
            is_right = least <= stated <= most  # not a number is in no range
        try:
            return kind(stated) if is_right else self._refuse(kind, stated)
        except OverflowError:
            self._refuse(kind, stated)


def _parts(kind: Any) -> tuple[Any, tuple[Any, ...]]:
    """A type without its parameters, and these; None and the type itself for an optional one."""
    origin, inner = get_origin(kind), get_args(kind)
    if origin in (Union, UnionType):
        return None, tuple(one for one in inner if one is not NoneType)
    return {Sequence: list, Mapping: dict}.get(origin, origin or kind), inner
