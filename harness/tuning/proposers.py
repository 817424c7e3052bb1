"""Proposers of genotypes: a genetic algorithm, and a multi-objective one."""

from __future__ import annotations

import os
import signal
from collections.abc import Sequence
from multiprocessing.connection import Connection
from typing import ClassVar, Protocol

import numpy as np

from steadyload.runs.worker import start_process
from steadyload.tuning.space import Genotype, Space

VERSION = 1
"""Of what a search proposes: raised when the same search would propose something else."""

_WHEEL = 150
"""The roulette wheel turns on this power of the fitness: fitnesses lie within a few per cent of
each other, and on the first power every genotype would have almost the same chance."""

_MUTATED_GENES = 2
"""Section 5.2 of the paper."""

_ELITE = 2


class Proposer(Protocol):
    """Proposes generations of genotypes and receives their values (ask and tell).

    Proposals are fixed by the seed and by what has been told.

    Attributes:
        needs: the package that does it.
        wants_front: a genotype is worth keeping while none beats it in accuracy and cost; else
            while it may be the fittest.
    """

    needs: ClassVar[str]
    wants_front: ClassVar[bool]

    def ask(self) -> list[Genotype]:
        """The next generation; may hold one genotype twice, or one that was there before."""
        ...

    def tell(self, values: Sequence[tuple[float, float, float]]) -> None:
        """Fitness, accuracy and cost [ms] of every genotype of the generation, in its order."""
        ...

    def close(self) -> None:
        """No further genotypes are proposed."""


def first_generation(
    space: Space, population: int, seed: int, known: Sequence[Genotype] = ()
) -> list[Genotype]:
    """The start of the space, genotypes given beforehand, and random ones."""
    random = np.random.default_rng(seed)
    sizes = [len(gene.values) for gene in space.genes]
    drawn = [tuple(map(int, random.integers(sizes))) for _ in range(population - 1 - len(known))]
    return [space.start, *known, *drawn]


class Genetic(Proposer):
    """The genetic algorithm of the paper's Section 5.2, by PyGAD.

    Roulette-wheel selection, uniform crossover, random mutation of two genes. PyGAD draws from
    global generators and runs in a loop of its own, so it has a process to itself.
    """

    needs = "pygad"
    wants_front = False

    def __init__(
        self, space: Space, population: int, seed: int, known: Sequence[Genotype] = ()
    ) -> None:
        first = first_generation(space, population, seed, known)
        sizes = [len(gene.values) for gene in space.genes]
        self._process, self._line = start_process(_evolve, first, sizes, seed, daemon=True)

    def ask(self) -> list[Genotype]:
        """See :meth:`Proposer.ask`."""
        return self._line.recv()

    def tell(self, values: Sequence[tuple[float, float, float]]) -> None:
        """See :meth:`Proposer.tell`."""
        self._line.send([fitness**_WHEEL for fitness, _, _ in values])

    def close(self) -> None:
        """See :meth:`Proposer.close`."""
        self._line.close()
        self._process.terminate()
        self._process.join()


def _evolve(line: Connection, first: list[Genotype], sizes: list[int], seed: int) -> None:
    """Run PyGAD until the other end of the connection is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    import pygad

    def worth(_: object, genotypes: np.ndarray, __: object) -> list[float]:
        try:
            line.send([tuple(map(int, genotype)) for genotype in genotypes])
            return line.recv()
        except (EOFError, BrokenPipeError, ConnectionResetError):
            os._exit(0)  # PyGAD would print a traceback of any exception

    algorithm = pygad.GA(
        num_generations=1_000_000,
        num_parents_mating=max(2, len(first) // 2),
        fitness_func=worth,
        fitness_batch_size=len(first),
        initial_population=[list(genotype) for genotype in first],
        gene_type=int,
        gene_space=[list(range(size)) for size in sizes],
        parent_selection_type="rws",
        crossover_type="uniform",
        mutation_type="random",
        mutation_num_genes=min(_MUTATED_GENES, len(sizes)),
        keep_elitism=_ELITE,
        random_seed=seed,
        suppress_warnings=True,
    )
    algorithm.run()


class MultiObjective(Proposer):
    """NSGA-II by Optuna: accuracy up, logarithm of the cost down."""

    needs = "optuna"
    wants_front = True

    def __init__(
        self, space: Space, population: int, seed: int, known: Sequence[Genotype] = ()
    ) -> None:
        import optuna

        optuna.logging.set_verbosity(optuna.logging.ERROR)
        self._sizes = {gene.name: len(gene.values) for gene in space.genes}
        self._population = population
        self._study = optuna.create_study(
            directions=["maximize", "minimize"],
            sampler=optuna.samplers.NSGAIISampler(population_size=population, seed=seed),
        )
        for genotype in first_generation(space, population, seed, known):
            self._study.enqueue_trial(dict(zip(self._sizes, genotype, strict=True)))
        self._asked: list[optuna.Trial] = []

    def ask(self) -> list[Genotype]:
        """See :meth:`Proposer.ask`."""
        self._asked = [self._study.ask() for _ in range(self._population)]
        return [
            tuple(trial.suggest_int(name, 0, size - 1) for name, size in self._sizes.items())
            for trial in self._asked
        ]

    def tell(self, values: Sequence[tuple[float, float, float]]) -> None:
        """See :meth:`Proposer.tell`."""
        for trial, (_, accuracy, cost) in zip(self._asked, values, strict=True):
            self._study.tell(trial, (accuracy, float(np.log10(cost))))


ALGORITHMS: dict[str, type[Genetic] | type[MultiObjective]] = {
    "genetic": Genetic,
    "nsga2": MultiObjective,
}
"""By name, as the command takes it."""
