"""How often screens and the reference disagreed while labels were made by screening."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import beta

from steadyload.labelling.screened_loading import CHECKED_BY_TWO
from steadyload.reports.columns import column, percent, row
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share

REASONS = {
    "differ": "of two screens one sees something move too far",
    "fails": "the screen sees something move too far",
    "near": "more than half of the way to that, of two screens 0.7",
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


@row
class CheckedScreening:
    """Labels of the cases that so many simulations screened, and the error that they can have.

    ``by_reference``: steps about which the reference was asked. ``alone``: share of all other
    steps. ``drawn``: of the steps at which the screens saw nothing near a threshold, those that
    were drawn at random, and put to the reference, too; ``wrong``: those of them at which the
    reference saw something move too far. ``most_wrong``: upper bound (95 %, Clopper and Pearson, by
    size of the movement) of the share of wrong ones among all such steps. ``cases_alone``: share of
    the cases about none of whose steps the reference was asked.
    """

    screens: int = column("screens")
    cases: int = column()
    steps: int = column()
    by_reference: int = column("by the reference")
    alone: float = column("by screens alone %", percent)
    drawn: int = column("drawn")
    wrong: int = column("of these wrong")
    most_wrong: float = column("wrong at most %", percent)
    cases_alone: Estimate = column("cases by screens alone %", percent)


def checked_screening(screening: pd.DataFrame) -> tuple[CheckedScreening, ...]:
    """By number of screens, how far labels rest on them.

    Args:
        screening: of a labelled set, :data:`steadyload.layouts.benchmark.tables.SCREENING`.
    """
    return tuple(_checked(screening))


def _checked(screening: pd.DataFrame) -> Iterator[CheckedScreening]:
    two = screening["second"].notna()
    for screens, own in ((1, screening[~two]), (2, screening[two])):
        if own.empty:
            continue
        screen, reference = (_joined(own[name]) for name in ("screen", "reference"))
        far = screen if screens == 1 else np.maximum(screen, _joined(own["second"]))
        why = np.concatenate([np.asarray(each, dtype=object) for each in own["why"]])
        asked = np.isfinite(reference)
        drawn = (why == "drawn") & asked
        wrong = drawn & (reference > 1.0)
        # Steps that only chance put to the reference, in strata of equal chance.
        quiet = (why == "") | drawn
        strata = np.digitize(far, list(CHECKED_BY_TWO)) if screens == 2 else np.zeros(len(far))
        counts = [
            (int((quiet & here).sum()), int((drawn & here).sum()), int((wrong & here).sum()))
            for here in (strata == each for each in np.unique(strata[quiet]))
        ]
        whole = sum(steps for steps, _, _ in counts)
        yield CheckedScreening(
            screens, len(own), len(far), int(asked.sum()), float(1.0 - asked.mean()),
            int(drawn.sum()), int(wrong.sum()),
            sum(n / whole * _upper(k, of, 0.05 / len(counts)) for n, of, k in counts),
            share([not np.isfinite(each).any() for each in own["reference"]]),
        )  # fmt: skip


def _upper(hits: int, of: int, level: float) -> float:
    """Upper bound of a share by Clopper and Pearson, one-sided."""
    return 1.0 if hits >= of else float(beta.ppf(1.0 - level, hits + 1, of - hits))
