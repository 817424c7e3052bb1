"""Errors on the way to rest, and how a body rests."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from steadyload.reports.columns import column, decimal, fixed, general, one_decimal, row
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import median
from steadyload.studies.reality.record import Recorded
from steadyload.studies.reality.releasing import SINCE_CONTACT
from steadyload.studies.reality.running import ByEngine, Way

_LEAST_TRIALS = 8
"""With an error after so many impacts, for it to be shown."""


@row
class Grown:
    """Distance between simulation and record at a time, or before an impact."""

    engine: str = column(left=True)
    name: str
    at: float = column(form=general)
    trials: int = column("n")
    off_cm: Estimate = column("off cm, median", one_decimal)


@row
class Rest:
    """How a body rests by an engine, beside the record."""

    engine: str = column(left=True)
    height_mm: Estimate = column("height mm, median", one_decimal)
    sunk_mm: float | None = column("sunk in at rest mm", lambda mm: fixed(mm, 2))
    deepest_mm: Estimate = column("deepest corner mm, median", one_decimal, "of all frames")
    later_s: Estimate = column("rests later by s, median", decimal)
    moving: int = column("still moving")
    failed: int = column()


def by_time(one: ByEngine) -> Iterator[Grown]:
    """All trials, with fitted contacts, by the time since the last frame of free flight."""
    ends = [end for end in one.batches[Way.FITTED].ended if not end.failed]
    for k, seconds in enumerate(SINCE_CONTACT):
        off = [end.since_contact[k] for end in ends]
        there = [100.0 * metres for metres in off if metres is not None]
        if there:
            yield Grown(one.title, one.name, seconds, len(there), median(there))


def by_impacts(one: ByEngine) -> Iterator[Grown]:
    """Likewise by the number of impacts, just before the next one or at the end of the record."""
    ends = [end for end in one.batches[Way.FITTED].ended if not end.failed]
    for k in range(max((len(end.through_impacts) for end in ends), default=0)):
        off = [end.through_impacts[k] for end in ends if k < len(end.through_impacts)]
        there = [100.0 * metres for metres in off if metres is not None]
        if len(there) >= _LEAST_TRIALS:
            yield Grown(one.title, one.name, k, len(there), median(there))


def rest_of(one: ByEngine, recorded: Recorded) -> Rest:
    """How the body rests, with fitted contacts, by all trials."""
    ends = one.batches[Way.FITTED].ended
    there = [end for end in ends if not end.failed]
    times = {toss.name: toss.rest_s for toss in recorded.tosses}
    heights = [1e3 * end.height_m for end in there if end.height_m is not None]
    later = [end.rest_s - times[end.name] for end in there if end.rest_s is not None]
    return Rest(
        one.title,
        median(heights),
        recorded.half_edge_mm - float(np.median(heights)) if heights and recorded.is_cube else None,
        median([-1e3 * end.deepest_m for end in there if end.deepest_m is not None]),
        median(later),
        sum(end.rest_s is None for end in there),
        len(ends) - len(there),
    )
