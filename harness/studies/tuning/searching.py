"""Results of searches: rows made of their ledgers. Accuracies are shares, costs ms a layout."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
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
from steadyload.tuning.search import Search, hypervolume
from steadyload.tuning.trial import worth


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
    """A parameter that is searched, and its best value by engine."""

    name: str = column("parameter")
    values: str = column(about="allowed ones: a range with its step, or a list")
    start: str = column(left=False, about="in the genotype that a search begins with")
    found: Mapping[str, str] = column("{}")


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
    """A genotype that no other on the engine is as accurate as at a lower cost."""

    engine: str
    cost: float
    accuracy: float


@row
class Searching:
    """One search: pairs are of the genotype that it begins with, and of the best one.

    ``cases``: how many, and of which sets. ``goal``: the cost [ms] below which fitness does not
    grow further. ``changed``: parameters of which another value than the start was found, and all.
    """

    name: str = column("search")
    engine: str = column()
    algorithm: str = column()
    fitness: tuple[float, float] = column(form=_from_start("{:.4f}".format))
    accuracy: tuple[float, float] = column("accuracy %", _from_start(plain_percent))
    cost: tuple[float, float] = column("cost ms", _from_start(significant))
    hypervolume: float = column(form="{:.3f}".format, about="of its front")
    cpu: float = column("CPU", duration)
    wall: float = column(form=duration)
    space: str = column()
    seed: int = column()
    population: tuple[int, int] = column(form="{0[0]} x {0[1]}".format, about="and generations")
    genotypes: int = column(about="that were judged, wholly or in part")
    whole: int = column("judged whole", about="on all cases")
    abandoned: int = column(about="before all cases were judged")
    repeats: int = column(about="proposed again, and not judged again")
    known: int = column(about="found by an earlier search, in the first generation")
    parameter_sets: int = column("parameter sets", about="that its cost model was fitted to")
    correlation: float = column("rank correlation", "{:.3f}".format, "Spearman's, of the model")
    error: float = column("median error %", plain_percent)
    microseconds: Mapping[str, float] = column("{}", partial(compact, digits=3))
    cases: str
    goal: float
    changed: tuple[int, int]
    history: Sequence[Generation]


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


def _values(search: Search) -> Iterator[tuple[str, str, str, str]]:
    """Title, allowed values, start and best value of every parameter that is searched."""
    space = search.space
    start, best = (
        dict(canonical(space.parameters(genotype), [gene.name for gene in space.genes]))
        for genotype in (space.start, search.fittest().genotype)
    )
    for gene in space.genes:
        unit = f" ({gene.unit})" if gene.unit else ""
        yield gene.name + unit, gene.text, start[gene.name], best[gene.name]


def genes(searches: Iterable[Search]) -> list[Gene]:
    """The parameters that were searched; those of other values or another start stand apart."""
    rows: dict[tuple[str, str, str], dict[str, str]] = {}
    for search in searches:
        for *known, found in _values(search):
            rows.setdefault((known[0], known[1], known[2]), {})[search.options.engine] = found
    return [Gene(*known, found) for known, found in rows.items()]


def searching(search: Search) -> Searching:
    """A search as a page shows it."""
    options, ledger, name = search.options, search.ledger, search.name
    judged, whole = search.judged(), search.whole()
    entries = ledger.entries[search.space.start], search.fittest()
    start, best = (worth(entry.trial, search.goal) for entry in entries)
    fitness, accuracy, cost = zip(start, best, strict=True)
    parts = options.source.parts().items()
    described = " and ".join(f"part `{part}` of {of or 'the large set'}" for of, part in parts)
    model, moved = search.model, [start != found for *_, start, found in _values(search)]
    return Searching(
        name=name,
        engine=options.engine,
        algorithm=options.algorithm,
        fitness=fitness,
        accuracy=accuracy,
        cost=cost,
        hypervolume=hypervolume(search.front()),
        cpu=sum(entry.trial.cpu for entry in judged),
        wall=search.wall,
        space=options.space,
        seed=options.seed,
        population=(options.population, len(ledger.ends)),
        genotypes=len(judged),
        whole=len(whole),
        abandoned=len(judged) - len(whole),
        repeats=1 + sum(end.asked for end in ledger.ends) - len(judged),
        known=len(options.begin_with),
        parameter_sets=model.parameter_sets,
        correlation=model.correlation,
        error=model.error,
        microseconds={term: weight for term, weight in model.microseconds.items() if weight},
        cases=f"{len(search.cases)} of {described}",
        goal=search.goal,
        changed=(sum(moved), len(moved)),
        history=[_generation(search, name, end.number + 1) for end in ledger.ends],
    )


def _generation(search: Search, name: str, before: int) -> Generation:
    best, *_ = worth(search.fittest(before).trial, search.goal)
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
        )
        for (engine, space), group in groups.items()
        for algorithm, own in group.items()
    ]


def of_searches(searches: Sequence[Search]) -> dict[str, Any]:
    """The fields of :class:`steadyload.studies.tuning.presets.Found` that follow from searches.

    Of several searches on an engine the first one's parameters are shown.
    """
    first = {search.options.engine: search for search in reversed(searches)}
    rows = [searching(search) for search in searches]
    return {
        "genes": genes(first[engine] for engine in sorted(first)),
        "searches": rows,
        "algorithms": algorithms(rows),
    }
