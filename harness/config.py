"""Configurations: fields with their form as a flag, and the binding of mappings to dataclasses."""

from __future__ import annotations

import dataclasses
import importlib
import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from enum import Enum
from types import MappingProxyType, NoneType, UnionType
from typing import Any, NoReturn, TypeVar, Union, get_args, get_origin, get_type_hints

from steadyload.engines.quantities import quantity
from steadyload.errors import UserError, nearest
from steadyload.escaping import shown
from steadyload.numbers import POSITIVE, is_positive

T = TypeVar("T")

NAMES, METAVAR, READ, OPERAND, FEWEST, BARE = (
    "names", "metavar", "read", "operand", "fewest", "bare"
)  # fmt: skip
"""Keys of a field's metadata, beside those of :func:`steadyload.engines.quantities.quantity`."""


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


def set_option(default: str = "") -> Any:
    """A field for a labelled set, as :func:`steadyload.layouts.benchmark.dataset.set_named` takes.

    Args:
        default: a word of the package, or empty for its large set.
    """
    about = "folder of a labelled set, or a set of the package, such as lists"
    return option(default, f"{about} (default: {default or 'the large one'})", metavar="DIR")


REQUIRED = dataclasses.MISSING
"""The default of a field that must be given."""


def _named(made: Any, more: dict[str, Any]) -> Any:
    made.metadata = MappingProxyType({**made.metadata, **more})
    return made


def positive_number(text: str) -> float:
    """A number from text: one of :func:`steadyload.numbers.is_positive`.

    Raises:
        ValueError: the text is no such number.
    """
    value = _number(text)
    if not is_positive(value):
        raise ValueError(f"{text!r}; allowed: a number {POSITIVE}")
    return value


def number_from_zero(text: str) -> float:
    """A number of 0 or more, below 100,000, from text.

    Raises:
        ValueError: the text is no such number.
    """
    value = _number(text)
    if not 0.0 <= value < 1e5:
        raise ValueError(f"{text!r}; allowed: a number, 0 or more, below 100,000")
    return value


