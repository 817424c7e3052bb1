"""Rows on the calibration of probabilities, and on what not judging unsure cases gives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from steadyload.reports.columns import (
    column,
    factor,
    general,
    percent,
    plain_percent,
    row,
    significant,
)
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.reliability import Abstention, Reliability


@row
class Bin:
    """Probabilities of a judge within a range, and how often what they are of happened."""

    judge: str = column()
    kind: str = column("probability that")
    low: float = column("from", general)
    high: float = column("to", general)
    mean: float = column("mean probability %", plain_percent)
    happened: Estimate = column("happened %", percent)


@row
class Calibrated:
    """Calibration of a kind of probability that a judge gives."""

    judge: str = column()
    kind: str = column("probability that")
    brier: Estimate = column("Brier", factor)
    error: Estimate = column("expected calibration error", factor)
    bins: Sequence[Bin]


class Risk(NamedTuple):
    """Share of cases that are judged, the surest first, and the share of these that are wrong."""

    covered: float
    wrong: float


@row
class Abstaining:
    """Accuracy of a judge with and without the tenth of the cases that it is least sure of."""

    judge: str = column()
    least: float = column("judges when as sure as", significant)
    every: Estimate = column("all %", percent)
    sure: Estimate = column("the surer nine tenths %", percent)
    unsure: Estimate = column("the unsure tenth %", percent)
    curve: Sequence[Risk]


def calibrated(judge: str, kind: str, found: Reliability) -> Calibrated:
    """The row of a calibration."""
    bins = [
        # Beyond these digits a network differs by the processor that it runs on.
        Bin(judge, kind, one.low, one.high, round(one.mean, 4), one.happened)
        for one in found.bins
    ]
    return Calibrated(judge, kind, found.brier, found.error, bins)


def abstaining(judge: str, found: Abstention) -> Abstaining:
    """The row of an abstention."""
    curve = [Risk(*point) for point in found.curve]
    return Abstaining(judge, found.least, found.every, found.sure, found.unsure, curve)
