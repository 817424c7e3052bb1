"""The section of the page of speed on growth with the number of items."""

from __future__ import annotations

import math
from collections.abc import Sequence

from steadyload.methods.naming import method_key
from steadyload.methods.registry import make_method
from steadyload.reports.pages.page import Picture, Section
from steadyload.reports.table import Column, Table, decimal, milliseconds, words
from steadyload.studies.speed.figures import plot_growth
from steadyload.studies.speed.growth import LATE
from steadyload.studies.speed.records import GrowthCurve, GrowthPoint, SpeedRun
from steadyload.studies.speed.scenes import PILES

AIM = 1.3
"""Exponent of growth that is aimed at."""


def title(spec: str) -> str:
    """Name of a method in tables."""
    return method_key(make_method(spec)).title


def growth_sections(run: SpeedRun) -> list[Section]:
    """The section with the figure and its tables; none where nothing was measured."""
    curves = [curve for curve in run.growth if curve.points]
    if not curves:
        return []
    most = max(point.items for curve in curves for point in curve.points)
    columns = [
        words("layouts", "scene"),
        words("method", lambda curve: title(curve.method)),
        Column("n", lambda curve: curve.exponent.n or None),
        Column("judge: exponent", lambda curve: decimal(curve.exponent)),
        Column(f"from {LATE} items on", lambda curve: decimal(curve.late)),
        Column("in a batch: exponent", lambda curve: decimal(curve.batch)),
    ]
    points = [
        words("layouts", lambda row: row[0].scene),
        words("method", lambda row: title(row[0].method)),
        Column("J", lambda row: row[1].items),
        Column("n (joined)", lambda row: _counted(row[1])),
        Column("judge, us", lambda row: milliseconds(row[1].microseconds)),
        Column("in a batch, us", lambda row: milliseconds(row[1].batch)),
    ]
    each = [(curve, point) for curve in curves for point in curve.points]
    return [
        Section(
            f"Growth to {most} items",
            _growth_explained(curves, run),
            [Table(curves, columns), Table(each, points)],
            [
                Picture(
                    "growth",
                    plot_growth(curves).figure,
                    "CPU time of a judgement against the number of items; the exponent stands in "
                    "the legend.",
                )
            ],
        )
    ]


def _growth_explained(curves: Sequence[GrowthCurve], run: SpeedRun) -> str:
    files = sorted({curve.scene for curve in curves} - {PILES})
    told = (
        f"The first J items of layouts that the method calls stable up to there, so that all are "
        f"judged; a method has no point where it calls none stable. *{PILES}*: random boxes packed "
        "from the bottom up on 80 x 80 cm, 0.8 of every base supported. "
    )
    if files:
        told += (
            f"*{', '.join(files)}*: layouts of the file in random order, of each the first items "
            "that the method calls safe, ten at least; beyond their number those of the next ones "
            "stand beside them on one long deck (*joined*: so many of the n). "
        )
    how = (
        "The exponent is that of J in the CPU time, by least squares in log-log over all "
        "layouts; brackets hold 95 % intervals, clustered by layout. `judge` includes a verdict "
        "with its times, which does not grow; a batch of equal layouts has none of its own. "
        f"A judgement beyond {run.patience:g} s is given up."
    )
    return _aim(curves) + told + how


def _counted(point: GrowthPoint) -> str:
    joined = f" ({point.joined})" if point.joined else ""
    return f"{point.microseconds.n}{joined}"


def _aim(curves: Sequence[GrowthCurve]) -> str:
    """Sentence on the exponent that is aimed at: which methods are above it, on which layouts."""
    above = [
        f"{title(curve.method)} on {curve.scene} ({decimal(found)})"
        for curve in curves
        for found in (curve.exponent if math.isnan(curve.batch.value) else curve.batch,)
        if found.value > AIM
    ]
    return f"The aim is an exponent of {AIM} at most; above it: {', '.join(above) or 'none'}. "