def _number(text: str) -> float:
    """The number that a text states; not a number where it states none."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def choices_of(metadata: Mapping[str, Any]) -> Sequence[str]:
    """Allowed words of a field, by its metadata; empty where all are allowed."""
    named = metadata.get("choices") or ()
    if not isinstance(named, str):
        return sorted(named)
    module, _, name = named.partition(":")
    return [str(word) for word in getattr(importlib.import_module(module), name)]


def numbers_allowed(kind: type[float], least: float, most: float) -> str:
    """The numbers of a range in words; a bound that is infinite is none."""
    what = "a whole number" if kind is int else "a number"
    if math.isinf(least):
        return what if math.isinf(most) else f"{what} of at most {most:g}"
    return f"{what}, {least:g} {'or more' if math.isinf(most) else f'to {most:g}'}"


class ConfigError(UserError):
    """A key or value of a configuration that is not allowed; says where, which, and what is."""


def bind(cls: type[T], mapping: Mapping[str, object], where: str) -> T:
    """A dataclass of the values of a mapping, such as a TOML file or a JSON object.

    Fields may be texts, truth values, numbers, paths, enumerations, dataclasses, tuples, lists and
    mappings of these, and optional. Ranges, choices and readers of :func:`option` hold.

    Args:
        cls: a dataclass.
        mapping: values by name of a field.
        where: what the mapping is, for messages.

    Raises:
        ConfigError: an unknown or missing key, or a value that is not allowed.
    """
    return cls(**_complete(cls, values_of(cls, mapping, where), where))


def values_of(
    cls: type, mapping: Mapping[str, object], where: str, *, apart: Collection[str] = ()
) -> dict[str, Any]:
    """The fields of a dataclass that a mapping states, by name; see :func:`bind`.

    Args:
        cls: a dataclass.
        mapping: values by name of a field.
        where: what the mapping is, for messages.
        apart: names of fields that a mapping may not state.
    """
    kinds = get_type_hints(cls)
    known = {one.name: one for one in dataclasses.fields(cls) if one.init and one.name not in apart}
    for key in mapping:
        if key not in known:
            raise ConfigError(f"{where}: unknown key {shown(key)}; {nearest(str(key), known)}")
    return {
        name: _Field(where, name, known[name].metadata).value(kinds[name], stated)
        for name, stated in mapping.items()
    }


def _complete(cls: type, values: dict[str, Any], where: str) -> dict[str, Any]:
    for one in dataclasses.fields(cls):
        has_default = one.default is not REQUIRED or one.default_factory is not REQUIRED
        if one.init and not has_default and one.name not in values:
            raise ConfigError(f"{where}: {one.name} is missing; allowed: a value of it")
    return values


class _Field:
    """A field, or an element of one, that is bound: where it stands, and what is allowed there."""

    def __init__(self, where: str, name: str, metadata: Mapping[str, Any]) -> None:
        self.where, self.name, self.metadata = where, name, metadata

    def value(self, kind: Any, stated: object) -> Any:
        """The value of a type."""
        origin, inner = get_origin(kind) or kind, get_args(kind)
        if origin in (Union, UnionType):
            if stated is None and NoneType in inner:
                return None
            [kind] = [one for one in inner if one is not NoneType]
            return self.value(kind, stated)
        if self.metadata.get(READ) is not None and not inner:
            return self._read(stated)
        if origin is tuple:
            return self._tuple(inner, stated)
        if origin in (list, Sequence):
            return [self._at(k).value(inner[0], one) for k, one in self._elements(stated)]
        if origin in (dict, Mapping):
            return self._mapping(inner, stated)
        if isinstance(kind, type) and dataclasses.is_dataclass(kind):
            if not isinstance(stated, Mapping):
                self._refuse(stated, "keys with values")
            return bind(kind, stated, f"{self.where}: {self.name}")
        return stated if kind is Any else self._single(kind, stated)

    def _refuse(self, stated: object, allowed: str) -> NoReturn:
        raise ConfigError(f"{self.where}: {self.name} is {shown(stated)}; allowed: {allowed}")

    def _at(self, key: object) -> _Field:
        return _Field(self.where, f"{self.name}[{key}]", self.metadata)

    def _elements(self, stated: object) -> Iterable[tuple[int, object]]:
        if not isinstance(stated, list | tuple):
            self._refuse(stated, "a list")
        return enumerate(stated)

    def _tuple(self, inner: tuple[Any, ...], stated: object) -> tuple[Any, ...]:
        elements = list(self._elements(stated))
        kinds = inner[:1] * len(elements) if inner[1:] == (...,) else inner
        if len(kinds) != len(elements):
            self._refuse(stated, f"a list of {len(kinds)} values")
        return tuple(
            self._at(k).value(kind, one) for kind, (k, one) in zip(kinds, elements, strict=True)
        )

    def _mapping(self, inner: tuple[Any, ...], stated: object) -> dict[Any, Any]:
        if not isinstance(stated, Mapping):
            self._refuse(stated, "keys with values")
        key, value = inner
        return {
            self._at(name).value(key, name): self._at(name).value(value, one)
            for name, one in stated.items()
        }

    def _read(self, stated: object) -> Any:
        """The value of a text, or of a number in its place, by the field's own reader."""
        if not isinstance(stated, str | int | float) or isinstance(stated, bool):
            self._refuse(stated, "a value")
        try:
            return self.metadata[READ](str(stated))
        except ValueError as error:
            raise ConfigError(f"{self.where}: {self.name} is {error}") from None

    def _single(self, kind: Any, stated: object) -> Any:
        if kind is bool:
            return stated if isinstance(stated, bool) else self._refuse(stated, "true or false")
        if kind in (int, float):
            return self._number(kind, stated)
        is_enum = issubclass(kind, Enum)
        if not isinstance(stated, str | int if is_enum else str):
            self._refuse(stated, "a text")
        names = [one.value for one in kind] if is_enum else choices_of(self.metadata)
        if names and stated not in names:
            hint = nearest(str(stated), names)
            raise ConfigError(f"{self.where}: {self.name} is {shown(stated)}; {hint}")
        return kind(stated)

    def _number(self, kind: type[float], stated: Any) -> float:
        least, most = self.metadata.get("least", -math.inf), self.metadata.get("most", math.inf)
        is_right = type(stated) is int or (kind is float and type(stated) is float)
        if is_right and "least" in self.metadata:
            is_right = least <= stated <= most  # not a number is in no range
        if not is_right:
            self._refuse(stated, numbers_allowed(kind, least, most))
        return kind(stated)
