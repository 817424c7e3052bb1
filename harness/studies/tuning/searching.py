"""Results of searches, and their effort: rows made of their ledgers.

Accuracies are shares, costs are in ms a layout.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from itertools import chain
from statistics import fmean
from typing import Any

from steadyload.methods.contract.spec import canonical
from steadyload.reports.columns import (
    column,
    compact,
    duration,
    fixed,
    plain_percent,
    row,
    significant,
)
from steadyload.statistics.estimate import Estimate
from steadyload.tuning.ledger import Entry
from steadyload.tuning.presets import worth
from steadyload.tuning.search import Search

CHEAPEST, DEAREST = 0.3, 100.0
"""Costs [ms] between which fronts are compared."""


def _from_start(form: Callable[[float], str]) -> Callable[[tuple[float, float]], str]:
    """A number of the genotype that a search begins with, and of the best one found."""
    return lambda pair: f"{form(pair[0])} → {form(pair[1])}"


def _spread(digits: int) -> Callable[[Estimate], str]:
    """A mean over searches, and the range where there are several."""

    def form(found: Estimate) -> str:
        mean, low, high = (fixed(v, digits) for v in (found.value, found.low, found.high))
        return mean if found.n == 1 else f"{mean} ({low} to {high})"

    return form


def spread(values: Sequence[float]) -> Estimate:
    """The mean of values, and their range in the place of an interval."""
    return Estimate(fmean(values), min(values), max(values), len(values))


@row
class Gene:
    """A parameter that is searched."""

    name: str = column("parameter")
    unit: str = column(form=lambda unit: unit or "-", left=True)
    values: str = column(about="allowed ones: a range with its step, or a list")
    start: str = column(left=False, about="in the genotype that a search begins with")
    found: str = column(left=False, about="in the best one")


@row
class Searched:
    """Parameters searched on an engine by the search that found its preset, and the cost model.

    ``cases``: how many genotypes were judged on, and of which sets. ``goal``: the cost [ms] below
    which fitness does not grow further.
    """

    engine: str = column()
    parameter_sets: int = column("parameter sets", about="that the model was fitted to")
    correlation: float = column(
        "rank correlation", "{:.3f}".format, "Spearman's, of modelled and measured costs"
    )
    error: float = column("median error %", plain_percent)
    microseconds: Mapping[str, float] = column("{}", partial(compact, digits=3))
    cases: str
    goal: float
    genes: Sequence[Gene]

    @property
    def kept(self) -> list[str]:
        """Parameters whose start was found to be best."""
        return [gene.name for gene in self.genes if gene.start == gene.found]

    @property
    def changed(self) -> int:
        """How many other parameters there are."""
        return len(self.genes) - len(self.kept)


@row
class Generation:
    """A search after a generation: genotypes judged so far, wholly or in part, the fitness of the
    best, and the hypervolume of the front.
    """

    search: str
    judged: int
    best: float
    volume: float


@row
class Point:
    """A genotype that no other is as accurate as at a lower cost."""

    search: str
    cost: float
    accuracy: float


@row
class Searching:
    """One search: pairs are of the genotype that it begins with, and of the best one."""

    name: str
    engine: str = column()
    algorithm: str = column()
    genotypes: int = column(about="that were judged, wholly or in part")
    fitness: tuple[float, float] = column(form=_from_start("{:.4f}".format))
    accuracy: tuple[float, float] = column("accuracy %", _from_start(plain_percent))
    cost: tuple[float, float] = column("cost ms", _from_start(significant))
    hypervolume: float = column(form="{:.3f}".format, about="of its front, see :func:`hypervolume`")
    cpu: float = column("CPU", duration)
    wall: float = column(form=duration)
    space: str = column()
    seed: int = column()
    population: tuple[int, int] = column(
        form="{0[0]} x {0[1]}".format, about="its size, and the number of generations"
    )
    whole: int = column("judged whole", about="on all cases")
    given_up: int = column("given up", about="before all cases were judged")
    repeats: int = column(about="proposed again, and not judged again")
    known: int
    history: Sequence[Generation]
    front: Sequence[Point]


@row
class Algorithm:
    """Searches of one algorithm on an engine and in a space that another one searched, too."""

    searched: str = column()
    algorithm: str = column()
    searches: int = column()
    genotypes: float = column(form=fixed, about="mean of the searches")
    hypervolume: Estimate = column(form=_spread(3))
    fitness: Estimate = column("best fitness", _spread(4))
    history: Sequence[Generation]
    front: Sequence[Point]


def hypervolume(front: Iterable[Entry]) -> float:
    """Area under a front: accuracy over log10 of the cost, as a share of the largest possible area.

    Args:
        front: by rising cost.
    """
    area, accuracy, since = 0.0, 0.0, CHEAPEST
    for entry in front:
        cost = min(max(entry.trial.mean_cost, CHEAPEST), DEAREST)
        area += accuracy * math.log10(cost / since)
        accuracy, since = entry.trial.accuracy, cost
    area += accuracy * math.log10(DEAREST / since)
    return area / math.log10(DEAREST / CHEAPEST)


def points(front: Iterable[Entry], search: str = "") -> list[Point]:
    """The points of a front."""
    return [Point(search, entry.trial.mean_cost, entry.trial.accuracy) for entry in front]


def searched(search: Search) -> Searched:
    """The parameters and the cost model of a search."""
    parts = search.options.source.parts().items()
    described = " and ".join(f"part `{part}` of {of or 'the large set'}" for of, part in parts)
    model, genes = search.model, search.space.genes
    start, found = (
        dict(canonical(search.space.parameters(genotype), [gene.name for gene in genes]))
        for genotype in (search.space.start, search.fittest().genotype)
    )
    return Searched(
        engine=search.options.engine,
        parameter_sets=model.parameter_sets,
        correlation=model.correlation,
        error=model.error,
        microseconds={term: weight for term, weight in model.microseconds.items() if weight},
        cases=f"{len(search.cases)} of {described}",
        goal=search.goal,
        genes=[Gene(g.name, g.unit, g.text, start[g.name], found[g.name]) for g in genes],
    )


def searching(search: Search) -> Searching:
    """A search as a page shows it."""
    options, ledger, name = search.options, search.ledger, search.name
    judged, whole, front = search.judged(), search.whole(), search.front()
    start, best = worth(search, ledger.entries[search.space.start]), worth(search, search.fittest())
    fitness, accuracy, cost = zip(start, best, strict=True)
    return Searching(
        name=name,
        engine=options.engine,
        algorithm=options.algorithm,
        genotypes=len(judged),
        fitness=fitness,
        accuracy=accuracy,
        cost=cost,
        hypervolume=hypervolume(front),
        cpu=sum(entry.trial.cpu for entry in judged),
        wall=search.wall,
        space=options.space,
        seed=options.seed,
        population=(options.population, len(ledger.ends)),
        whole=len(whole),
        given_up=len(judged) - len(whole),
        repeats=1 + sum(end.asked for end in ledger.ends) - len(judged),
        known=len(options.begin_with),
        history=[_generation(search, name, end.number + 1) for end in ledger.ends],
        front=points(front, name),
    )


def _generation(search: Search, name: str, before: int) -> Generation:
    best, *_ = worth(search, search.fittest(before))
    return Generation(name, len(search.judged(before)), best, hypervolume(search.front(before)))


def algorithms(searches: Iterable[Searching]) -> list[Algorithm]:
    """Algorithms that made searches of one engine in one space; empty without two on one."""
    groups: dict[tuple[str, str], dict[str, list[Searching]]] = {}
    for one in searches:
        groups.setdefault((one.engine, one.space), {}).setdefault(one.algorithm, []).append(one)
    groups = {where: own for where, own in groups.items() if len(own) > 1}
    alone = len({space for _, space in groups}) == 1
    return [
        Algorithm(
            searched=engine if alone else f"{engine}, {space}",
            algorithm=algorithm,
            searches=len(own),
            genotypes=fmean(one.genotypes for one in own),
            hypervolume=spread([one.hypervolume for one in own]),
            fitness=spread([one.fitness[1] for one in own]),
            history=list(chain.from_iterable(one.history for one in own)),
            front=list(chain.from_iterable(one.front for one in own)),
        )
        for (engine, space), group in groups.items()
        for algorithm, own in group.items()
    ]


def of_searches(searches: Sequence[Search]) -> dict[str, Any]:
    """The fields of :class:`steadyload.studies.tuning.comparing.Found` that follow from searches.

    Of several searches on an engine the first one's parameters and cost model are shown.
    """
    first = {search.options.engine: search for search in reversed(searches)}
    rows = [searching(search) for search in searches]
    return {
        "searched": [searched(search) for search in first.values()],
        "searches": rows,
        "algorithms": algorithms(rows),
    }
