"""Parameter sets made from a tuned one: parts reset, physical values, or another engine."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, NamedTuple

from steadyload.engines.registry import capabilities
from steadyload.methods.contract.spec import as_plain, bind
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.simulation_parameters import parameters_on
from steadyload.methods.tuned import TUNED
from steadyload.tuning.space import Space, gene_groups, spec_of

Values = Mapping[str, Any]

_PHYSICAL: Mapping[str, Values] = {
    "friction": {"friction": 0.5},
    "restitution": {"restitution": 0.0},
    "friction and restitution": {"friction": 0.5, "restitution": 0.0},
    "damping": {"linear_damping": 0.0, "angular_damping": 0.0},
    "margin": {"margin": 0.0},
    "thresholds and time": {"eps_t": 10.0, "eps_r": 10.0, "t_max": 0.3},
}
"""Parameters of the reference simulation that makes the labels, by name of the change."""


class Change(NamedTuple):
    """A tuned parameter set with some values changed: its name, these as text, and the spec."""

    name: str
    values: str
    spec: str


def tuned_values(engine: str) -> dict[str, Any]:
    """All parameters of the tuned preset on its engine."""
    return as_plain(make_method(f"{TUNED}@{engine}").parameters)


def without_gains(space: Space, tuned: Values) -> list[Change]:
    """One change for every group of genes that is reset to the start of the search; and all."""
    start = space.values(space.start)
    groups = {
        name: {gene: start[gene] for gene in genes if gene in start}
        for name, genes in gene_groups().items()
    }
    return _changes(space.engine, tuned, {**groups, "everything": start})


def physical(engine: str, tuned: Values) -> list[Change]:
    """One change for every quantity that is set to the value of the reference simulation."""
    everything = {name: value for values in _PHYSICAL.values() for name, value in values.items()}
    return _changes(engine, tuned, {**_PHYSICAL, "all of these": everything})


def _changes(engine: str, tuned: Values, groups: Mapping[str, Values]) -> list[Change]:
    found = []
    for name, values in groups.items():
        different = {k: v for k, v in values.items() if k in tuned and tuned[k] != v}
        if different:
            text = ", ".join(f"{key} {value}" for key, value in different.items())
            bound = bind(parameters_on(engine), {**tuned, **different}, where=engine)
            found.append(Change(name, text, spec_of(engine, bound)))
    return found


def carried_over(tuned: Values, engine: str) -> tuple[str, tuple[str, ...]]:
    """A parameter set on another engine: its spec there, and parameters without effect there."""
    known = {field.name for field in dataclasses.fields(parameters_on(engine))}
    kept = {name: value for name, value in tuned.items() if name in known}
    bound = bind(parameters_on(engine), kept, where=engine)
    ignored = capabilities(engine).ignored(bound.world_settings())
    own = tuple(name for name in tuned if name not in known)
    return spec_of(engine, bound), (*ignored, *own)
