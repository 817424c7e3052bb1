"""Steps of a labelled set by how safely they balance, and how far something moved at each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from enum import StrEnum
from typing import Any

import numpy as np
import pandas as pd

from steadyload.layouts.benchmark import Benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.model.question import Question
from steadyload.reports.columns import column, compact, markdown, percent, row
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share

SPARE = 0.01
"""Contact patches are drawn in, or widened, by this [cm]."""

FAR = 0.5
"""Multiple of a threshold that is a great part of it."""

_EXCEPTIONS = 12


class Balance(StrEnum):
    """Balance of a step, over the items joined to the new one.

    ``BALANCES``: with contact patches drawn in by :data:`SPARE`. ``NARROW``: only without that, or
    only with patches so much wider. ``OUT``: not even then.
    """

    BALANCES = "balances with 0.1 mm to spare"
    NARROW = "within 0.1 mm of losing balance"
    OUT = "out of balance by 0.1 mm or more"


@row
class BalanceRow:
    """Steps of a kind. Distances are in units of the threshold, None where there is no such step.

    ``asked``: steps of them about which the reference was asked, ``most_by_reference`` the farthest
    that something moved as it saw that.
    """

    balance: Balance = column("step")
    steps: int = column()
    cases: int = column(about="that have such a step")
    far: Estimate = column("moved by half a threshold %", percent)
    too_far: Estimate = column("moved too far %", percent)
    most: float | None = column("farthest", compact)
    asked: int
    most_by_reference: float | None

    @property
    def moved_far(self) -> int:
        """Number of the steps at which something moved by half a threshold."""
        return round(self.far.value * self.steps) if self.steps else 0


@row
class MovedStep:
    """A step that balances, as do all before it, at which something moved far: distances by the
    simulation that screens and by the reference, in units of the threshold.
    """

    layout: str = column(form=markdown)
    scenario: str = column()
    step: int = column()
    margin: float = column("margin cm")
    item: int = column()
    screen: float = column(form=compact)
    reference: float = column(form=compact)


@row
class BalancedSteps:
    """All screened steps of a labelled set.

    Attributes:
        steps: number of them.
        cases, instances: that they are of.
        first: steps by balance, of those before which all steps of the case balance.
        later: the others.
        again: of the steps of ``later`` that balance and at which something moved far, how many are
            such that it moved most at an earlier step, too, that does not balance; and all of them.
        exceptions: steps of ``first`` that balance, at which something moved far; the first ones.
        whole: cases of which every item was placed and every step balances.
        failing: of these, how many have a label that fails, by question.
    """

    steps: int
    cases: int
    instances: int
    first: Sequence[BalanceRow]
    later: Sequence[BalanceRow]
    again: tuple[int, int]
    exceptions: Sequence[MovedStep]
    whole: int
    failing: Mapping[str, int]

    @property
    def known(self) -> BalanceRow:
        """The steps of ``first`` that balance."""
        return next(own for own in self.first if own.balance is Balance.BALANCES)


def balanced_steps(benchmark: Benchmark) -> BalancedSteps:
    """The screened steps of all labelled cases of a set, in whatever split they are."""
    steps = steps_of(benchmark)
    first, far = steps["before"], steps["beyond"] > FAR
    balances = steps["balance"] == str(Balance.BALANCES)
    names = ["layout", "scenario", "step", "margin", "item", "screen", "reference"]
    moved = steps.loc[first & balances & far, names].head(_EXCEPTIONS)
    by_item = [steps[name] for name in (*KEYS, "item")]
    moves_again = (~balances).groupby(by_item).cummax()[~first & balances & far]
    held_all = (first & balances).groupby(by_item[:-1]).agg(["sum", "all"])
    complete = held_all[held_all["all"]]
    whole = _labelled(benchmark).loc[complete.index]
    whole = whole[complete["sum"].to_numpy() == whole["item_count"].to_numpy()]
    stands = benchmark.labels_on(Question.STANDS).set_index(KEYS)["failing_step"]
    return BalancedSteps(
        steps=len(steps),
        cases=len(steps.groupby(KEYS)),
        instances=steps["instance"].nunique(),
        first=_rows(steps[first]),
        later=_rows(steps[~first]),
        again=(int(moves_again.sum()), len(moves_again)),
        exceptions=[MovedStep(*own) for own in moved.itertuples(index=False)],
        whole=len(whole),
        failing={
            "within": int(whole["failing_step"].notna().sum()),
            "stands": int(stands.reindex(whole.index).notna().sum()),
        },
    )


def _labelled(benchmark: Benchmark) -> pd.DataFrame:
    return benchmark.cases[benchmark.cases["status"] == "done"].set_index(KEYS)


def steps_of(benchmark: Benchmark) -> pd.DataFrame:
    """A row a screened step: case, step, margin [cm], balance, and how far something moved.

    ``before``: whether all earlier steps of the case balance. ``beyond``: the greater of what the
    screen and the reference saw, in units of the threshold; ``reference`` is not a number where it
    was not asked.
    """
    screened = benchmark.screening.set_index(KEYS)
    columns = ["instance", "margin", "moved", "screen", "reference"]
    joined = _labelled(benchmark)[columns[:3]].join(screened, how="inner")[columns]
    return pd.DataFrame(
        [step for row in joined.itertuples() for step in _steps(row)],
        columns=[
            *KEYS, "instance", "step", "margin", "balance", "before", "item", "screen",
            "reference", "beyond",
        ],
    ).astype({"before": bool})  # fmt: skip


def _steps(row: Any) -> Iterator[tuple[Any, ...]]:
    (layout, scenario), instance, margin, moved, screen, reference = row
    # Margins are stored in thousandths, as numbers of 32 bits.
    margins = np.round(np.asarray(margin, dtype=float), 3)
    before = True
    for step, (own, item, seen, asked) in enumerate(
        zip(margins.tolist(), moved, screen, reference, strict=False)
    ):
        balance = balance_of(own)
        beyond = float(np.nanmax([seen, asked]))
        yield (layout, scenario, instance, step, own, str(balance), before, int(item), float(seen),
               float(asked), beyond)  # fmt: skip
        before = before and balance is Balance.BALANCES


def balance_of(margin: float) -> Balance:
    """The balance of a step with a margin [cm]."""
    if margin >= SPARE:
        return Balance.BALANCES
    return Balance.NARROW if margin > -SPARE else Balance.OUT


def _rows(steps: pd.DataFrame) -> list[BalanceRow]:
    return [
        BalanceRow(
            balance,
            steps=len(own),
            cases=len(own.groupby(KEYS)),
            far=share(own["beyond"] > FAR, own["instance"]),
            too_far=share(own["beyond"] > 1.0, own["instance"]),
            most=_greatest(own["beyond"]),
            asked=int(own["reference"].notna().sum()),
            most_by_reference=_greatest(own["reference"]),
        )
        for balance in Balance
        for own in [steps[steps["balance"] == str(balance)]]
    ]


def _greatest(values: pd.Series) -> float | None:
    return float(values.max()) if values.notna().any() else None
