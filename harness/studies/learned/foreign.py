"""Learned methods on layouts of another kind than those of their training."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from itertools import combinations
from operator import attrgetter
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from steadyload.layouts.model.layout import Layout
from steadyload.learners.methods import LearnedMethod
from steadyload.learners.plans.plan import ForeignPlan
from steadyload.learners.ranges import QUANTITIES, SLACK, extent_of
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.reports.columns import column, percent, row
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.results import load_results
from steadyload.runs.runner import run_study
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import agreement, outcomes, share
from steadyload.studies.kit import Lab

_ACCEPT = "outside=accept"


@row
class Share:
    """A share under a name, which the header of its table says."""

    what: str = column()
    share: Estimate = column("%", percent)


class Ends(NamedTuple):
    """The least and the greatest value of a quantity."""

    least: float
    greatest: float

    def __str__(self) -> str:
        return f"{self.least:g} to {self.greatest:g}"


@row
class Reason:
    """A quantity that is outside of the training range; a layout may have several."""

    judge: str = column()
    quantity: str = column("outside")
    layouts: int = column()
    trained: Ends = column("trained on")
    here: Ends = column(about="of all layouts")


@row
class Judged:
    """A learned method, which refuses layouts outside of its training range."""

    method: MethodKey = column("judge", attrgetter("title"), left=True)
    refused: Estimate = column("refused %", percent)
    agreement: Mapping[str, Estimate] = column(
        "as {} %", percent, "share of equal failing steps, with refusals switched off"
    )
    stable: Estimate = column("says stable %", percent, "likewise")
    accepted: int = column("n", about="layouts that it does not refuse")
    inside: Mapping[str, Estimate] = column("as {} %", percent, "share of equal steps on these")
    reasons: Sequence[Reason]


@row
class Foreign:
    """Layouts of another kind.

    ``others``: share of layouts that each other method judges to be stable. ``among``: by pair of
    them, share of equal failing steps.
    """

    files: int
    layouts: int
    max_items: int
    rows: Sequence[Judged]
    others: Sequence[Share]
    among: Sequence[Share]

    @property
    def reasons(self) -> list[Reason]:
        """Those of all methods."""
        return [reason for each in self.rows for reason in each.reasons]


def judge_foreign(lab: Lab, plan: ForeignPlan, files: Sequence[Path], limit: int | None) -> Foreign:
    """Share of layouts that learned methods refuse, and their agreement with other methods.

    Args:
        lab: where it runs; an interrupted run is resumed.
        plan: the methods.
        files: of layouts.
        limit: largest number of layouts; None for all.

    Raises:
        LayoutError: a file is invalid.
        as :func:`steadyload.runs.runner.run_study`.
    """
    accepting = {spec: _accepting(spec) for spec in plan.judges}
    study = StudyDefinition(
        name="learned foreign",
        methods=(*plan.others, *accepting.values()),
        files=tuple(file.resolve() for file in files),
        max_items=plan.max_items,
        limit=limit,
        shard_size=60,
    )
    folder = lab.work / "foreign"
    run_study(study, folder, workers=lab.workers, progress=partial(lab.progress, "foreign"))
    said = outcomes(load_results(folder))
    by_name = {each.name: each.first(min(len(each), plan.max_items)) for each in study.layouts()}
    layouts = [by_name[name] for name in said.index.get_level_values("layout")]
    others = [method_key(make_method(spec)) for spec in plan.others]
    return Foreign(
        files=len(study.files),
        layouts=len(layouts),
        max_items=plan.max_items,
        rows=[_row(spec, said, accepting[spec], layouts, others) for spec in plan.judges],
        others=[Share(one.title, _stable(said[one.spec], layouts)) for one in others],
        among=[
            Share(f"{one.title} and {other.title}", agreement(said, one.spec, other.spec))
            for one, other in combinations(others, 2)
        ],
    )


def _accepting(spec: str) -> str:
    """The canonical spec of the same method without refusals."""
    plain = str(make_method(spec).spec)
    return str(make_method(f"{plain}{',' if ':' in plain else ':'}{_ACCEPT}").spec)


def _row(
    spec: str,
    said: pd.DataFrame,
    accepting: str,
    layouts: Sequence[Layout],
    others: Sequence[MethodKey],
) -> Judged:
    judge = make_method(spec)
    assert isinstance(judge, LearnedMethod)
    key, ranges = method_key(judge), judge.weights.ranges.ranges
    trained = np.array([ranges[name] for name in QUANTITIES])
    found = np.array([_extent(layout) for layout in layouts])
    below = found[:, 0] < trained[:, 0] * (1.0 - SLACK)
    outside = below | (found[:, 1] > trained[:, 1] * (1.0 + SLACK))
    refused = outside.any(axis=1)
    reasons = [
        Reason(
            key.title, name, int(outside[:, k].sum()), Ends(*trained[k]),
            Ends(found[:, 0, k].min(), found[:, 1, k].max()),
        )
        for k, name in enumerate(QUANTITIES)
        if outside[:, k].any()
    ]  # fmt: skip
    return Judged(
        method=key,
        refused=share(refused),
        agreement={one.title: agreement(said, accepting, one.spec) for one in others},
        stable=_stable(said[accepting], layouts),
        accepted=int((~refused).sum()),
        inside={one.title: agreement(said[~refused], accepting, one.spec) for one in others},
        reasons=sorted(reasons, key=lambda reason: -reason.layouts),
    )


def _extent(layout: Layout) -> np.ndarray:
    arrays = (layout.lower, layout.upper, layout.weights, layout.mass_offsets)
    return extent_of(*arrays, layout.floor.corners, max(layout.pallet.size))


def _stable(said: pd.Series, layouts: Sequence[Layout]) -> Estimate:
    return share(said.fillna(-1).astype(int).to_numpy() == [len(layout) for layout in layouts])
