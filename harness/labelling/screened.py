"""How often the screen and the reference disagreed while labels were made by screening."""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.reports.columns import column, percent, row
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share

REASONS = {
    "fails": "the screen sees something move too far",
    "near": "more than half of the way to that",
    "narrow": "balance within 1 mm",
    "no end": "the screen comes to no end",
    "drawn": "drawn at random",
}
"""Why the reference was asked about a step, in words."""


@row
class ScreenedReason:
    """Steps about which the reference was asked for one reason.

    ``screen``, ``reference``: those at which something moved too far by either; ``differ``: those
    on which they disagree whether it did, and their share, clustered by case.
    """

    reason: str = column("the reference was asked, because")
    steps: int = column()
    screen: int = column("too far, screen")
    reference: int = column("too far, reference")
    differ: int = column("disagree")
    share: Estimate = column("disagree %", percent)


@row
class ScreenedSteps:
    """All steps of the labelled cases.

    Attributes:
        cases: that were labelled by screening.
        steps: about which the screen was asked.
        reasons: steps about which the reference was asked, too, by reason.
    """

    cases: int
    steps: int
    reasons: tuple[ScreenedReason, ...]

    def of(self, reason: str) -> ScreenedReason | None:
        """The steps of a key of :data:`REASONS`; None where there are none."""
        return next((r for r in self.reasons if r.reason == REASONS[reason]), None)


def screened_steps(screening: pd.DataFrame) -> ScreenedSteps:
    """Counts of steps by the reason for which the reference was asked.

    Args:
        screening: of a labelled set, :data:`steadyload.layouts.benchmark.tables.SCREENING`.
    """
    if screening.empty:
        return ScreenedSteps(0, 0, ())
    screen, reference = (_joined(screening[name]) for name in ("screen", "reference"))
    why = np.concatenate([np.asarray(own, dtype=object) for own in screening["why"]])
    case = np.repeat(np.arange(len(screening)), screening["why"].map(len))
    found = []
    for reason, words in REASONS.items():
        here = (why == reason) & np.isfinite(reference)
        seen, told = screen[here] > 1.0, reference[here] > 1.0
        if here.any():
            differ = seen != told
            found.append(
                ScreenedReason(
                    words, int(here.sum()), int(seen.sum()), int(told.sum()), int(differ.sum()),
                    share(differ, case[here]),
                )
            )  # fmt: skip
    return ScreenedSteps(len(screening), len(screen), tuple(found))


def _joined(lists: pd.Series) -> NDArray[np.float64]:
    return np.concatenate([np.asarray(own, dtype=float) for own in lists])
