"""Options of searches, checked before a search begins."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from steadyload.config import stated
from steadyload.engines.registry import engines
from steadyload.errors import nearest
from steadyload.layouts.benchmark.parts import Part
from steadyload.tuning import TuningError
from steadyload.tuning.cases import CaseSource, own_part, set_for
from steadyload.tuning.cost import CostModel
from steadyload.tuning.proposers import ALGORITHMS
from steadyload.tuning.space import DEFAULT, question_of

_STORED = ("engine", "algorithm", "space", "seed", "population")
"""Options that are stored as they are."""


@dataclass(frozen=True, slots=True)
class SearchOptions:
    """Options of a search: engine, algorithm, space and budget.

    Attributes:
        engine: registered name.
        algorithm: of :data:`steadyload.tuning.proposers.ALGORITHMS`.
        space: of :func:`steadyload.tuning.space.space_names`.
        seed: of every random draw.
        population: genotypes a generation, 4 or more.
        generations: how many; None for as many as the budget allows.
        budget: wall seconds, over all starts of the search; no generation is begun beyond it. None
            for no limit.
        begin_with: specs of simulations on the engine that the first generation holds, beside the
            start of the space and random genotypes.
        source: the cases.
        model: what judging costs; None measures it first.
        goal: cost [ms a layout] that counts as fast, above 0; None for a share of that of PS_3, see
            :data:`steadyload.tuning.search.GOAL_SHARE`.

    Raises:
        TuningError: neither generations nor a budget, or a value that is not allowed; more to begin
            with than a generation holds.
    """

    engine: str
    algorithm: str = "genetic"
    space: str = DEFAULT
    seed: int = 0
    population: int = 60
    generations: int | None = None
    budget: float | None = None
    begin_with: tuple[str, ...] = ()
    source: CaseSource = field(default_factory=CaseSource)
    model: CostModel | None = None
    goal: float | None = None

    def __post_init__(self) -> None:
        if self.algorithm not in ALGORITHMS:
            raise TuningError(
                f"unknown algorithm {self.algorithm!r}; {nearest(self.algorithm, ALGORITHMS)}"
            )
        if self.population < 4:
            raise TuningError(f"population is {self.population}; allowed: 4 or more")
        if len(self.begin_with) >= self.population:
            raise TuningError(
                f"{len(self.begin_with)} parameter sets to begin with; allowed: fewer than the "
                f"population, {self.population}"
            )
        if self.goal is not None and not self.goal > 0.0:
            raise TuningError(f"goal is {self.goal:g}; allowed: more than 0 [ms a layout]")
        if self.generations is None and self.budget is None:
            raise TuningError("a search needs a number of generations or a budget")

    def stored(self) -> dict[str, Any]:
        """The options that a search and a preset keep; the goal only where one is stated."""
        return {
            **{name: getattr(self, name) for name in _STORED},
            "begin_with": list(self.begin_with),
            "source": self.source.stored(),
            **stated(goal=self.goal),
        }

    @classmethod
    def restored(
        cls, stored: Mapping[str, Any], generations: int, model: CostModel | None = None
    ) -> SearchOptions:
        """The options of :meth:`stored`, of so many generations."""
        return cls(
            **{name: stored[name] for name in _STORED},
            begin_with=tuple(stored["begin_with"]),
            source=CaseSource(**stored["source"]),
            goal=stored.get("goal"),
            generations=generations,
            model=model,
        )

    @classmethod
    def on(
        cls,
        engine: str,
        *,
        benchmark: str | None = None,
        data: tuple[str, ...] = (),
        limit: int | None = None,
        **others: Any,
    ) -> SearchOptions:
        """Options with the labelled set that suits an engine, unless one is named, and the labels
        of the question that the space is for.

        Args:
            engine: registered name.
            benchmark: a labelled set.
            data: further ones; see :class:`steadyload.tuning.cases.CaseSource`, as is the next.
            limit: cases a scenario of every set.
            others: as of this class.

        Raises:
            TuningError: see :class:`SearchOptions`, and of :mod:`steadyload.tuning.cases`
                :func:`set_for` and :func:`own_part`; no such engine.
            BenchmarkError: no such labelled set.
        """
        if engine not in engines():
            raise TuningError(f"unknown engine {engine!r}; {nearest(engine, engines())}")
        directory = set_for(engine, benchmark, data)
        question = question_of(others.get("space", DEFAULT))
        part = own_part(directory, Part.SEARCH)
        return cls(engine, source=CaseSource(part, directory, limit, question, data), **others)
