"""Results on learned methods. Accuracies are shares.

In mappings by scenario the key ``all`` means all cases together.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from steadyload.methods.naming import MethodKey
from steadyload.runs.costs import CostSource
from steadyload.runs.evaluation import ALL, MethodEvaluation
from steadyload.runs.paper import PaperRow
from steadyload.statistics.estimate import Estimate
from steadyload.studies.learned.calibration import MethodCalibration
from steadyload.studies.learned.foreign import Foreign

Batched = Mapping[int, tuple[float, float]]
"""Layouts at once -> CPU and wall time a layout [ms], medians over the repeats."""


@dataclass(frozen=True)
class MethodTable:
    """Learners beside other methods.

    ``rows``: by group, a row a method, compared with the method ``held``. ``paper``: by spec, the
    column of the paper's Table 5 that has the method's name. ``batched``: by spec, cost of methods
    that judge several layouts at once. ``repeats``: of the timing pass; ``cost_source``: of the
    times.
    """

    held: MethodKey
    rows: Mapping[str, tuple[MethodEvaluation, ...]]
    paper: Mapping[str, PaperRow]
    batched: Mapping[str, Batched]
    repeats: int
    cost_source: CostSource

    @property
    def timed(self) -> list[MethodEvaluation]:
        """The methods that were timed, on all cases."""
        return [row for row in self.rows[ALL] if row.cpu.n]

    @property
    def fastest(self) -> dict[str, tuple[int, float, float]]:
        """By spec, the fastest batch size, and its layouts a second of wall and of CPU time.

        The fastest by CPU time, which is disturbed the least by other processes.
        """
        found = {}
        for spec, times in self.batched.items():
            size, (cpu, wall) = min(times.items(), key=lambda pair: pair[1][0])
            found[spec] = size, 1e3 / wall, 1e3 / cpu
        return found


@dataclass(frozen=True, slots=True)
class TrainedRow:
    """Result of the trainings that differ in their seed alone.

    Attributes:
        title: of the training.
        features: the features of the network.
        network: the kind of network.
        symmetries: number of symmetries of the pallet, of 8, that are drawn from; 1 is none.
        labels: source of its labels.
        item_lists, cases: of its training set.
        accuracy: by scenario, mean of the seeds; the interval is that of the cases.
        seeds: by scenario, accuracy of every seed.
        difference: its accuracy minus that of the training that it is compared with, case by
            case; None for that training itself, and where there is none.
    """

    title: str
    features: str
    network: str
    symmetries: int
    labels: str
    item_lists: int
    cases: int
    accuracy: Mapping[str, Estimate]
    seeds: Mapping[str, tuple[float, ...]]
    difference: Mapping[str, Estimate] | None = None


@dataclass(frozen=True, slots=True)
class SizeCurve:
    """Trainings that differ in the size of their training set."""

    title: str
    rows: tuple[TrainedRow, ...]


@dataclass(frozen=True, slots=True)
class LeakRow:
    """A training, and the same one that also saw layouts of held-out item lists."""

    honest: TrainedRow
    leaky: TrainedRow


@dataclass(frozen=True, slots=True)
class ProvenanceRow:
    """Provenance of weights, a number a member where there are several.

    ``validation``: accuracy on that part. ``seconds``: of all epochs. ``item_lists``: None where
    weights do not state it.
    """

    title: str
    seeds: tuple[int, ...]
    command: str
    commit: str
    cases: int
    item_lists: int | None
    epochs: tuple[int, ...]
    best_epochs: tuple[int, ...]
    validation: float
    seconds: float
    digest: str


@dataclass(frozen=True, slots=True)
class Learned:
    """All results on learned methods; sections that were not run are empty.

    ``part``: of the labelled set, on which all are evaluated; ``item_lists``: number of clusters.
    """

    part: str
    cases: int
    item_lists: int
    scenarios: tuple[str, ...]
    table: MethodTable | None = None
    size: tuple[SizeCurve, ...] = ()
    sources: tuple[TrainedRow, ...] = ()
    agreement: Mapping[str, Estimate] | None = None
    remedies: tuple[TrainedRow, ...] = ()
    calibration: tuple[MethodCalibration, ...] = ()
    leak: tuple[LeakRow, ...] = ()
    foreign: Foreign | None = None
    trainings: tuple[ProvenanceRow, ...] = ()
