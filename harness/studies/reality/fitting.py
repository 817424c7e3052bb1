"""Contacts of an engine, fitted to one half of a record by seeded searches."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from steadyload.engines.attitudes import degrees_apart
from steadyload.measured.simulating import VERSION
from steadyload.reports.columns import row
from steadyload.statistics.clusters import Clusters
from steadyload.studies.kit import Asked
from steadyload.studies.reality.record import FIT, Record
from steadyload.studies.reality.releasing import Taken, end_of, is_slow
from steadyload.tuning.proposers import ALGORITHMS
from steadyload.tuning.proposers import VERSION as PROPOSALS
from steadyload.tuning.space import Genotype, Space, space_on

SPACE, ALGORITHM = "motion", "genetic"

SEEDS, POPULATION, GENERATIONS = (0, 1), 8, 6
"""Of each search; the fittest of all is then compared with its neighbours. Of slow engines, see
:func:`steadyload.studies.reality.releasing.is_slow`, there are neighbours alone."""

OFF_CM, TURN_DEG = 2.0, 10.0
"""Errors at which a trial is half as close as it could be: of rest, and of the attitude."""

_WHEEL = 0.1
"""Share of the closeness in what the search is given: the wheel of the proposer is for fitnesses
that lie within a few per cent of each other."""


@row
class Tried:
    """A set of contact parameters, and how close the trials end with it, 0 to 1."""

    parameters: Mapping[str, float]
    closeness: float


@row
class Fitted:
    """The closest set of contact parameters.

    Attributes:
        spec: of a simulation.
        parameters: that were searched.
        least, most: interval of each, of the closest sets in resampled trials.
        closeness: on average over the trials of the half, see :func:`closeness`.
        tried: all sets, the closest first.
        cpu_s: CPU time of the search [s].
    """

    spec: str
    parameters: Mapping[str, float]
    least: Mapping[str, float]
    most: Mapping[str, float]
    closeness: float
    tried: Sequence[Tried]
    cpu_s: float


class FitUnit(
    Asked[Fitted],
    what="fitted contacts",
    version=VERSION,
    proposals=PROPOSALS,
    space=SPACE,
    algorithm=ALGORITHM,
    seeds=SEEDS,
    population=POPULATION,
    generations=GENERATIONS,
    scales=(OFF_CM, TURN_DEG),
):
    """The contacts of an engine, fitted to the half of a record that is for that.

    Attributes:
        genes: names and values that are searched.
        begin_with: values that the search begins with, as far as the space has them.
    """

    record: Record
    seed: int
    engine: str
    genes: Mapping[str, Sequence[float]]
    begin_with: Mapping[str, float]
    taken: Taken
    made_by: Mapping[str, str]

    def describe(self, part: int) -> str:
        """Description for messages."""
        return f"contacts of {self.engine} fitted to record {self.record.digest}"

    def measure(self) -> Fitted:
        """Search them."""
        begun = time.process_time()
        space = space_on(self.engine, SPACE)
        trials = [self.taken.record(trial) for trial in self.record.of(FIT, self.seed)]
        boxes = [self.taken.box(trial, self.taken.release(trial)) for trial in trials]

        def judge(genotype: Genotype) -> list[float]:
            spec = space.spec(genotype)
            found = []
            for trial, box in zip(trials, boxes, strict=True):
                end = end_of(trial, box, spec)
                off, turn = np.inf, np.inf
                if end is not None:
                    off = float(np.linalg.norm(end[0][:2] - trial.positions[-1, :2]))
                    turn = degrees_apart(end[1], trial.attitudes[-1])
                found.append(closeness(off, turn))
            return found

        known = nearest_genotype(space, self.begin_with)
        found = search(space, known, judge, () if is_slow(self.engine) else SEEDS)
        best = max(found, key=lambda genotype: np.mean(found[genotype]))
        least, most = _intervals(space, found)
        tried = sorted(
            (Tried(space.values(g), float(np.mean(own))) for g, own in found.items()),
            key=lambda one: -one.closeness,
        )
        return Fitted(
            space.spec(best), space.values(best), least, most, tried[0].closeness, tried,
            time.process_time() - begun,
        )  # fmt: skip


def closeness(off_m: float, turn_deg: float) -> float:
    """How close an end is to the record, 0 to 1: one half each for position and attitude.

    Bounded, so that trials that end on another face do not decide. Each half is 1 without an error,
    and a half at :data:`OFF_CM` or :data:`TURN_DEG`.
    """
    return 0.5 / (1.0 + 100.0 * off_m / OFF_CM) + 0.5 / (1.0 + turn_deg / TURN_DEG)


def genes_on(engine: str) -> dict[str, tuple[float, ...]]:
    """The parameters that are searched on an engine, with their values."""
    return {gene.name: gene.values for gene in space_on(engine, SPACE).genes}


def nearest_genotype(space: Space, values: Mapping[str, float]) -> Genotype:
    """The start of a space with some genes at the nearest values that they may have."""
    near = {
        gene.name: min(gene.values, key=lambda value: abs(value - values[gene.name]))
        for gene in space.genes
        if gene.name in values
    }
    return space.with_values(space.start, near)


def search(
    space: Space,
    known: Genotype,
    judge: Callable[[Genotype], list[float]],
    seeds: Sequence[int],
) -> dict[Genotype, list[float]]:
    """Closeness of each trial by genotype, of all that a search has tried.

    The seeded searches of :data:`ALGORITHM`, and then the neighbours of the fittest, gene by gene,
    until none is fitter; without seeds these begin at the known genotype.
    """
    found: dict[Genotype, list[float]] = {}

    def fitness(genotype: Genotype) -> float:
        if genotype not in found:
            found[genotype] = judge(genotype)
        return float(np.mean(found[genotype]))

    for seed in seeds:
        proposer = ALGORITHMS[ALGORITHM](space, POPULATION, seed, (known,))
        try:
            for _ in range(GENERATIONS):
                values = [1.0 - _WHEEL * (1.0 - fitness(each)) for each in proposer.ask()]
                proposer.tell([(value, value, 1.0) for value in values])
        finally:
            proposer.close()
    best = max(found or [known], key=fitness)
    while True:
        nearer = max((best, *_neighbours(space, best)), key=fitness)
        if fitness(nearer) <= fitness(best):
            return found
        best = nearer


def _neighbours(space: Space, genotype: Genotype) -> list[Genotype]:
    """Genotypes of which one gene is at the next value up or down."""
    return [
        (*genotype[:k], at + aside, *genotype[k + 1 :])
        for k, (at, gene) in enumerate(zip(genotype, space.genes, strict=True))
        for aside in (-1, 1)
        if 0 <= at + aside < len(gene.values)
    ]


def _intervals(
    space: Space, found: Mapping[Genotype, Sequence[float]]
) -> tuple[dict[str, float], dict[str, float]]:
    """Least and largest values of the closest genotypes in 95 % of resampled trials."""
    genotypes = list(found)
    table = np.array([found[genotype] for genotype in genotypes])
    places = np.concatenate(
        [
            np.array([table[:, k].mean(axis=1).argmax() for k in drawn])
            for drawn in Clusters.of(None, table.shape[1]).resamples()
        ]
    )
    least, most = {}, {}
    for k, gene in enumerate(space.genes):
        values = [gene.values[genotypes[place][k]] for place in places]
        low, high = np.quantile(values, (0.025, 0.975), method="nearest")
        least[gene.name], most[gene.name] = float(low), float(high)
    return least, most
