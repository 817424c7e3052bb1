"""How often screens and the reference disagreed while labels were made by screening."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import beta

from steadyload.labelling.screened_loading import CHECKED_BY_TWO
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.sizes import FEWER, SIZES, binned
from steadyload.reports.columns import column, percent, plain_percent, row
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share

REASONS = {
    "differ": "of two screens one sees something move too far",
    "fails": "the screen sees something move too far",
    "near": "more than half of the way to that, of two screens 0.85",
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
    why = _joined(screening["why"], object)
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


def _joined(lists: pd.Series, kind: type = float) -> NDArray[Any]:
    return np.concatenate([np.asarray(own, dtype=kind) for own in lists])


@row
class CheckedScreening:
    """Labels of the cases of one size, and the error that screens can have brought into them.

    ``alone``: share of the steps about which the reference was not asked. ``drawn``: of the steps
    at which screens saw nothing near a threshold, those that were drawn at random and put to the
    reference, too; ``wrong``: those of them at which the reference saw something move too far.
    ``most_wrong``: upper bound (95 %, Clopper and Pearson, by equal chance to be drawn) of the
    share of wrong ones among all steps that nothing but chance put to the reference.
    ``cases_alone``: share of the cases in which nothing else put a step to the reference.
    """

    boxes: str = column(left=False)
    cases: int = column()
    steps: int = column()
    alone: float = column("steps by screens alone %", plain_percent)
    drawn: int = column("steps drawn")
    wrong: int = column("of these wrong")
    most_wrong: float = column("wrong at most %", partial(plain_percent, digits=2))
    cases_alone: Estimate = column("cases by screens alone %", percent)


def checked_screening(screening: pd.DataFrame, cases: pd.DataFrame) -> tuple[CheckedScreening, ...]:
    """By size, how far labels rest on screens.

    Args:
        screening: of a labelled set, :data:`steadyload.layouts.benchmark.tables.SCREENING`.
        cases: of the set, with ``item_count`` and ``instance``.
    """
    if screening.empty:
        return ()
    known = cases.set_index(KEYS).loc[pd.MultiIndex.from_frame(screening[KEYS])]
    place, names = binned(known["item_count"], (FEWER, *SIZES))
    lists = known["instance"].to_numpy()
    return tuple(
        _checked(name, screening[place == number], lists[place == number])
        for number, name in names.items()
    )


def _checked(name: str, own: pd.DataFrame, lists: NDArray[np.object_]) -> CheckedScreening:
    two = np.repeat(own["second"].notna(), own["why"].map(len))
    screen, reference = (_joined(own[name]) for name in ("screen", "reference"))
    far = screen.copy()
    if two.any():
        far[two] = np.maximum(screen[two], _joined(own["second"].dropna()))
    why = _joined(own["why"], object)
    asked = np.isfinite(reference)
    drawn = (why == "drawn") & asked
    wrong = drawn & (reference > 1.0)
    # Steps that chance alone put to the reference, in strata of equal chance.
    quiet = (why == "") | drawn
    strata = np.where(two, np.digitize(far, list(CHECKED_BY_TWO)), -1)
    counts = [
        (int((quiet & here).sum()), int((drawn & here).sum()), int((wrong & here).sum()))
        for here in (strata == each for each in np.unique(strata[quiet]))
    ]
    whole = sum(steps for steps, _, _ in counts)
    return CheckedScreening(
        name, len(own), len(far), float(1.0 - asked.mean()), int(drawn.sum()), int(wrong.sum()),
        sum(n / whole * _upper(k, of, 0.05 / len(counts)) for n, of, k in counts),
        share([all(not each or each == "drawn" for each in steps) for steps in own["why"]], lists),
    )  # fmt: skip


def _upper(hits: int, of: int, level: float) -> float:
    """Upper bound of a share by Clopper and Pearson, one-sided."""
    return 1.0 if hits >= of else float(beta.ppf(1.0 - level, hits + 1, of - hits))
