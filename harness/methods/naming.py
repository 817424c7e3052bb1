"""Names of methods on pages: title, family, engine."""

from __future__ import annotations

from dataclasses import dataclass

from steadyload.methods.contract.method import Method
from steadyload.methods.registry import method_class, presets


@dataclass(frozen=True, slots=True)
class MethodKey:
    """Name of a method on pages: ``family`` fixes its colour, ``engine`` its marker."""

    title: str
    spec: str
    family: str
    engine: str | None = None


def method_key(method: Method) -> MethodKey:
    """Name of a method on pages."""
    return named(method.spec.name, str(method.spec), method.spec.engine)


def named(name: str, spec: str, engine: str | None) -> MethodKey:
    """A readable name: the preset's title, else the spec itself."""
    preset = presets().get(name)
    values = spec.partition(":")[2]
    declared = method_class(name)
    title = preset.title if preset else (declared.title if declared else "") or name
    if engine:
        title += f" @ {engine}"
    return MethodKey(title + (f" ({values})" if values else ""), spec, name, engine)
