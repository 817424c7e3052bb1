"""Search spaces of engines: genes, their values, and the start of a search."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from steadyload.engines.registry import engines, world_class
from steadyload.engines.world import SETTINGS, Support
from steadyload.errors import nearest
from steadyload.layouts.model.question import Question
from steadyload.methods.contract.spec import as_plain, bind, canonical
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.simulation_parameters import (
    SimulationParameters,
    parameters_on,
)
from steadyload.reading import own_file, toml_of
from steadyload.tuning import TuningError

DEFAULT = "extended"
"""The space that presets are tuned in."""

PAPERS = "table3"
"""The space of the parameters that the paper searched."""

Genotype = tuple[int, ...]
"""For every gene of a space the place of its value among those it may have."""


_LISTED = 5
"""So many evenly spaced values are listed; more are a range."""


@dataclass(frozen=True, slots=True)
class Gene:
    """A parameter that is searched.

    Attributes:
        name: of the parameter.
        unit: of its values; empty where they have none.
        values: what it may be, at least two; numbers rise.
    """

    name: str
    unit: str
    values: tuple[Any, ...]

    @property
    def text(self) -> str:
        """The values for people."""
        if len(self.values) > _LISTED and all(isinstance(v, (int, float)) for v in self.values):
            steps = np.diff(np.array(self.values, dtype=float))
            if np.allclose(steps, steps[0]):
                return f"{self.values[0]:g} to {self.values[-1]:g}, step {steps[0]:g}"
        return ", ".join(f"{v:g}" if isinstance(v, float) else str(v) for v in self.values)


@dataclass(frozen=True)
class Space:
    """Everything that is searched on one engine.

    Attributes:
        name: registered in ``spaces.toml``.
        engine: registered name.
        fixed: parameters that are the same in every genotype.
        genes: what is searched, in the order of the file.
        start: the genotype that a search begins with, beside random ones.
    """

    name: str
    engine: str
    fixed: Mapping[str, Any]
    genes: tuple[Gene, ...]
    start: Genotype

    def values(self, genotype: Genotype) -> dict[str, Any]:
        """The parameters of a genotype that are searched."""
        return {g.name: g.values[at] for g, at in zip(self.genes, genotype, strict=True)}

    def parameters(self, genotype: Genotype) -> SimulationParameters:
        """All parameters of a genotype.

        Raises:
            SpecError: they cannot stand together, such as less than a substep a placement.
        """
        stated = {**self.fixed, **self.values(genotype)}
        return bind(parameters_on(self.engine), stated, where=self.engine)

    def spec(self, genotype: Genotype) -> str:
        """A genotype as the spec string of a method."""
        bound = self.parameters(genotype)
        return spec_of(self.engine, bound, [*self.fixed, *(g.name for g in self.genes)])

    def genotype(self, spec: str) -> Genotype:
        """The genotype of a simulation, given as the spec of a method.

        Raises:
            SpecError: see :func:`steadyload.methods.registry.make_method`.
            TuningError: it is no simulation on the engine, or has a value that none has here.
        """
        method = make_method(spec)
        parameters = getattr(method, "parameters", None)
        if not isinstance(parameters, parameters_on(self.engine)):
            raise TuningError(f"{spec}: is no simulation on engine {self.engine!r}")
        values = as_plain(parameters)
        allowed = {name: (value,) for name, value in self.fixed.items()}
        allowed |= {gene.name: gene.values for gene in self.genes}
        for name, among in allowed.items():
            if values[name] not in among:
                raise TuningError(
                    f"{spec}: {name} is {values[name]!r}; allowed in space {self.name!r}: "
                    + ", ".join(map(repr, among))
                )
        return tuple(gene.values.index(values[gene.name]) for gene in self.genes)

    def with_values(self, genotype: Genotype, values: Mapping[str, Any]) -> Genotype:
        """The genotype with some genes at other values; they must be among those of the gene."""
        return tuple(
            g.values.index(values[g.name]) if g.name in values else at
            for g, at in zip(self.genes, genotype, strict=True)
        )


def spec_of(engine: str, parameters: SimulationParameters, keys: list[str] | None = None) -> str:
    """The spec string of a simulation with these parameters.

    Args:
        engine: registered name.
        parameters: of a simulation on that engine.
        keys: state only these; None states all that differ from the defaults.
    """
    if keys is None:
        default = as_plain(parameters_on(engine)())
        keys = [k for k, value in as_plain(parameters).items() if value != default[k]]
    values = ",".join(f"{key}={value}" for key, value in canonical(parameters, keys))
    return str(make_method(f"simulation@{engine}:{values}").spec)


def space_names() -> tuple[str, ...]:
    """Names of all spaces."""
    return tuple(_spaces())


def question_of(name: str) -> str:
    """The question that the genotypes of a space are asked; the usual one where there is none."""
    return str(_spaces().get(name, {}).get("fixed", {}).get("question", Question.WITHIN))


def gene_groups() -> dict[str, tuple[str, ...]]:
    """Genes that belong together, whatever the space, by the name of the group."""
    return {name: tuple(genes) for name, genes in _data()["groups"].items()}


@cache
def space_on(engine: str, name: str = DEFAULT) -> Space:
    """A space on an engine, without the genes that play no part there.

    Raises:
        TuningError: no such space or engine, or an engine that chooses its own steps, unless the
            space is of contacts alone.
        EngineNotInstalledError: the engine's library is missing.
    """
    if name not in _spaces():
        raise TuningError(f"unknown space {name!r}; {nearest(name, _spaces())}")
    if engine not in engines():
        raise TuningError(f"unknown engine {engine!r}; {nearest(engine, engines())}")
    table = _spaces()[name]
    if world_class(engine).capabilities.error_controlled and not table.get("contacts_alone"):
        raise TuningError(f"engine {engine!r} chooses its own steps: there is nothing to tune")
    declared = {f.name: f for f in dataclasses.fields(parameters_on(engine))}
    genes, start = [], []
    for gene_name, given in table["genes"].items():
        if gene_name not in declared:
            continue
        values = _met(engine, gene_name, _listed(given))
        if len(values) < 2:
            continue
        begin = table["start"].get(gene_name, declared[gene_name].default)
        context = {**table["fixed"], **{k: v for k, v in table["start"].items() if k in declared}}
        values = tuple(_bound(engine, context, gene_name, value) for value in values)
        begin = _bound(engine, context, gene_name, begin)
        if begin not in values:
            raise TuningError(
                f"space {name!r}: {gene_name} starts at {begin!r}, not one of {values}"
            )
        genes.append(Gene(gene_name, declared[gene_name].metadata["unit"], values))
        start.append(values.index(begin))
    return Space(name, engine, dict(table["fixed"]), tuple(genes), tuple(start))


def _bound(engine: str, context: Mapping[str, Any], name: str, value: Any) -> Any:
    """A value as the method's parameters hold it, beside others that are allowed."""
    whole = bind(parameters_on(engine), {**context, name: value}, where="spaces.toml")
    return as_plain(whole)[name]


