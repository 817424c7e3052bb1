"""Typed records for the page of learned methods. Accuracies are shares.

In mappings by scenario the key ``all`` means all cases together.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from steadyload.methods.naming import MethodKey
from steadyload.runs.costs import CostSource
from steadyload.runs.evaluation import MethodEvaluation
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.reliability import Abstention, Reliability
from steadyload.studies.table5.paper import PaperRow


@dataclass(frozen=True, slots=True)
class BatchTimes:
    """Cost of a method that may judge several layouts at once.

    ``cpu``, ``wall``: a layout [ms], one at a time, medians over ``repeats`` of the mean over
    ``layouts``. ``batched``: by the number of layouts at once, CPU and wall time a layout [ms],
    medians likewise; empty for a method without batches.
    """

    method: MethodKey
    layouts: int
    repeats: int
    cpu: float
    wall: float
    batched: Mapping[int, tuple[float, float]]


@dataclass(frozen=True, slots=True)
class MethodTable:
    """Learners beside other methods.

    ``rows``: by group, a row a method, compared with the method ``held``. ``paper``: by spec, the
    column of the paper's Table 5 that has the method's name. ``cost_source``: of the times.
    """

    held: MethodKey
    rows: Mapping[str, tuple[MethodEvaluation, ...]]
    paper: Mapping[str, PaperRow]
    times: tuple[BatchTimes, ...]
    cost_source: CostSource


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
class MethodCalibration:
    """Calibration of one method's probabilities, of steps and of a layout's score."""

    title: str
    steps: Reliability
    layouts: Reliability
    abstention: Abstention


@dataclass(frozen=True, slots=True)
class LeakRow:
    """A training, and the same one that also saw layouts of held-out item lists."""

    honest: TrainedRow
    leaky: TrainedRow


@dataclass(frozen=True, slots=True)
class ForeignRow:
    """A learned method on layouts of another kind.

    Attributes:
        method: the method, which refuses layouts outside of its training range.
        refused: share of layouts that it refuses.
        reasons: layouts by the quantity that is outside, with the training range and the range of
            these layouts; a layout may have several.
        agreement: by other method, share of equal failing steps with refusals switched off.
        inside: the same, on the layouts that it does not refuse.
        stable: share of all layouts that it judges to be stable, with refusals switched off.
    """

    method: MethodKey
    refused: Estimate
    reasons: tuple[tuple[str, int, tuple[float, float], tuple[float, float]], ...]
    agreement: Mapping[str, Estimate]
    inside: Mapping[str, Estimate]
    stable: Estimate


@dataclass(frozen=True, slots=True)
class Foreign:
    """Learned methods on layouts of another kind.

    ``others``: share of layouts that other methods judge to be stable. ``among``: by pair of them,
    share of equal failing steps.
    """

    files: int
    layouts: int
    max_items: int
    rows: tuple[ForeignRow, ...]
    others: Mapping[str, Estimate]
    among: Mapping[tuple[str, str], Estimate]


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
