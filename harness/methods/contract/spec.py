"""Spec strings: the identity of a method, such as ``pbs:alpha=0.7`` or ``ps3@bullet:t_max=0.2s``.

A spec is ``name[@engine][:key=value,...]``. Keys are the fields of the method's ``Parameters``
dataclass; each field declares its unit, its range and its meaning, and nothing else needs to know.
A plain field of a dataclass of another distribution has no unit and takes any value of its type.
"""

from __future__ import annotations

import dataclasses
import math
import re
import types
import typing
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from steadyload import config
from steadyload.errors import UserError, nearest
from steadyload.escaping import shown

_NAME = r"[A-Za-z0-9_][A-Za-z0-9_.\-]*"
_SPEC = re.compile(rf"(?P<name>{_NAME})(@(?P<engine>{_NAME}))?(:(?P<rest>.*))?", re.DOTALL)
_QUANTITY = re.compile(r"(?P<number>[^a-zA-Z%]*([eE][+-]?\d+)?)(?P<unit>%|[a-zA-Z]*)", re.ASCII)

_SHOWN = 200
"""Characters of a spec or value in a message."""

_UNITS: dict[str, dict[str, float]] = {
    "cm": {"cm": 1.0, "m": 100.0, "mm": 0.1},
    "m": {"m": 1.0, "cm": 0.01, "mm": 0.001},
    "s": {"s": 1.0, "ms": 0.001},
    "m/s": {},
    "m/s2": {},
    "Hz": {"Hz": 1.0, "kHz": 1000.0},
    "deg": {"deg": 1.0, "rad": math.degrees(1.0)},
    "share": {"%": 0.01},
}


class SpecError(UserError):
    """A spec string that names no method, or a parameter or value that is not allowed."""


@dataclass(frozen=True)
class NoParameters:
    """The ``Parameters`` of a method that has none."""


@dataclass(frozen=True, slots=True)
class MethodSpec:
    """A parsed spec string; ``str()`` gives the canonical form.

    Attributes:
        name: method or preset.
        engine: None for a method that needs none.
        values: the parameters stated in the spec itself, in the method's own order.
    """

    name: str
    engine: str | None = None
    values: tuple[tuple[str, str], ...] = ()

    def __str__(self) -> str:
        engine = f"@{self.engine}" if self.engine else ""
        values = ",".join(f"{key}={value}" for key, value in self.values)
        return f"{self.name}{engine}{':' if values else ''}{values}"

    def stating(self, key: str, value: object) -> MethodSpec:
        """The same method with one parameter stated in another way; it is not looked up yet."""
        values = dict(self.values) | {key: str(value)}
        return MethodSpec(self.name, self.engine, tuple(values.items()))


def parse_spec(text: str) -> MethodSpec:
    """Split a spec string; names and values are not looked up yet.

    Raises:
        SpecError: the text is not of the form ``name[@engine][:key=value,...]``.
    """
    match = _SPEC.fullmatch(text.strip())
    if match is None:
        raise SpecError(
            f"method {shown(text, _SHOWN)} is not of the form name[@engine][:key=value,...]"
        )
    values = split_values(match["rest"] or "", f"method {shown(text, _SHOWN)}")
    return MethodSpec(match["name"], match["engine"], tuple(values.items()))


def split_values(text: str, where: str) -> dict[str, str]:
    """Split ``key=value,...``; keys and values are not looked up yet.

    Raises:
        SpecError: a part is not of this form, or a key stands there twice.
    """
    values: dict[str, str] = {}
    for part in filter(None, text.split(",")):
        key, equals, value = part.partition("=")
        key = key.strip()
        if not equals or not key or not value.strip():
            raise SpecError(f"{where}: {shown(part, _SHOWN)} is not of the form key=value")
        if key in values:
            raise SpecError(f"{where}: {key} stands there twice")
        values[key] = value.strip()
    return values


def bind(parameters: type[Any], values: Mapping[str, Any], *, where: str) -> Any:
    """An instance of a ``Parameters`` dataclass from texts or plain values.

    Raises:
        SpecError: an unknown key, or a value of the wrong type or outside its range.
    """
    fields = {f.name: f for f in dataclasses.fields(parameters)}
    hints = typing.get_type_hints(parameters)
    stated = {}
    for key, value in values.items():
        if key not in fields:
            raise SpecError(
                f"{where}: unknown parameter {shown(key, _SHOWN)}; {nearest(key, fields)}"
            )
        unit = fields[key].metadata.get("unit", "")
        stated[key] = _stated(value, hints[key], unit, f"{where}: {key}")
    return config.bind(parameters, stated, where, SpecError)


