"""From the ledger of a search to the records that a page shows."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from steadyload.methods.spec import canonical
from steadyload.studies.tuning.records import (
    CostRow,
    GenerationRow,
    GeneRow,
    JudgedGenotype,
    SearchRow,
    Tuning,
)
from steadyload.tuning.ledger import Entry
from steadyload.tuning.presets import worth
from steadyload.tuning.search import Search
from steadyload.tuning.space import Genotype

CHEAPEST, DEAREST = 0.3, 100.0
"""Costs [ms] between which fronts are compared."""


def hypervolume(front: Iterable[Entry]) -> float:
    """Area under a front: its accuracy over log10 of the cost, as a share of all there could be.

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
    """What was searched, and what was found; None for the fittest."""
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
    """What searches alone tell: costs, histories, and what was searched and found.

    Of several searches on an engine the first one's parameters are shown.
    """
    first = {search.options.engine: search for search in reversed(searches)}
    return Tuning(
        part=searches[0].options.source.part,
        cases=len(searches[0].cases),
        goal={engine: search.goal for engine, search in first.items()},
        costs=tuple(cost_row(search) for search in first.values()),
        searches=tuple(search_row(search) for search in searches),
        parameters={engine: gene_rows(search) for engine, search in first.items()},
    )
