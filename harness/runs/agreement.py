"""How often methods agree on the cases of a run."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from steadyload.layouts.model.layout import Layout
from steadyload.methods.naming import MethodKey
from steadyload.methods.simulation.simulation_parameters import SimulationParameters
from steadyload.runs.answers import Answers, Case, answers_of
from steadyload.runs.judged import JudgedCases
from steadyload.statistics.estimate import NOTHING, Estimate
from steadyload.statistics.metrics import agreement

COMMON = frozenset(f.name for f in dataclasses.fields(SimulationParameters))
"""Parameters that simulations on every engine have."""


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
