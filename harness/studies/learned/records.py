"""What a page shows of learned judges, as small typed records. Accuracies are shares.

Where something is told by scenario, the key ``all`` stands for all cases together.
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
    """What a method costs that may judge several layouts at once.

    ``cpu``, ``wall``: a layout [ms], one at a time, medians over ``repeats`` of the mean over
    ``layouts``. ``batched``: by the number of layouts at once, CPU and wall time a layout [ms],
    medians likewise; empty where a method knows no batches.
    """

    method: MethodKey
    layouts: int
    repeats: int
    cpu: float
    wall: float
    batched: Mapping[int, tuple[float, float]]


@dataclass(frozen=True, slots=True)
class JudgeTable:
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
    """What trainings that differ in their seed alone came to.

    Attributes:
        title: of the training.
        features: what the network is told.
        network: which one.
        symmetries: of 8, how many are drawn from; 1 is none.
        labels: where its labels come from.
        item_lists, cases: of its training set.
        accuracy: by scenario, mean of the seeds; the interval is that of the cases.
        seeds: by scenario, accuracy of every seed.
        difference: its accuracy minus that of the training that it is held against, case by case;
            None for that training itself, and where there is none.
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
class JudgeCalibration:
    """One judge's probabilities: of steps, and how sure it is of a layout's score."""

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
    """A learned judge on layouts of another kind.

    Attributes:
        method: the judge, which refuses what is outside of what it was trained on.
        refused: share that it refuses.
        reasons: layouts by the quantity that is outside, with the ends it was trained on and those
            of these layouts; a layout may have several.
        agreement: by other method, share of equal failing steps where it is made to judge all.
        inside: the same, on what it does not refuse.
        stable: share of all that it says are stable, made to judge all.
    """

    method: MethodKey
    refused: Estimate
    reasons: tuple[tuple[str, int, tuple[float, float], tuple[float, float]], ...]
    agreement: Mapping[str, Estimate]
    inside: Mapping[str, Estimate]
    stable: Estimate


@dataclass(frozen=True, slots=True)
class Foreign:
    """Learned judges on layouts of another kind.

    ``others``: share that other methods say are stable. ``among``: by pair, share of equal failing
    steps of two of them.
    """

    files: int
    layouts: int
    max_items: int
    rows: tuple[ForeignRow, ...]
    others: Mapping[str, Estimate]
    among: Mapping[tuple[str, str], Estimate]


@dataclass(frozen=True, slots=True)
class ProvenanceRow:
    """Where weights come from, a number a member where there are several.

    ``validation``: accuracy there. ``seconds``: of all epochs. ``item_lists``: None where weights
    do not say it.
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
    """All that is known of learned judges; sections that were not run are empty.

    ``part``: of the labelled set, on which all are judged; ``item_lists`` intervals stand on.
    """

    part: str
    cases: int
    item_lists: int
    scenarios: tuple[str, ...]
    table: JudgeTable | None = None
    size: tuple[SizeCurve, ...] = ()
    sources: tuple[TrainedRow, ...] = ()
    agreement: Mapping[str, Estimate] | None = None
    remedies: tuple[TrainedRow, ...] = ()
    calibration: tuple[JudgeCalibration, ...] = ()
    leak: tuple[LeakRow, ...] = ()
    foreign: Foreign | None = None
    trainings: tuple[ProvenanceRow, ...] = ()
