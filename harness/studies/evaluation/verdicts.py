"""The frame of verdicts of the study: costs, and by size and origin where pallets are real."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.layouts.benchmark import Benchmark
from steadyload.layouts.benchmark.real import PALLET_SOFTWARE
from steadyload.layouts.sizes import FEWER, FINE_SIZES, SIZES, binned
from steadyload.methods.contract.method import Status
from steadyload.runs import frames as v
from steadyload.runs.judged import JudgedCases
from steadyload.studies.evaluation.judging import Options, Ran

YARDSTICK, UNIT = "ps3@mujoco", "sme"
"""The methods whose CPU times others are shares and multiples of."""

SMALL_SIZES = (3, 5, 6, 7, 10, 15, 19, 20)
"""Largest numbers of boxes of bins. The paper cuts layouts to 20, so that many have exactly 20."""

BRIEF, LONG = 300.0, 1000.0
"""CPU times within which tables say how many cases are judged [ms]."""

CUSTOMERS, PACKERS = "customers' pallets", "plans of packers"

_WITHOUT_COST = [str(s) for s in (Status.REFUSED, Status.CRASHED, Status.ERROR)]


def costed(judged: JudgedCases, ran: Ran, asked: Options) -> pd.DataFrame:
    """Verdicts with CPU and wall times [ms]: of the timing pass, or of judging with a time limit.

    Returns:
        As :func:`steadyload.runs.frames.verdicts`, and ``cpu``, ``wall``: missing where a case was
        not timed, or was refused; an abandoned judgement costs the limit at least. ``yardstick``,
        ``unit``: CPU time of these methods on the case. ``brief``, ``long``: whether it is judged
        within :data:`BRIEF`, :data:`LONG`.
    """
    frame = v.verdicts(judged)
    if ran.timed is None:
        assert asked.timeout is not None, "without a time limit there is a timing pass"
        late = frame["status"] == str(Status.TIMEOUT)
        none = frame["status"].isin(_WITHOUT_COST)
        for name in ("cpu", "wall"):
            taken = 1e3 * frame[f"{name}_total"]
            frame[name] = taken.mask(late, taken.clip(lower=1e3 * asked.timeout)).mask(none)
    else:
        cases = pd.MultiIndex.from_tuples(ran.timed.cases, names=v.CASE)
        for name, clock in (("cpu", ran.timed.times.cpu), ("wall", ran.timed.times.wall)):
            wide = pd.DataFrame({m: np.median(t, axis=0) for m, t in clock.items()}, cases)
            long = wide.reset_index().melt(v.CASE, var_name="method", value_name=name)
            frame = frame.merge(long, "left", [*v.CASE, "method"])
    return frame.assign(
        yardstick=v.beside(frame, "cpu", YARDSTICK), unit=v.beside(frame, "cpu", UNIT),
        brief=frame["cpu"] <= BRIEF, long=frame["cpu"] <= LONG,
    )  # fmt: skip


def binned_by_boxes(frame: pd.DataFrame, *, real: bool) -> pd.DataFrame:
    """Rows by rising number of boxes, with the place (``bin``) and name (``boxes``) of their bins.

    Args:
        frame: of verdicts.
        real: whether bins are those of pallets of real size, named by their ends; else those of the
            paper's sizes, named by the smallest and the largest number in them.
    """
    sizes: Sequence[int] = (SMALL_SIZES[-1], FEWER, *FINE_SIZES) if real else SMALL_SIZES
    place, names = binned(frame["items"], sizes)
    found = frame.assign(bin=place, boxes=[names[one] for one in place.tolist()])
    if not real:
        ends = found.groupby("bin")["items"]
        low, high = ends.transform("min").astype(str), ends.transform("max").astype(str)
        found["boxes"] = low.where(low == high, low + " to " + high)
    return found.sort_values("bin", kind="stable")


def with_spans(frame: pd.DataFrame) -> pd.DataFrame:
    """Rows by the sizes that the page answers for: ``span``, the name of the bin."""
    place, names = binned(frame["items"], (FEWER, *SIZES))
    found = frame.assign(span=[names[one] for one in place.tolist()], _place=place)
    return found.sort_values("_place", kind="stable").drop(columns="_place")


def of_customers(layouts: pd.Series, benchmark: Benchmark) -> NDArray[np.bool_]:
    """Mask of the customers' pallets, as palletising software planned them, among layouts."""
    sources = benchmark.layouts["sources"].reindex(layouts)
    return np.array([found is not None and PALLET_SOFTWARE in list(found) for found in sources])


def with_origins(frame: pd.DataFrame, benchmark: Benchmark) -> pd.DataFrame:
    """Rows by whose plan the case is: ``origin``; None in all where no customer planned one."""
    theirs = of_customers(frame["layout"], benchmark)
    names = np.where(theirs, CUSTOMERS, PACKERS) if theirs.any() else np.full(len(frame), None)
    return frame.assign(origin=names)
