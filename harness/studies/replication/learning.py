"""Learning from the training part of a split: networks of the paper, and a memoriser."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from steadyload.layouts.model.layout import FloatArray, Layout
from steadyload.learners.features import FeatureKind
from steadyload.learners.options import TrainingOptions, training_preset
from steadyload.learners.scoring import items_safe
from steadyload.learners.sequences import Numbers, sequences_of
from steadyload.learners.tested import NetworkTraining, TestedNetwork, train_and_test
from steadyload.runs.store import CHECKPOINTS
from steadyload.statistics.placed import failing_step_of
from steadyload.studies.kit import Lab
from steadyload.studies.replication.methods import LSTM_1, LSTM_E, MEMORISER, SUPPORT, Extent
from steadyload.studies.replication.splits import Fold, Rights, SplitKind, folds

TABLE_4 = training_preset("paper-ensemble")
"""Options of the networks of Table 4, and the size and learning rate of each; the first one is
LSTM_1."""

PATIENCE = 100
"""Epochs without a better one before a training ends; the paper trains for all 700."""


def paper_options(member: int, seed: int, **changes: Any) -> TrainingOptions:
    """The options of a network of Table 4, with some changed."""
    own = {**TABLE_4.networks[member], "seed": seed, "patience": PATIENCE}
    return replace(TABLE_4.options, **own | changes)


class Memoriser:
    """Labels of training cases, found by the boxes that come first.

    Most alike is the case that begins with the same boxes at the same places for longest: that of a
    twin where there is one. Of several it is the one whose centres of mass, over these boxes and in
    shares of their sides, are nearest; of several of these the first. Its failing step is the
    verdict, and a step beyond the last item of the layout means that it is stable. A layout that
    nothing begins like is called stable, as most are.

    Args:
        cases: layouts with their failing steps, None for a stable one.
    """

    def __init__(self, cases: Iterable[tuple[Layout, int | None]]) -> None:
        self._steps: list[int | None] = []
        self._shifts: list[FloatArray] = []
        self._beginnings: dict[bytes, list[int]] = {}
        for which, (layout, step) in enumerate(cases):
            self._steps.append(step)
            self._shifts.append(_shifts(layout))
            for beginning in _beginnings(layout):
                self._beginnings.setdefault(beginning, []).append(which)

    def failing_step(self, layout: Layout) -> int | None:
        """The failing step of the case most like a layout; None for stable."""
        for count, beginning in reversed(list(enumerate(_beginnings(layout), start=1))):
            alike = self._beginnings.get(beginning)
            if alike:
                own = _shifts(layout)[:count]
                apart = [float(np.square(self._shifts[k][:count] - own).sum()) for k in alike]
                step = self._steps[alike[int(np.argmin(apart))]]
                return step if step is not None and step < len(layout) else None
        return None


def _shifts(layout: Layout) -> FloatArray:
    """Centres of mass from the middle, in shares of the sides, (J, 3)."""
    shifts: FloatArray = layout.mass_offsets / (layout.upper - layout.lower)
    return shifts


def _beginnings(layout: Layout) -> list[bytes]:
    """For every item the pallet and all boxes up to it, as bytes."""
    rows = np.hstack([layout.lower, layout.upper]).astype("<f8")
    whole, start = rows.tobytes(), np.array(layout.pallet.size, "<f8").tobytes()
    width = rows.shape[1] * rows.itemsize
    return [start + whole[: width * count] for count in range(1, len(rows) + 1)]


class Learned(NamedTuple):
    """Cases on which something that learnt on a split is right, (seeds, cases), and its networks;
    cases that are not of the test count as wrong.
    """

    right: Rights
    networks: Sequence[TestedNetwork] = ()


def _ensembles(kind: SplitKind, extent: Extent) -> dict[str, list[list[TrainingOptions]]]:
    """By name the ensembles that are trained on every fold of a split."""
    epochs = extent.epochs
    found = {LSTM_1: [[paper_options(0, seed, epochs=epochs)] for seed in range(extent.seeds)]}
    if extent.ensemble and kind is not SplitKind.FEWER:
        members = range(len(TABLE_4.networks))
        found[LSTM_E] = [[paper_options(member, 0, epochs=epochs) for member in members]]
    if kind is SplitKind.LIST:
        found[SUPPORT] = [[paper_options(0, 0, epochs=epochs, features=FeatureKind.SUPPORT)]]
    return found


def learn(
    lab: Lab, cases: pd.DataFrame, layouts: Sequence[Layout], extent: Extent
) -> dict[tuple[str, SplitKind], Learned]:
    """Train and test on every split, by name and split."""
    made = {kind: folds(cases, kind) for kind in SplitKind}
    plans = {kind: _ensembles(kind, extent) for kind in SplitKind}
    wanted = {
        (kind, fold.number, options): fold
        for kind, plan in plans.items()
        for fold in made[kind]
        for ensembles in plan.values()
        for members in ensembles
        for options in members
    }
    features = {options.features for *_, options in wanted}
    sequences = {kind: sequences_of(cases, layouts, kind, "files") for kind in features}

    def trainings() -> Iterator[NetworkTraining]:
        for (kind, number, options), fold in wanted.items():
            parts = (fold.train, fold.validation, fold.test)
            learnt, stopping, asked = map(sequences[options.features].chosen, parts)
            folder, seconds = lab.work / CHECKPOINTS, 3600.0 * extent.hours / len(wanted)
            name = f"{kind}-{number}"
            yield NetworkTraining(name, options, learnt, stopping, asked, folder, seconds)

    tested = train_and_test(
        trainings, lab.work, workers=lab.workers,
        progress=lambda *of: lab.progress("training", *of),
    )  # fmt: skip
    networks = dict(zip(wanted, tested, strict=True))
    every, found = next(iter(sequences.values())), {}
    for kind, plan in plans.items():
        found[MEMORISER, kind] = Learned(_memorised(every.safe, layouts, made[kind]))
        for name, ensembles in plan.items():
            right, used = np.zeros((len(ensembles), len(cases)), dtype=bool), []
            for own, members in zip(right, ensembles, strict=True):
                for fold in made[kind]:
                    told = [networks[kind, fold.number, options] for options in members]
                    mean = np.mean([each.probabilities for each in told], axis=0)  # Eq. 8
                    own[fold.test] = (
                        items_safe(mean, every.counts[fold.test]) == every.safe[fold.test]
                    )
                    used += told
            found[name, kind] = Learned(right, used)
    return found


def _memorised(safe: Numbers, layouts: Sequence[Layout], parts: Sequence[Fold]) -> Rights:
    """Mask of the cases of the test on which the memoriser is right, (1, cases)."""
    labels = [failing_step_of(*one) for one in zip(safe.tolist(), map(len, layouts), strict=True)]
    right = np.zeros((1, len(layouts)), dtype=bool)
    for fold in parts:
        memoriser = Memoriser((layouts[k], labels[k]) for k in np.flatnonzero(fold.train).tolist())
        for k in np.flatnonzero(fold.test).tolist():
            right[0, k] = memoriser.failing_step(layouts[k]) == labels[k]
    return right