def canonical(parameters: Any, keys: Collection[str]) -> tuple[tuple[str, str], ...]:
    """The named parameters as texts that :func:`bind` reads back, in declaration order."""
    return tuple(
        (f.name, _text(getattr(parameters, f.name)))
        for f in dataclasses.fields(parameters)
        if f.name in keys
    )


def as_plain(parameters: Any) -> dict[str, Any]:
    """All parameters as values that JSON can hold."""
    return {f.name: _plain(getattr(parameters, f.name)) for f in dataclasses.fields(parameters)}


def stored_values(parameters: Any) -> dict[str, Any]:
    """The parameters that verdicts are stored under, as :func:`as_plain`.

    Those that were added later are left out where they have their default: it changes no verdict.
    """
    plain = as_plain(parameters)
    for f in dataclasses.fields(parameters):
        if f.metadata.get("later") and getattr(parameters, f.name) == f.default:
            del plain[f.name]
    return plain


def allowed_values(parameters: type[Any], name: str) -> str:
    """Allowed values of a parameter, for a listing."""
    field = next(f for f in dataclasses.fields(parameters) if f.name == name)
    kind, optional = _kind(typing.get_type_hints(parameters)[name])
    if isinstance(kind, type) and issubclass(kind, StrEnum):
        choices = "|".join(kind)
    elif typing.get_origin(kind) is frozenset:
        choices = f"{'|'.join(field.metadata.get('choices', ()))}, joined by +"
    elif kind is str:
        choices = "a text"
    elif kind is bool:
        choices = "true|false"
    elif kind not in (int, float):
        choices = "a value of Python"
    else:
        choices = _range(
            field.metadata.get("least", -math.inf), field.metadata.get("most", math.inf)
        )
    return f"none|{choices}" if optional else choices


def _stated(value: Any, hint: Any, unit: str, label: str) -> Any:
    """A value as :func:`steadyload.config.bind` takes it: a text becomes one of its field's type.

    Raises:
        SpecError: no finite number, another unit, or a parameter that no text can state.
    """
    kind, optional = _kind(hint)
    if optional and value in (None, "none"):
        return None
    if kind in (int, float):
        number = _number(value, unit, label)
        return int(number) if number.is_integer() and abs(number) < 1e15 else number
    if kind is str:
        return str(value)
    if kind is bool:
        return {"true": True, "false": False}.get(str(value).lower(), value)
    if typing.get_origin(kind) is frozenset:
        return value.split("+") if isinstance(value, str) else value
    if not (isinstance(kind, type) and issubclass(kind, StrEnum)):
        raise SpecError(f"{label}: cannot be stated in a spec; allowed: its default")
    return value


def _kind(hint: Any) -> tuple[Any, bool]:
    """The type behind a hint, and whether it may be None."""
    options = typing.get_args(hint) if isinstance(hint, types.UnionType) else (hint,)
    return next(o for o in options if o is not type(None)), type(None) in options


def _number(value: Any, unit: str, label: str) -> float:
    if not isinstance(value, str):
        try:
            number, given = float(value), ""
        except (OverflowError, TypeError):
            number = math.nan
    else:
        match = _QUANTITY.fullmatch(value)
        try:
            number = float(match["number"]) if match and value.isascii() else math.nan
        except ValueError:
            number = math.nan
        given = match["unit"] if match else ""
    if not math.isfinite(number):
        raise SpecError(f"{label} is {shown(value, _SHOWN)}; allowed: a finite number")
    if given and given not in _UNITS.get(unit, {}):
        allowed = ", ".join(_UNITS.get(unit, {})) or "none"
        raise SpecError(f"{label} is {shown(value, _SHOWN)}; allowed units: {allowed}")
    # Rounding keeps 0.4mm from becoming 0.00040000000000000002 m in a canonical spec.
    return float(f"{number * _UNITS[unit][given]:.15g}") if given else number


def _range(least: float, most: float) -> str:
    if least == -math.inf:
        return "a number" if most == math.inf else f"up to {most:g}"
    if most == math.inf:
        return f"{least:g} or more"
    return f"{least:g} to {most:g}"


def _plain(value: Any) -> Any:
    if isinstance(value, frozenset):
        return sorted(value)
    return str(value) if isinstance(value, StrEnum) else value


def _text(value: Any) -> str:
    if value is None:
        return "none"
    if isinstance(value, frozenset):
        return "+".join(sorted(value))
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return repr(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)
    return str(value)
