"""Names of methods and presets, and the one way from a spec string to a method.

A method is one line in :data:`METHODS`; a preset (a method with stored parameters) is one table in
``presets.toml``, or was tuned (``tuned.json``). Other distributions register methods through the
entry-point group ``steadyload.methods``, with values of the same form. Listing imports no engine.
"""

from __future__ import annotations

import dataclasses
import importlib.metadata
import logging
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from steadyload import config
from steadyload.engines.registry import capabilities, engines
from steadyload.errors import nearest
from steadyload.escaping import shown
from steadyload.layouts.model.question import Question
from steadyload.methods.contract.declared import Trait
from steadyload.methods.contract.method import Method
from steadyload.methods.contract.spec import (
    MethodSpec,
    SpecError,
    allowed_values,
    bind,
    canonical,
    parse_spec,
)
from steadyload.methods.tuned import ABOUT, tuned
from steadyload.plugins import OWN, PluginError, faulty, loaded
from steadyload.reading import own_file, toml_of

_log = logging.getLogger("steadyload")

GROUP = "steadyload.methods"
"""Group of entry points of methods."""

METHODS: dict[str, str] = {
    "fbs": "steadyload.methods.rules.base_support:FullBaseSupport",
    "pbs": "steadyload.methods.rules.base_support:PartialBaseSupport",
    "sme": "steadyload.methods.rules.sme:StaticMechanicalEquilibrium",
    "equilibrium": "steadyload.methods.equilibrium.equilibrium:Equilibrium",
    "settling": "steadyload.methods.equilibrium.settling:Settling",
    "simulation": "steadyload.methods.simulation.simulation:Simulation",
    "lstm_1": "steadyload.learners.methods:LearnedMethod",
    "lstm_e": "steadyload.learners.methods:LearnedEnsemble",
    "cascade": "steadyload.methods.cascade.cascade:Cascade",
}


@dataclass(frozen=True, slots=True)
class Preset:
    """A method with stored parameters: ``title`` for tables, ``source`` for where they are from.

    One that is tuned has other parameters on every engine, and exists on no other: ``tuned`` has
    them by question and engine. ``questions``: those that it was made for, one at a time; empty
    where only one was thought of.
    """

    name: str
    method: str
    title: str
    source: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    tuned: Mapping[str, Mapping[str, Mapping[str, Any]]] | None = None
    questions: tuple[Question, ...] = ()

    @property
    def by_engine(self) -> Mapping[str, Mapping[str, Any]] | None:
        """The parameters of one that is tuned, for the question of the label; None of others."""
        return None if self.tuned is None else self.tuned[Question.WITHIN]

    def parameters_on(self, engine: str | None, question: str | None = None) -> Mapping[str, Any]:
        """The stored parameters on an engine, tuned for a question where they were.

        Raises:
            SpecError: the preset is tuned, and was not on this engine.
        """
        if self.tuned is None:
            return self.parameters
        found = {**self.tuned[Question.WITHIN], **self.tuned.get(question or "", {})}
        if engine is None or engine not in found:
            raise SpecError(f"{self.name}@{engine}: {self._missing_on(engine)}")
        return found[engine]

    def _missing_on(self, engine: str | None) -> str:
        there = f"was tuned for {', '.join(self.by_engine or ()) or 'no engine yet'}"
        if engine is not None and capabilities(engine).error_controlled:
            return f"{engine} chooses its own steps, there is nothing to tune; {self.name} {there}"
        options = f"--engine {engine or 'NAME'} {ABOUT[self.name].search} --preset {self.name}"
        return f"{self.name} {there}; to tune it run steadyload tune {options} --write-preset"


def presets() -> Mapping[str, Preset]:
    """All presets by name."""
    return _stated() | _tuned()


@cache
def _stated() -> dict[str, Preset]:
    file = own_file("steadyload.methods", "presets.toml")
    return {
        name: config.bind(Preset, table, f"{file}: {name}", SpecError, name=name)
        for name, table in toml_of(file, SpecError).items()
    }


def _tuned() -> dict[str, Preset]:
    return {
        name: Preset(
            name,
            "simulation",
            about.title,
            about.source,
            tuned={
                question: {e: own.parameters for e, own in tuned(question, name).items()}
                for question in Question
            },
            questions=tuple(Question),
        )
        for name, about in ABOUT.items()
    }


def method_classes() -> dict[str, str]:
    """Name -> "module:Class" of every method, with those of other distributions."""
    return _from_other_distributions() | METHODS


@cache
def _from_other_distributions() -> dict[str, str]:
    found = importlib.metadata.entry_points(group=GROUP)
    return {entry.name: entry.value for entry in found}


def make_method(spec: str | MethodSpec) -> Method:
    """The method that a spec string names.

    Args:
        spec: ``name[@engine][:key=value,...]``, where the name is a method's or a preset's.

    Raises:
        SpecError: no such method, engine or parameter, or a value out of range.
    """
    if not isinstance(spec, str | MethodSpec):
        raise SpecError(f"method is {shown(spec)}; allowed: a text, such as sme or label@mujoco")
    parsed = parse_spec(spec) if isinstance(spec, str) else spec
    method = method_class(parsed.name)
    if method is None:
        known = [*method_classes(), *presets()]
        raise SpecError(f"unknown method {shown(parsed.name)}; {nearest(parsed.name, known)}")
    preset = presets().get(parsed.name)
    _check_engine(parsed, method)
    stated = dict(parsed.values)
    question = stated.get("question")
    stored = preset.parameters_on(parsed.engine, question) if preset else {}
    implied = {} if "question" in stored else method.implied_by(stated)
    values = {**stored, **implied, **stated}
    parameters = bind(method.parameters_on(parsed.engine), values, where=str(parsed))
    named = canonical(parameters, stated)
    return method(MethodSpec(parsed.name, parsed.engine, named), parameters)


