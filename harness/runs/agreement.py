"""How often methods agree on the cases of a run."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from steadyload.layouts.model.layout import Layout
from steadyload.methods.naming import MethodKey
from steadyload.methods.simulation.simulation_parameters import SimulationParameters
from steadyload.reports.columns import column, percent, row
from steadyload.runs.answers import Answers, Case, answers_of
from steadyload.runs.judged import JudgedCases
from steadyload.statistics.estimate import NOTHING, Estimate
from steadyload.statistics.metrics import agreement

COMMON = frozenset(f.name for f in dataclasses.fields(SimulationParameters))
"""Parameters that simulations on every engine have."""


@row
class Agreeing:
    """A method, and its shares of equal failing steps with each, by title."""

    method: str = column()
    shares: Mapping[str, Estimate] = column("{}", percent)


class Pair(NamedTuple):
    """A cell of a matrix: titles of its row and column, and their share of equal failing steps."""

    of: str
    other: str
    same: Estimate


@dataclass(frozen=True, slots=True)
class AgreementMatrix:
    """Share of equal failing steps between every two methods, and the answers themselves.

    A method is not compared with itself: the diagonal is :data:`.NOTHING`.
    """

    methods: tuple[MethodKey, ...]
    shares: tuple[tuple[Estimate, ...], ...]
    answers: Answers | None = None

    @property
    def titles(self) -> tuple[str, ...]:
        """The methods' titles, in the order of rows and columns."""
        return tuple(method.title for method in self.methods)

    @property
    def rows(self) -> list[Agreeing]:
        """A row a method."""
        return [
            Agreeing(title, dict(zip(self.titles, shares, strict=True)))
            for title, shares in zip(self.titles, self.shares, strict=True)
        ]

    @property
    def cells(self) -> list[Pair]:
        """All cells, row by row."""
        return [Pair(own.method, *pair) for own in self.rows for pair in own.shares.items()]


def agreement_matrix(judged: JudgedCases, layouts: Mapping[Case, Layout]) -> AgreementMatrix:
    """Share of equal failing steps between every two methods.

    Args:
        judged: the cases and verdicts.
        layouts: see :func:`steadyload.runs.answers.answers_of`.
    """
    specs = list(judged.keys)
    return AgreementMatrix(
        tuple(judged.keys.values()),
        tuple(
            tuple(
                NOTHING if a == b else agreement(judged.said, a, b, judged.clusters) for b in specs
            )
            for a in specs
        ),
        answers_of(judged, layouts),
    )


def tuning(parameters: Mapping[str, Any]) -> str:
    """The parameters that every engine has, as a text, equal for equally tuned simulations."""
    return json.dumps({k: v for k, v in parameters.items() if k in COMMON}, sort_keys=True)
