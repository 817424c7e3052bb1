"""One search: generations of genotypes, judged over processes, resumable, remade by its seed."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from steadyload.progress import Progress, silent
from steadyload.runs.pool import run_units
from steadyload.runs.provenance import provenance
from steadyload.runs.store import locked
from steadyload.tuning import TuningError
from steadyload.tuning.cases import fingerprint, load_cases
from steadyload.tuning.cost import GOAL, CostModel, calibrate
from steadyload.tuning.identity import identity, space_of
from steadyload.tuning.ledger import Entry, GenerationEnd, Ledger
from steadyload.tuning.options import SearchOptions
from steadyload.tuning.proposers import ALGORITHMS
from steadyload.tuning.space import Genotype, space_on
from steadyload.tuning.trial import (
    GROWTH,
    WORST_COST,
    FitnessRace,
    FrontRace,
    Race,
    TrialResult,
    TrialUnit,
    estimated,
    fitness,
    run_trial,
    trial_limit,
    trial_without_result,
    without_result,
    worth,
)

CHEAPEST, DEAREST = 0.3, 100.0
"""Costs [ms] between which fronts are compared."""

GOAL_SHARE = 0.185
"""Less than the fifth that a tuned method may cost: the model is off by some per cent."""

Report = Callable[[str], None]


class Search:
    """A search in its folder.

    Args:
        directory: of the search; it goes on where it was.
        options: what is searched.

    Raises:
        TuningError: see :class:`SearchOptions`, :func:`steadyload.tuning.space.space_on`,
            :class:`steadyload.tuning.ledger.Ledger`.
        BenchmarkError: see :func:`steadyload.tuning.cases.load_cases`.
    """

    def __init__(self, directory: Path, options: SearchOptions) -> None:
        self.space = space_on(options.engine, options.space)
        self.known = tuple(self.space.genotype(spec) for spec in options.begin_with)
        # Spelled out: a preset may have changed when the search is resumed.
        spelled = tuple(self.space.spec(genotype) for genotype in self.known)
        self.options = options = dataclasses.replace(options, begin_with=spelled)
        self.cases = load_cases(options.source)
        self._identity = identity(options, self.space)
        self.ledger = Ledger(directory, self._identity)
        self._directory = directory

    @classmethod
    def of(cls, directory: Path) -> Search:
        """The search that a folder holds, to be read: spaces and code may have changed since.

        Raises:
            TuningError: it holds none, or one that has not judged its start yet.
        """
        found, ledger = Ledger.of(directory)
        search = cls.__new__(cls)
        search.ledger, search._directory, search._identity = ledger, directory, found
        search.space = space_of(found)
        if search.space.start not in ledger.entries:
            raise TuningError(f"{directory}: the search has not judged its start yet; let it go on")
        search.options = SearchOptions.restored(found, len(ledger.ends))
        search.cases = load_cases(search.options.source)
        return search

    @property
    def name(self) -> str:
        """Name of its folder."""
        return self._directory.resolve().name

    @property
    def made_by(self) -> Mapping[str, Any]:
        """Versions, source revision and kind of machine at the start of the search."""
        return self.ledger.facts["made_by"]

    @property
    def goal(self) -> float:
        """The cost [ms a layout] that counts as fast."""
        return self.ledger.facts["goal"]

    @cached_property
    def model(self) -> CostModel:
        """Cost model of the engine."""
        return CostModel(**self.ledger.facts["model"])

    def run(
        self,
        *,
        workers: int,
        progress: Progress = silent,
        report: Report = lambda sentence: None,
    ) -> Entry:
        """Search until the generations or the budget are used up; returns the fittest genotype.

        Args:
            workers: processes beside this one; 0 judges in this process.
            progress: called with seconds or generations, spent and in all.
            report: told a sentence after every generation.

        Raises:
            TuningError: the algorithm needs a package that is not there; or the search was begun
                with another model of cost or other labels, or its generations would be others now.
            ResultsError: another search is at work in the folder.
            WorkerDiedError: see :func:`steadyload.runs.pool.run_units`.
        """
        needs = ALGORITHMS[self.options.algorithm].needs
        if find_spec(needs) is None:
            raise TuningError(
                f"algorithm {self.options.algorithm!r} needs the package {needs}: pip install "
                "'steadyload[tuning]'"
            )
        with locked(self._directory):
            # Another run may have been at work until now.
            self.ledger = Ledger(self._directory, self._identity)
            self._prepare(workers, report)
            options = self.options
            proposer = ALGORITHMS[options.algorithm](
                self.space, options.population, options.seed, self.known
            )
            try:
                number = 0
                while not self._finished(number):
                    proposed = proposer.ask()
                    if number == len(self.ledger.ends):
                        self._generation(number, proposed, workers)
                    self._check_judged(proposed, number)
                    proposer.tell(self._worth(proposed, number))
                    number += 1
                    self._tell(number, progress, report)
            finally:
                proposer.close()
        return self.fittest()

    def fittest(self, before: int | None = None) -> Entry:
        """The fittest genotype that was judged on all cases; the first of equals.

        Args:
            before: only from generations with smaller numbers; the start always counts. None for
                all finished generations.
        """
        return max(self.whole(before), key=lambda entry: fitness(entry.trial, self.goal))

    def judged(self, before: int | None = None) -> list[Entry]:
        """All genotypes of finished generations, in an order that any run of the search has.

        The order in which they were judged is another one with every number of workers.

        Args:
            before: see :meth:`fittest`; None for all finished generations.
        """
        end = len(self.ledger.ends) if before is None else before
        found = [entry for entry in self.ledger.entries.values() if entry.generation < end]
        return sorted(found, key=lambda entry: (entry.generation, entry.genotype))

    def whole(self, before: int | None = None) -> list[Entry]:
        """Those of :meth:`judged` that were judged on all cases."""
        return [e for e in self.judged(before) if len(e.trial) == len(self.cases)]

    def front(self, before: int | None = None) -> list[Entry]:
        """Genotypes judged on all cases that no other is as accurate as at a lower cost."""
        return pareto_front(self.whole(before))

    def _prepare(self, workers: int, report: Report) -> None:
        """Measure the cost model, the cost of PS_3, and the values of the start."""
        options, facts = self.options, self.ledger.facts
        if "made_by" not in facts:
            made_by, package = provenance(), ALGORITHMS[options.algorithm].needs
            made_by["versions"][package] = metadata.version(package)
            self.ledger.state("made_by", made_by)
        found = fingerprint(self.cases)
        if "cases" not in facts:
            self.ledger.state("cases", found)
        elif facts["cases"] != found:
            raise TuningError(
                f"{self._directory}: the labelled set has changed since the search was begun; "
                "choose another folder, or remove it"
            )
        if "model" not in facts:
            model = options.model
            if model is None:
                report("measuring what judging costs")
                model = calibrate(
                    self.space, options.source, workers=workers, with_goal=options.goal is None
                )
            self.ledger.state("model", dataclasses.asdict(model))
        elif options.model is not None and options.model.microseconds != self.model.microseconds:
            raise TuningError(
                f"{self._directory}: holds a search with another model of cost; choose another "
                "folder, or remove it"
            )
        if "goal" not in facts and options.goal is not None:
            self.ledger.state("goal", options.goal)
        elif "goal" not in facts:
            spec = GOAL.format(engine=options.engine)
            trial = self._judge({spec: spec}, FrontRace(), workers)[spec]
            self.ledger.state("goal", round(GOAL_SHARE * trial.mean_cost, 4))
        start = self.space.start
        if start not in self.ledger.entries:
            trial = self._judge({start: self.space.spec(start)}, FrontRace(), workers)[start]
            if len(trial) < len(self.cases):
                raise TuningError(f"the start of the space cannot be judged: {trial.reason}")
            self.ledger.add(Entry(start, -1, trial))

    def _finished(self, number: int) -> bool:
        generations, budget = self.options.generations, self.options.budget
        if generations is not None and number >= generations:
            return True
        known = number < len(self.ledger.ends)
        return budget is not None and not known and number > 0 and self.wall >= budget

    @property
    def wall(self) -> float:
        """Seconds spent on finished generations."""
        return sum(end.wall for end in self.ledger.ends)

    def _generation(self, number: int, proposed: list[Genotype], workers: int) -> None:
        started = time.perf_counter()
        missing = {
            genotype: spec
            for genotype in dict.fromkeys(proposed)
            if genotype not in self.ledger.entries and (spec := self._spec(genotype, number))
        }
        self._judge(missing, self._race(number), workers, number)
        self._check_code()
        values = [fit for fit, _, _ in self._worth(proposed, number)]
        wall = round(time.perf_counter() - started, 3)
        self.ledger.end(GenerationEnd(number, len(proposed), float(np.median(values)), wall))

    def _check_code(self) -> None:
        """Workers read the code anew; it must be the code with which the search began."""
        if identity(self.options, self.space) != self._identity:
            raise TuningError(
                f"{self._directory}: code was changed while the search was running; put it back to "
                "what it was, or search in another folder"
            )

    def _check_judged(self, proposed: list[Genotype], number: int) -> None:
        """A finished generation that is proposed again must be the same."""
        if any(genotype not in self.ledger.entries for genotype in proposed):
            package = ALGORITHMS[self.options.algorithm].needs
            version = self.made_by["versions"][package]
            raise TuningError(
                f"{self._directory}: generation {number} would be another one now; the search was "
                f"begun with {package} {version}, go on with that or search in another folder"
            )

    def _spec(self, genotype: Genotype, number: int) -> str | None:
        """A genotype's spec; what cannot be a method is put down as judged, for nothing."""
        try:
            return self.space.spec(genotype)
        except ValueError as error:
            self.ledger.add(Entry(genotype, number, without_result(str(error))))
            return None

    def _race(self, number: int) -> Race:
        """Race for the genotypes of a generation, against rivals of earlier generations only."""
        if ALGORITHMS[self.options.algorithm].wants_front:
            return FrontRace(tuple(entry.trial for entry in self.front(number)))
        return FitnessRace(self.goal, self.fittest(number).trial)

    def _judge(
        self, specs: Mapping[Any, str], race: Race, workers: int, number: int | None = None
    ) -> dict[Any, TrialResult]:
        """Judge specs; those of a generation are stored as soon as they are judged."""
        source, model = self.options.source, self.model
        keys = {spec: key for key, spec in specs.items()}
        units = [TrialUnit(spec, source, model, race) for spec in keys]
        found: dict[Any, TrialResult] = {}
        for unit, [trial] in run_units(
            run_trial,
            units,
            workers=workers,
            crashed=trial_without_result,
            limit=trial_limit(len(self.cases)),
        ):
            found[keys[unit.spec]] = trial
            if number is not None:
                self.ledger.add(Entry(keys[unit.spec], number, trial))
        return found

    def _worth(self, proposed: list[Genotype], number: int) -> list[tuple[float, float, float]]:
        """Fitness, accuracy and cost of genotypes, for the proposer.

        What was given up is told to be behind the fittest, or one of the front that costs no more,
        by what it was on the cases that it was judged on and what that usually grows by.
        """
        race, fittest = self._race(number), self.fittest(number).trial
        found = []
        for genotype in proposed:
            trial = self.ledger.entries[genotype].trial
            if not len(trial):
                found.append((0.0, 0.0, WORST_COST))
            elif len(trial) == len(self.cases):
                found.append(worth(trial, self.goal))
            else:
                rival = race.ahead(trial) or fittest
                found.append(estimated(trial, rival, self.goal, GROWTH[len(trial)]))
        return found

    def _tell(self, number: int, progress: Progress, report: Report) -> None:
        options = self.options
        if options.generations is not None:
            progress(number, options.generations)
        else:
            progress(int(self.wall), int(options.budget or 0))
        best = self.fittest(number).trial
        report(
            f"generation {number - 1}: fitness {fitness(best, self.goal):.4f}, accuracy "
            f"{100 * best.accuracy:.2f} %, {best.mean_cost:.2f} ms; "
            f"{len(self.ledger.entries)} genotypes, {self.wall:.0f} s"
        )


def pareto_front(entries: list[Entry]) -> list[Entry]:
    """Those that no other is as accurate as at a lower cost, by rising cost."""
    front: list[Entry] = []
    for entry in sorted(entries, key=lambda e: (e.trial.mean_cost, -e.trial.accuracy)):
        if not front or entry.trial.accuracy > front[-1].trial.accuracy:
            front.append(entry)
    return front


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
