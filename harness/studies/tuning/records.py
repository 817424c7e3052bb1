"""What a page shows of tuning, as small typed records. Accuracies are shares, costs are in ms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from steadyload.runs.costs import CostSource
from steadyload.runs.evaluation import MethodEvaluation
from steadyload.statistics.estimate import Estimate


@dataclass(frozen=True, slots=True)
class GeneRow:
    """One parameter that is searched.

    ``values``: what it may be, as text (a range with its step, or a list). ``start``: its value in
    the genotype that a search begins with. ``found``: in the one it ended with.
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
    fitness of this generation. ``judged``: genotypes judged so far, by whole or in part.
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
        engine, algorithm, space, seed: what searched where.
        population, generations: size, and how many were finished.
        known: genotypes of the first generation that were found before the search.
        genotypes: different ones that were judged; ``whole`` on all cases, the others were given
            up; ``repeats`` came up again and were not judged again.
        cpu, wall: seconds spent.
        start, found: fitness, accuracy and cost of the genotype a search begins with and of the
            best one.
        hypervolume: area between the front and the corner of no accuracy at the highest cost
            shown, over log10 of the cost; 1 is all of it.
        history, judged: see there.
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
    """How an engine's CPU time is modelled by what a simulation does.

    ``terms``: microseconds by what is counted. ``correlation``: Spearman's, between modelled and
    measured, over ``parameter_sets``. ``error``: median of the relative error.
    """

    engine: str
    terms: Mapping[str, float]
    parameter_sets: int
    correlation: float
    error: float


@dataclass(frozen=True, slots=True)
class TunedTable:
    """A tuned method and others on one engine, on cases it was not tuned on.

    ``tuned`` and ``others`` were judged in the same run; each of the others is compared with the
    tuned one: how far that is ahead, and its CPU time over theirs.
    """

    engine: str
    part: str
    tuned: MethodEvaluation
    others: tuple[MethodEvaluation, ...]


@dataclass(frozen=True, slots=True)
class Variant:
    """The tuned parameters with some of them changed.

    ``change``: what was changed, ``values``: to what. ``accuracy_change`` and ``cost_change``
    (a factor) are against the tuned ones, on the same cases.
    """

    change: str
    values: str
    found: MethodEvaluation
    accuracy_change: Estimate
    cost_change: float


@dataclass(frozen=True, slots=True)
class VariantTable:
    """Variants of what was tuned on one engine, on one part of the labelled set."""

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
    """All pairs of engines on the same cases. ``ignored``: by pair (tuned on, judged on), what the
    second engine has no such setting for.
    """

    part: str
    engines: tuple[str, ...]
    cells: tuple[TransferCell, ...]
    ignored: Mapping[tuple[str, str], tuple[str, ...]]


@dataclass(frozen=True, slots=True)
class PricePoint:
    """What a budget buys: the most accurate of the parameter sets seen whose cost is below it.

    ``budget``: ms a layout. ``validation``: accuracy where it was chosen. ``test``: on other cases,
    with the CPU time measured there; None where nothing is that cheap.
    """

    engine: str
    budget: float
    values: str
    validation: float
    test: MethodEvaluation | None


@dataclass(frozen=True, slots=True)
class SeedRow:
    """What one seed found: on validation, and once on test."""

    engine: str
    seed: int
    fitness: float
    validation: float
    test: MethodEvaluation
    values: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Tuning:
    """All that is known of tuning. Parts that were not computed are empty.

    ``goal``: by engine, the cost [ms] up to which being cheaper is worth nothing: 18.5 % of that
    of PS_3. ``parameters``: by engine, what was found, in the order of the space. ``cost_source``:
    of measured CPU times; None where nothing was tested.
    """

    part: str
    cases: int
    goal: Mapping[str, float]
    costs: tuple[CostRow, ...] = ()
    searches: tuple[SearchRow, ...] = ()
    parameters: Mapping[str, tuple[GeneRow, ...]] | None = None
    tests: tuple[TunedTable, ...] = ()
    seeds: tuple[SeedRow, ...] = ()
    left_out: tuple[VariantTable, ...] = ()
    plausibility: tuple[VariantTable, ...] = ()
    transfer: tuple[TransferTable, ...] = ()
    prices: tuple[PricePoint, ...] = ()
    cost_source: CostSource | None = None
