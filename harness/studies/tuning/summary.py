"""Typed results on tuning, and those of searches, made of their ledgers.

Accuracies are shares, costs are in ms.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from steadyload.methods.contract.spec import canonical
from steadyload.runs.costs import CostSource
from steadyload.runs.evaluation import MethodEvaluation
from steadyload.statistics.estimate import Estimate
from steadyload.tuning.ledger import Entry
from steadyload.tuning.presets import worth
from steadyload.tuning.search import Search
from steadyload.tuning.space import Genotype

CHEAPEST, DEAREST = 0.3, 100.0
"""Costs [ms] between which fronts are compared."""


@dataclass(frozen=True, slots=True)
class GeneRow:
    """One parameter that is searched.

    ``values``: allowed values as text (a range with its step, or a list). ``start``: its value in
    the genotype that a search begins with. ``found``: in the best one of the search.
    """

    name: str
    unit: str
    values: str
    start: str
    found: str


@dataclass(frozen=True, slots=True)
class GenerationRow:
    """A search after one of its generations, the first being number 0.

    ``best``: fitness of the best genotype so far, and its ``accuracy`` and ``cost``. ``median``:
    fitness of this generation. ``judged``: genotypes judged so far, wholly or in part.
    ``hypervolume``: of the front so far (:class:`SearchRow`).
    """

    number: int
    best: float
    median: float
    accuracy: float
    cost: float
    judged: int
    hypervolume: float


@dataclass(frozen=True, slots=True)
class JudgedGenotype:
    """A genotype judged on all cases: its accuracy and modelled cost, and whether it is on the
    front: no other is as accurate at a lower cost.
    """

    accuracy: float
    cost: float
    on_front: bool


@dataclass(frozen=True, slots=True)
class SearchRow:
    """One search.

    Attributes:
        engine, algorithm, space, seed: identity of the search.
        population, generations: size, and number of finished generations.
        known: genotypes of the first generation that were known before the search.
        genotypes: number of different judged ones; ``whole``: of these, those judged on all cases;
            ``repeats``: number proposed again, which were not judged again.
        cpu, wall: seconds spent.
        start, found: fitness, accuracy and cost of the genotype a search begins with and of the
            best one.
        hypervolume: area between the front and the corner of no accuracy at the highest cost
            shown, over log10 of the cost; 1 is all of it.
        history, judged: rows of the generations and of the judged genotypes.
    """

    engine: str
    algorithm: str
    space: str
    seed: int
    population: int
    generations: int
    known: int
    genotypes: int
    whole: int
    repeats: int
    cpu: float
    wall: float
    start: tuple[float, float, float]
    found: tuple[float, float, float]
    hypervolume: float
    history: tuple[GenerationRow, ...]
    judged: tuple[JudgedGenotype, ...]


@dataclass(frozen=True, slots=True)
class CostRow:
    """Cost model of an engine: CPU time from the effort of a simulation.

    ``terms``: microseconds by counted quantity. ``correlation``: Spearman's, between modelled and
    measured, over ``parameter_sets``. ``error``: median of the relative error.
    """

    engine: str
    terms: Mapping[str, float]
    parameter_sets: int
    correlation: float
    error: float


@dataclass(frozen=True, slots=True)
class TunedTable:
    """A tuned method and others on one engine, on cases on which it was not tuned.

    ``tuned`` and ``others`` were judged in the same run; each of the others is compared with the
    tuned one: the difference of accuracy, and the ratio of CPU times, tuned over other.
    """

    engine: str
    part: str
    tuned: MethodEvaluation
    others: tuple[MethodEvaluation, ...]


@dataclass(frozen=True, slots=True)
class KnowledgeStep:
    """A parameter set on the way from the paper's values to the tuned ones.

    ``found``: on cases on which nothing was searched. ``gain``: its accuracy less that of the set
    before it; None for the first.
    """

    title: str
    found: MethodEvaluation
    gain: Estimate | None


@dataclass(frozen=True, slots=True)
class KnowledgeTable:
    """The gain of a protocol on one engine, and that of a search.

    ``steps``: the paper's values; the best of a search over the paper's own parameters, where there
    is one; the label's protocol with nothing searched; and the tuned parameters.
    """

    engine: str
    part: str
    steps: tuple[KnowledgeStep, ...]


@dataclass(frozen=True, slots=True)
class Variant:
    """The tuned parameters with some of them changed.

    ``change``: name of the change, ``values``: its new values. ``accuracy_change`` and
    ``cost_change`` (a factor) are relative to the tuned ones, on the same cases.
    """

    change: str
    values: str
    found: MethodEvaluation
    accuracy_change: Estimate
    cost_change: float


@dataclass(frozen=True, slots=True)
class VariantTable:
    """Variants of the parameters tuned on one engine, on one part of the labelled set."""

    engine: str
    part: str
    rows: tuple[Variant, ...]


@dataclass(frozen=True, slots=True)
class TransferCell:
    """Parameters tuned on one engine, judged on another.

    ``found`` is compared with the parameters tuned on ``judged_on``, where these are not they.
    """

    tuned_on: str
    judged_on: str
    found: MethodEvaluation


@dataclass(frozen=True, slots=True)
class TransferTable:
    """All pairs of engines on the same cases.

    ``ignored``: by pair (tuned on, judged on), parameters that the second engine ignores.
    """

    part: str
    engines: tuple[str, ...]
    cells: tuple[TransferCell, ...]
    ignored: Mapping[tuple[str, str], tuple[str, ...]]


@dataclass(frozen=True, slots=True)
class PricePoint:
    """The most accurate of all judged parameter sets whose cost is below a budget.

    ``budget``: ms a layout. ``validation``: accuracy where it was chosen. ``test``: on other cases,
    with the CPU time measured there; None where no set is within the budget.
    """

    engine: str
    budget: float
    values: str
    validation: float
    test: MethodEvaluation | None


@dataclass(frozen=True, slots=True)
class SeedRow:
    """Result of the search with one seed: on validation, and once on test."""

    engine: str
    seed: int
    fitness: float
    validation: float
    test: MethodEvaluation
    values: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Tuning:
    """All results on tuning. Parts that were not computed are empty.

    ``parts``: by engine, what its first search judged: part by labelled set, None for the large
    one. ``cases``: how many of them. ``goal``: by engine, the cost [ms] below
    which fitness does not grow further: 18.5 % of that of PS_3, unless one was stated.
    ``parameters``: by engine, the found values, in the order of the space. ``cost_source``:
    of measured CPU times; None where nothing was tested.
    """

    parts: Mapping[str, Mapping[str | None, str]]
    cases: Mapping[str, int]
    goal: Mapping[str, float]
    costs: tuple[CostRow, ...] = ()
    searches: tuple[SearchRow, ...] = ()
    parameters: Mapping[str, tuple[GeneRow, ...]] | None = None
    tests: tuple[TunedTable, ...] = ()
    knowledge: tuple[KnowledgeTable, ...] = ()
    seeds: tuple[SeedRow, ...] = ()
    left_out: tuple[VariantTable, ...] = ()
    plausibility: tuple[VariantTable, ...] = ()
    transfer: tuple[TransferTable, ...] = ()
    prices: tuple[PricePoint, ...] = ()
    cost_source: CostSource | None = None


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


def search_row(search: Search) -> SearchRow:
    """A search as a page shows it."""
    options, ledger = search.options, search.ledger
    entries = search.judged()
    start = ledger.entries[search.space.start]
    front = {entry.genotype for entry in search.front()}
    asked = 1 + sum(end.asked for end in ledger.ends)
    return SearchRow(
        engine=options.engine,
        algorithm=options.algorithm,
        space=options.space,
        seed=options.seed,
        population=options.population,
        generations=len(ledger.ends),
        known=len(options.begin_with),
        genotypes=len(entries),
        whole=len(search.whole()),
        repeats=asked - len(entries),
        cpu=sum(entry.trial.cpu for entry in entries),
        wall=search.wall,
        start=worth(search, start),
        found=worth(search, search.fittest()),
        hypervolume=hypervolume(search.front()),
        history=tuple(_generation(search, end.number, end.median) for end in ledger.ends),
        judged=tuple(
            JudgedGenotype(e.trial.accuracy, e.trial.mean_cost, e.genotype in front)
            for e in search.whole()
        ),
    )


def _generation(search: Search, number: int, median: float) -> GenerationRow:
    known = search.judged(number + 1)
    front = search.front(number + 1)
    best, accuracy, cost = worth(search, search.fittest(number + 1))
    return GenerationRow(number, best, median, accuracy, cost, len(known), hypervolume(front))


def cost_row(search: Search) -> CostRow:
    """The cost model of a search as a page shows it."""
    model = search.model
    return CostRow(
        search.options.engine,
        {term: weight for term, weight in model.microseconds.items() if weight},
        model.parameter_sets,
        model.correlation,
        model.error,
    )


def gene_rows(search: Search, found: Genotype | None = None) -> tuple[GeneRow, ...]:
    """The searched genes with the found values; ``found`` is None for the fittest genotype."""
    space = search.space
    found = search.fittest().genotype if found is None else found
    start, best = (_texts(search, genotype) for genotype in (space.start, found))
    return tuple(
        GeneRow(gene.name, gene.unit, gene.text, start[gene.name], best[gene.name])
        for gene in space.genes
    )


def _texts(search: Search, genotype: Genotype) -> dict[str, str]:
    names = [gene.name for gene in search.space.genes]
    return dict(canonical(search.space.parameters(genotype), names))


def tuning_of(searches: Sequence[Search]) -> Tuning:
    """Record of searches alone: costs, histories, searched genes and found values.

    Of several searches on an engine the first one's parameters are shown.
    """
    first = {search.options.engine: search for search in reversed(searches)}
    return Tuning(
        parts={engine: search.options.source.parts() for engine, search in first.items()},
        cases={engine: len(search.cases) for engine, search in first.items()},
        goal={engine: search.goal for engine, search in first.items()},
        costs=tuple(cost_row(search) for search in first.values()),
        searches=tuple(search_row(search) for search in searches),
        parameters={engine: gene_rows(search) for engine, search in first.items()},
    )
