"""The frame of verdicts of the study: costs, and by size and origin where pallets are real."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.layouts.benchmark import Benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.benchmark.parts import PALLET_SOFTWARE
from steadyload.layouts.sizes import FEWER, FINE_SIZES, SIZES, binned
from steadyload.runs import frames as v
from steadyload.runs.costs import limited_costs, timed_costs
from steadyload.runs.judged import JudgedCases
from steadyload.studies.evaluation.judging import Options, Ran

YARDSTICK, UNIT = "ps3@mujoco", "sme"
"""The methods whose CPU times others are shares and multiples of."""

SMALL_SIZES = (3, 5, 6, 7, 10, 15, 19, 20)
"""Largest numbers of boxes of bins. The paper cuts layouts to 20, so that many have exactly 20."""

BRIEF, LONG = 300.0, 1000.0
"""CPU times within which tables say how many cases are judged [ms]."""

CUSTOMERS, PACKERS = "customers' pallets", "plans of packers"


def costed(judged: JudgedCases, ran: Ran, asked: Options) -> pd.DataFrame:
    """Verdicts with CPU and wall times [ms]: of the timing pass, or of judging with a time limit.

    Returns:
        As :func:`steadyload.runs.frames.verdicts`, and ``cpu``, ``wall``: missing where a case was
        not timed, or was refused; an abandoned judgement costs the limit at least. ``yardstick``,
        ``unit``: CPU time of these methods on the case. ``brief``, ``long``: whether it is judged
        within :data:`BRIEF`, :data:`LONG`.
    """
    if ran.timed is None:
        assert asked.timeout is not None, "without a time limit there is a timing pass"
        costs = limited_costs(judged.results, asked.timeout)
    else:
        costs = timed_costs(ran.timed.times, pd.MultiIndex.from_tuples(ran.timed.cases, names=KEYS))
    frame = v.costed(judged, costs)
    return frame.assign(
        yardstick=v.beside(frame, "cpu", YARDSTICK), unit=v.beside(frame, "cpu", UNIT),
        brief=frame["cpu"] <= BRIEF, long=frame["cpu"] <= LONG,
    )  # fmt: skip


def binned_by_boxes(frame: pd.DataFrame, *, real: bool) -> pd.DataFrame:
    """Rows by rising number of boxes, with the name of their bins, ``boxes``: those of pallets of
    real size by their ends, those of the paper's sizes by the least and greatest number in them.
    """
    sizes: Sequence[int] = (SMALL_SIZES[-1], FEWER, *FINE_SIZES) if real else SMALL_SIZES
    found = _binned(frame, sizes, "boxes")
    if not real:
        ends = found.groupby("boxes", sort=False)["items"]
        low, high = ends.transform("min").astype(str), ends.transform("max").astype(str)
        found["boxes"] = low.where(low == high, low + " to " + high)
    return found


def with_spans(frame: pd.DataFrame) -> pd.DataFrame:
    """Rows by the sizes that the page answers for: ``span``, the name of the bin."""
    return _binned(frame, (FEWER, *SIZES), "span")


def _binned(frame: pd.DataFrame, sizes: Sequence[int], name: str) -> pd.DataFrame:
    """Rows by rising bin of the number of boxes, with the name of the bin in a column."""
    place, names = binned(frame["items"], sizes)
    found = frame.assign(**{name: [names[one] for one in place.tolist()]})
    return found.iloc[np.argsort(place, kind="stable")]


def of_customers(layouts: pd.Series, benchmark: Benchmark) -> NDArray[np.bool_]:
    """Mask of the customers' pallets, as palletising software planned them, among layouts."""
    sources = benchmark.layouts["sources"].reindex(layouts)
    return np.array([found is not None and PALLET_SOFTWARE in list(found) for found in sources])


def with_origins(frame: pd.DataFrame, benchmark: Benchmark) -> pd.DataFrame:
    """Rows by whose plan the case is: ``origin``; None in all where no customer planned one."""
    theirs = of_customers(frame["layout"], benchmark)
    names = np.where(theirs, CUSTOMERS, PACKERS) if theirs.any() else np.full(len(frame), None)
    return frame.assign(origin=names)
