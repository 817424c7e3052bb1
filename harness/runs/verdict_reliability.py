"""Reliability of a verdict: the probabilities of verdicts when the loading deviates from its plan.

A plan is judged repeatedly, each time with other deviations, until the interval of the probability
that the whole load stands is narrow enough. The numbers behind the deviations are quasi-random and
the same for every method and layout: results of two methods differ because of the methods, not
because of the draw.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike

from steadyload.engines.quantities import check_ranges, quantity
from steadyload.layouts.model.layout import FloatArray, Layout
from steadyload.methods.contract.method import Method, Status, Verdict, judge
from steadyload.methods.draws import sobol
from steadyload.methods.uncertainty import Uncertainty, dimensions, judge_deviated

VERSION = 1
"""Version of deviations, samples and intervals: raised when the same call gives another result."""

REPLICATES = 16
"""Independent scramblings of the points; the spread of their means gives the error of the mean."""

FIRST_LOOK = 64
"""Samples before the interval is first computed; they are doubled before each further time."""

_ERROR = 0.05
"""Probability that the interval misses the true value, over all times it is computed together."""

_MOST_GAIN = 4.0
"""Upper limit of the number of random samples that one sample counts for."""


class Ending(StrEnum):
    """Reason for which sampling ended.

    ``narrow``: the interval is as narrow as required. ``decided``: it lies on one side of the
    required probability. ``spent``: the largest number of samples was reached. ``refused``: the
    method does not judge the plan itself. ``no verdict``: so many samples have no verdict that the
    interval stays wider than required, however many more there are.
    """

    NARROW = "narrow"
    DECIDED = "decided"
    SPENT = "spent"
    REFUSED = "refused"
    NO_VERDICT = "no verdict"


@dataclass(frozen=True)
class Sampling:
    """Rule by which sampling ends.

    Raises:
        ValueError: a number is out of its range.
    """

    half_width: float = quantity(
        0.05, "half the width of the interval that is narrow enough", least=0.001, most=0.5
    )
    decide: float | None = quantity(
        None, "enough is also to know on which side of this probability it lies", least=0, most=1
    )
    most: int = quantity(
        1024, "samples at most, rounded down to 64 times a power of two", least=FIRST_LOOK,
        most=1 << 16,
    )  # fmt: skip
    seed: int = quantity(0, "of the deviations", least=0, most=2**31)

    def __post_init__(self) -> None:
        check_ranges(self)
        for name, kind in (("half_width", float), ("decide", float), ("most", int), ("seed", int)):
            if (value := getattr(self, name)) is not None:  # keys of kept rows hold its repr
                object.__setattr__(self, name, kind(value))

    @property
    def looks(self) -> tuple[int, ...]:
        """Numbers of samples at which the interval is computed."""
        doublings = (self.most // FIRST_LOOK).bit_length()
        return tuple(FIRST_LOOK << k for k in range(doublings))


@dataclass(frozen=True, slots=True)
class VerdictReliability:
    """Verdicts on a layout under deviations, and the probability that the whole load stands.

    Attributes:
        item_count: J, the number of items in the layout.
        nominal: the verdict on the plan itself.
        said: of every sample, items placed safely, J where the whole load stands; None without a
            verdict. Sample k has the same deviations for all methods, layouts and lengths.
        without_verdict: number of samples without one, by status.
        why: the reason that the first sample without a verdict has none; empty where all have one.
        low, high: of the probability that the whole load stands, 95 %; samples without a verdict
            count as falling for the one, as standing for the other.
        ending: the reason for which sampling ended.
        without_effect: uncertain quantities that have no effect on the method.
        cpu, wall: seconds for everything.
    """

    item_count: int
    nominal: Verdict
    said: tuple[int | None, ...]
    without_verdict: Mapping[str, int]
    why: str
    low: float
    high: float
    ending: Ending
    without_effect: tuple[str, ...]
    cpu: float
    wall: float

    @property
    def samples(self) -> int:
        """Number of samples, including those without a verdict."""
        return len(self.said)

    @property
    def shares(self) -> dict[int | None, float]:
        """Probability of each failing step, None for none, in order; of samples with a verdict."""
        counts = Counter(safe for safe in self.said if safe is not None)
        return {
            None if safe == self.item_count else safe: counts[safe] / counts.total()
            for safe in sorted(counts)
        }

    @property
    def stands(self) -> float | None:
        """Probability that the whole load stands; None where no sample has a verdict."""
        return self.shares.get(None, 0.0) if self.shares else None

    @property
    def likeliest(self) -> int | None:
        """The most probable failing step, None for none; the first of equally probable ones.

        Raises:
            ValueError: no sample has a verdict.
        """
        return max(self.shares, key=lambda step: self.shares[step])

    @property
    def expected_score(self) -> float | None:
        """The mean score; None where no sample has a verdict."""
        scores = [safe / self.item_count for safe in self.said if safe is not None]
        return float(np.mean(scores)) if scores else None


def verdict_reliability(
    method: Method,
    layout: Layout,
    uncertainty: Uncertainty,
    sampling: Sampling | None = None,
    *,
    timeout: float | None = None,
) -> VerdictReliability:
    """Sample until the probability that the whole load stands is known precisely enough.

    Args:
        method: any; prepared.
        layout: the plan.
        uncertainty: the quantities that deviate from it.
        sampling: the rule by which sampling ends; None for the defaults.
        timeout: CPU seconds a judgement may take; each sample is one.
    """
    sampling = sampling or Sampling()
    clocks = time.process_time, time.perf_counter
    start = [clock() for clock in clocks]
    nominal = judge(method, layout, timeout)
    verdicts: list[Verdict] = []
    low, high, ending = 0.0, 1.0, Ending.REFUSED
    for last in sampling.looks if nominal.status is not Status.REFUSED else ():
        points = _points(len(verdicts), last, dimensions(len(layout)), sampling.seed)
        verdicts += judge_deviated(method, layout, uncertainty, points, timeout=timeout)
        lost = [v.status is not Status.DONE for v in verdicts]
        error = _ERROR / len(sampling.looks)  # each look may miss, and any may be the last
        low, high = standing_interval([v.stable for v in verdicts], lost, error)
        ending = _ending(low, high, sum(lost) / len(lost), sampling)
        if ending is not Ending.SPENT:
            break
    cpu, wall = (clock() - begun for clock, begun in zip(clocks, start, strict=True))
    statuses = Counter(str(v.status) for v in verdicts if v.status is not Status.DONE)
    return VerdictReliability(
        item_count=len(layout),
        nominal=nominal,
        said=tuple(v.items_placed for v in verdicts),
        without_verdict=dict(statuses),
        why=next((v.reason for v in verdicts if v.status is not Status.DONE), ""),
        low=low,
        high=high,
        ending=ending,
        without_effect=uncertainty.without_effect(method),
        cpu=cpu,
        wall=wall,
    )


def standing_interval(
    stands: ArrayLike, lost: ArrayLike, error: float = _ERROR
) -> tuple[float, float]:
    """An interval of the probability that the whole load stands.

    That of Clopper and Pearson, which holds for random samples however few fall or stand. Where the
    scramblings differ less from one another than random samples would, as many more samples count,
    up to :data:`_MOST_GAIN` times: by the variance of their means, with Student's allowance for
    there being :data:`REPLICATES` of them.

    Args:
        stands: whether the whole load stood, sample by sample, scramblings in turn; as many of
            every one.
        lost: whether there was no verdict.
        error: the probability that it misses.

    Returns:
        Lower and upper end; samples without a verdict count as falling for the one, as standing
        for the other.
    """
    from scipy.special import betaincinv, ndtri, stdtrit

    stood, open_ = np.asarray(stands, dtype=bool), np.asarray(lost, dtype=bool)
    n, least = len(stood), int(stood.sum())
    most = least + int(open_.sum())
    gain = 1.0
    if 0 < least == most < n:
        allowance = float(stdtrit(REPLICATES - 1, error / 2.0) / ndtri(error / 2.0)) ** 2
        share = least / n
        gain = share * (1.0 - share) / n / max(allowance * variance_by_scramblings(stood), 1e-300)
        gain = min(max(gain, 1.0), _MOST_GAIN)
    low = betaincinv(gain * least, gain * (n - least) + 1.0, error / 2.0) if least else 0.0
    high = 1.0
    if most < n:
        high = betaincinv(gain * most + 1.0, gain * (n - most), 1.0 - error / 2.0)
    return float(low), float(high)


def variance_by_scramblings(stands: ArrayLike) -> float:
    """Variance of the mean of all samples, from the differences between the scramblings.

    Args:
        stands: as :func:`standing_interval`.
    """
    means = np.asarray(stands, dtype=float).reshape(-1, REPLICATES).mean(axis=0)
    return float(means.var(ddof=1)) / REPLICATES


def _points(first: int, last: int, coordinates: int, seed: int) -> FloatArray:
    """Rows of samples: the first point of every scrambling, the second of every one, ..."""
    ends = first // REPLICATES, last // REPLICATES
    each = [sobol(*ends, coordinates, seed=seed, replicate=r) for r in range(REPLICATES)]
    return np.stack(each, axis=1).reshape(-1, coordinates)


def _ending(low: float, high: float, lost: float, sampling: Sampling) -> Ending:
    if high - low <= 2.0 * sampling.half_width:
        return Ending.NARROW
    if sampling.decide is not None and not low <= sampling.decide <= high:
        return Ending.DECIDED
    if lost > 2.0 * sampling.half_width:
        return Ending.NO_VERDICT
    return Ending.SPENT