def method_of(method: str | Method) -> Method:
    """The method that a caller hands over, as itself or by its spec string.

    Raises:
        SpecError: it is neither, or as :func:`make_method`.
    """
    return method if isinstance(method, Method) else make_method(method)


def method_class(name: str) -> type[Method] | None:
    """The class behind a method's or a preset's name; None where no such method is registered.

    Raises:
        PluginError: it is of another distribution and cannot be used.
    """
    preset = presets().get(name)
    target = method_classes().get(preset.method if preset else name)
    return None if target is None else _load(preset.method if preset else name, target)


def usable_methods() -> dict[str, type[Method]]:
    """All methods by name; of each that is faulty and of another distribution, a warning."""
    found = {}
    for name, target in method_classes().items():
        try:
            found[name] = _load(name, target)
        except PluginError as error:
            _log.warning("%s", error)
    return found


def methods_with(trait: Trait, engine: str | None = None) -> tuple[str, ...]:
    """Specs of the methods that declare a trait with their defaults, wherever they come from.

    Args:
        trait: that is wanted.
        engine: that methods run on which need one; None leaves these out.
    """
    specs = (
        MethodSpec(name, engine if method.needs_engine else None)
        for name, method in usable_methods().items()
        if engine is not None or not method.needs_engine
    )
    return tuple(str(spec) for spec in specs if trait in make_method(spec).traits)


def each_question(name: str) -> tuple[Question, ...]:
    """The questions that a method or preset was made for, one at a time.

    A method has a parameter ``question`` for them, a preset states them. Empty for what answers
    in one way, and for what was made for one question alone.
    """
    if name in presets():
        return presets()[name].questions
    method = method_class(name)
    known = {f.name for f in dataclasses.fields(method.Parameters)} if method else set()
    return tuple(Question) if "question" in known else ()


@dataclass(frozen=True, slots=True)
class ParameterEntry:
    """A parameter as a listing shows it."""

    name: str
    value: str
    unit: str
    allowed: str
    about: str


@dataclass(frozen=True, slots=True)
class MethodEntry:
    """A method or preset as a listing shows it."""

    name: str
    needs_engine: bool
    about: str
    parameters: tuple[ParameterEntry, ...]


def method_listing(engine: str | None = None) -> list[MethodEntry]:
    """All methods, then all presets, with their parameters.

    Args:
        engine: list the parameters that methods have on this engine, its own options among them.

    Raises:
        SpecError: no such engine.
    """
    if engine is not None and engine not in engines():
        raise SpecError(f"unknown engine {shown(engine)}; {nearest(engine, engines())}")
    entries = []
    usable = usable_methods()
    for name, method in usable.items():
        about = (method.__doc__ or name).strip().partition("\n")[0].replace("``", "")
        entries.append(
            MethodEntry(name, method.needs_engine, about, _parameters(method, engine, {}))
        )
    for preset in presets().values():
        method = usable[preset.method]
        about = f"{preset.title}: {preset.method} with the values of {preset.source}"
        parameters: tuple[ParameterEntry, ...] = ()
        if preset.by_engine is None or engine in preset.by_engine:
            parameters = _parameters(method, engine, preset.parameters_on(engine))
        else:
            there = ", ".join(f"{preset.name}@{name}" for name in preset.by_engine)
            about += f" ({there or 'none yet: steadyload tune'})"
        entries.append(MethodEntry(preset.name, method.needs_engine, about, parameters))
    return entries


def method_parameters(method: Method) -> tuple[ParameterEntry, ...]:
    """The parameters of a method, with its values."""
    return _entries(method.parameters_on(method.spec.engine), method.parameters)


def _parameters(
    method: type[Method], engine: str | None, values: Mapping[str, Any]
) -> tuple[ParameterEntry, ...]:
    declared = method.parameters_on(engine)
    return _entries(declared, bind(declared, values, where="preset"))


def _entries(declared: type[Any], bound: Any) -> tuple[ParameterEntry, ...]:
    texts = dict(canonical(bound, [f.name for f in dataclasses.fields(bound)]))
    return tuple(
        ParameterEntry(
            f.name,
            texts[f.name],
            f.metadata.get("unit", ""),
            allowed_values(declared, f.name),
            f.metadata.get("about", ""),
        )
        for f in dataclasses.fields(bound)
    )


def _load(name: str, target: str) -> type[Method]:
    found = loaded(target, GROUP, name)
    if target.startswith(OWN):
        return found
    if not (isinstance(found, type) and issubclass(found, Method)):
        raise faulty(GROUP, name, f"{target} is no subclass of Method")
    if not dataclasses.is_dataclass(getattr(found, "Parameters", None)):
        raise faulty(GROUP, name, f"{target} has no dataclass Parameters")
    try:
        found.Parameters()
    except (Exception, SystemExit) as error:
        raise faulty(GROUP, name, f"Parameters() fails: {type(error).__name__}: {error}") from error
    return found


def _check_engine(spec: MethodSpec, method: type[Method]) -> None:
    if not method.needs_engine:
        if spec.engine:
            raise SpecError(f"{spec}: {spec.name} needs no engine; write it without @{spec.engine}")
    elif not spec.engine:
        raise SpecError(
            f"{spec}: {spec.name} needs an engine, for example {spec.name}@mujoco; "
            f"allowed: {', '.join(engines())}"
        )
    elif spec.engine not in engines():
        raise SpecError(f"unknown engine {shown(spec.engine)}; {nearest(spec.engine, engines())}")
