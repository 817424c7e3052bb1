"""Steps of a labelled set by how safely they balance, and how far something moved at each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np
import pandas as pd

from steadyload.layouts.benchmark import Benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share

SPARE = 0.01
"""Contact patches are drawn in, or widened, by this [cm]."""

FAR = 0.5
"""Multiple of a threshold that is a great part of it."""

_EXCEPTIONS = 12


class Balance(StrEnum):
    """Balance of a step, over the items joined to the new one.

    ``balances``: with contact patches drawn in by :data:`SPARE`. ``narrow``: only without that, or
    only with patches so much wider. ``out``: not even then.
    """

    BALANCES = "balances"
    NARROW = "narrow"
    OUT = "out"


@dataclass(frozen=True, slots=True)
class BalanceRow:
    """Steps of a kind: number of steps and of cases that have one, and the share at which something
    moved by more than half a threshold, and by more than a threshold, as far as was seen.

    ``asked``: steps of them about which the reference was asked. ``most``: the farthest that
    something moved, in units of the threshold, ``most_by_reference`` as the reference saw it; None
    where there is no such step.
    """

    balance: Balance
    steps: int
    cases: int
    asked: int
    far: Estimate
    too_far: Estimate
    most: float | None
    most_by_reference: float | None


@dataclass(frozen=True, slots=True)
class MovedStep:
    """A step that balances, as do all before it, at which something moved far: distances by the
    simulation that screens and by the reference, in units of the threshold.
    """

    layout: str
    scenario: str
    step: int
    margin: float
    item: int
    screen: float
    reference: float


@dataclass(frozen=True)
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
    first: tuple[BalanceRow, ...]
    later: tuple[BalanceRow, ...]
    again: tuple[int, int]
    exceptions: tuple[MovedStep, ...]
    whole: int
    failing: Mapping[str, int]

    def of(self, balance: Balance) -> BalanceRow:
        """The steps of a balance, of those before which all steps of the case balance."""
        return next(row for row in self.first if row.balance is balance)


def balanced_steps(benchmark: Benchmark) -> BalancedSteps:
    """The screened steps of all labelled cases of a set, in whatever split they are."""
    steps = steps_of(benchmark)
    first = steps["before"]
    held = steps[first & (steps["balance"] == str(Balance.BALANCES)) & (steps["beyond"] > FAR)]
    cases = benchmark.cases[benchmark.cases["status"] == "done"].set_index(KEYS)
    balances = steps["before"] & (steps["balance"] == str(Balance.BALANCES))
    held_all = balances.groupby([steps["layout"], steps["scenario"]]).agg(["sum", "all"])
    complete = held_all[held_all["all"]]
    whole = cases.loc[complete.index]
    whole = whole[complete["sum"].to_numpy() == whole["item_count"].to_numpy()]
    stands = benchmark.stands.set_index(KEYS)["failing_step"].reindex(whole.index)
    return BalancedSteps(
        len(steps),
        len(steps.groupby(KEYS)),
        steps["instance"].nunique(),
        tuple(_rows(steps[first])),
        tuple(_rows(steps[~first])),
        _moved_again(steps),
        tuple(
            MovedStep(row.layout, row.scenario, row.step, row.margin, row.item, row.screen,
                      row.reference)
            for row in held.head(_EXCEPTIONS).itertuples()
        ),
        len(whole),
        {
            "within": int(whole["failing_step"].notna().sum()),
            "stands": int(stands.notna().sum()),
        },
    )  # fmt: skip


def steps_of(benchmark: Benchmark) -> pd.DataFrame:
    """A row a screened step: case, step, margin [cm], balance, and how far something moved.

    ``before``: whether all earlier steps of the case balance. ``beyond``: the greater of what the
    screen and the reference saw, in units of the threshold; ``reference`` is not a number where it
    was not asked.
    """
    screened = benchmark.screening.set_index(KEYS)
    cases = benchmark.cases[benchmark.cases["status"] == "done"].set_index(KEYS)
    columns = ["instance", "margin", "moved", "screen", "reference"]
    joined = cases[["instance", "margin", "moved"]].join(screened, how="inner")[columns]
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


def _rows(steps: pd.DataFrame) -> Iterator[BalanceRow]:
    for balance in Balance:
        own = steps[steps["balance"] == str(balance)]
        yield BalanceRow(
            balance,
            len(own),
            len(own.groupby(KEYS)),
            int(own["reference"].notna().sum()),
            share(own["beyond"] > FAR, own["instance"]),
            share(own["beyond"] > 1.0, own["instance"]),
            _greatest(own["beyond"]),
            _greatest(own["reference"]),
        )


def _greatest(values: pd.Series) -> float | None:
    return float(values.max()) if values.notna().any() else None


def _moved_again(steps: pd.DataFrame) -> tuple[int, int]:
    """See :attr:`BalancedSteps.again`."""
    again, of = 0, 0
    for _, case in steps.groupby(KEYS):
        known: set[int] = set()
        for step in case.itertuples():
            if step.balance != str(Balance.BALANCES):
                known.add(step.item)
            elif not step.before and step.beyond > FAR:
                of += 1
                again += step.item in known
    return again, of