def _met(engine: str, name: str, values: tuple[Any, ...]) -> tuple[Any, ...]:
    """The values that an engine does not ignore."""
    if name not in SETTINGS:
        return values
    answer = world_class(engine).capabilities.settings[name]
    if answer.support in (Support.IGNORED, Support.ON_REQUEST):
        return ()
    if answer.values is None:
        return values
    return tuple(value for value in values if value in answer.values)


def _listed(given: Any) -> tuple[Any, ...]:
    if isinstance(given, list):
        return tuple(given)
    least, most, step = given["least"], given["most"], given["step"]
    count = int((most - least) / step + 1e-9) + 1
    # Rounding keeps 0.1 + 2 * 0.1 from becoming 0.30000000000000004 in a spec.
    return tuple(round(least + k * step, 10) for k in range(count))


@cache
def _spaces() -> dict[str, Any]:
    data = _data()
    return {name: _whole(table) for name, table in data.items() if "genes" in table}


def _whole(table: Mapping[str, Any]) -> Mapping[str, Any]:
    """A space with what it has in common with the one that it is like."""
    if "like" not in table:
        return table
    base = _whole(_data()[table["like"]])
    merged = {key: {**base[key], **table.get(key, {})} for key in ("fixed", "start", "genes")}
    for gone in table.get("without", ()):
        merged["genes"].pop(gone)
        merged["start"].pop(gone)
    return {**table, **merged}


@cache
def _data() -> dict[str, Any]:
    return toml_of(own_file("steadyload.tuning", "spaces.toml"), TuningError)
