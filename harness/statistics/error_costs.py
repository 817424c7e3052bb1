"""Expected cost of errors, where overestimations cost another amount than underestimations.

The unit of cost is that of an underestimation. A case without a verdict costs as much as one: a
layout that nobody vouches for is not loaded as planned.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from steadyload.statistics.estimate import Estimate

LEAST, MOST = 0.01, 100.0
"""Ratios of the cost of an overestimation to that of an underestimation that are looked at."""


@dataclass(frozen=True, slots=True)
class ErrorShares:
    """Shares of the cases on which a method errs, by direction.

    Attributes:
        over: overestimated: the failing step is later than the label's.
        under: underestimated, or without a verdict.
    """

    over: Estimate
    under: Estimate

    def cost(self, ratio: float) -> Estimate:
        """Expected cost a case.

        The interval is put together from those of both shares as if these were independent (the
        square-and-add method of Donner and Zou). Of two shares that exclude each other it is rather
        too wide.

        Args:
            ratio: cost of an overestimation over that of an underestimation.
        """
        value = ratio * self.over.value + self.under.value
        below = math.hypot(
            ratio * (self.over.value - self.over.low), self.under.value - self.under.low
        )
        above = math.hypot(
            ratio * (self.over.high - self.over.value), self.under.high - self.under.value
        )
        return Estimate(value, max(0.0, value - below), value + above, self.over.n)


@dataclass(frozen=True, slots=True)
class CheapestRange:
    """The ratios of costs, from ``least`` to ``most``, at which a method's errors cost least."""

    method: str
    least: float
    most: float


def cheapest_by_ratio(
    shares: Mapping[str, ErrorShares], least: float = LEAST, most: float = MOST
) -> tuple[CheapestRange, ...]:
    """The method whose errors cost least, for every ratio between two; by rising ratio.

    Costs are straight lines over the ratio, so each method is the cheapest on one range or on none.
    Of equal ones the first counts.

    Args:
        shares: by method; empty gives no range.
        least: the lowest ratio, above 0.
        most: the highest ratio.
    """
    lines = {name: (each.over.value, each.under.value) for name, each in shares.items()}
    if not lines:
        return ()
    found: list[CheapestRange] = []
    at = least
    here = min(lines, key=lambda name: (lines[name][0] * at + lines[name][1], lines[name][0]))
    while True:
        over, under = lines[here]
        # Only a method that overestimates less gets cheaper than this one further on.
        crossings = [
            (max(at, (own[1] - under) / (over - own[0])), own[0], name)
            for name, own in lines.items()
            if own[0] < over
        ]
        following = min(crossings, key=lambda each: each[:2], default=None)
        if following is None or following[0] >= most:
            return (*found, CheapestRange(here, at, most))
        if following[0] > at:
            found.append(CheapestRange(here, at, following[0]))
        at, here = following[0], following[2]
