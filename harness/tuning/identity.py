"""Identity of a search: two runs with the same identity are one search, which can be resumed."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from steadyload.methods.registry import make_method
from steadyload.methods.simulation.simulation_parameters import parameters_on
from steadyload.runs.provenance import made_by
from steadyload.tuning import cost, proposers, trial
from steadyload.tuning.options import SearchOptions
from steadyload.tuning.space import Gene, Space


def space_of(found: Mapping[str, Any]) -> Space:
    """The space of an :func:`identity`."""
    declared = {f.name: f for f in dataclasses.fields(parameters_on(found["engine"]))}
    genes = tuple(
        Gene(name, declared[name].metadata["unit"], tuple(values))
        for name, values in found["genes"].items()
    )
    return Space(found["space"], found["engine"], found["fixed"], genes, tuple(found["start"]))


def identity(options: SearchOptions, space: Space) -> dict[str, Any]:
    """Identity of a search. Budgets are not part of it: a search may go on longer."""
    return {
        **options.stored(),
        "genes": {gene.name: list(gene.values) for gene in space.genes},
        "fixed": dict(space.fixed),
        "start": list(space.start),
        "made_by": made_by(make_method(space.spec(space.start))),
        "search": {
            "proposals": proposers.VERSION,
            "judging": trial.VERSION,
            "cost": cost.VERSION,
        },
    }
