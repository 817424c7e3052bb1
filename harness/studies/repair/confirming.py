"""Verdicts of others than the judge on changed plans: of two engines, and of the reference."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass

from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.method import Status
from steadyload.methods.registry import make_method
from steadyload.runs.methods_here import method_named
from steadyload.runs.provenance import made_by
from steadyload.studies.kit import Asked

ENGINES: Mapping[str, str] = {
    "Bullet": "ps_opt@bullet:question=stands",
    "MuJoCo": "ps_opt@mujoco:question=stands",
}
"""Simulations that judge changed plans, too, by their title."""

REFERENCE = "label@reference:question=stands"
"""Simulation that labels the cases of the sets."""


@dataclass(frozen=True, slots=True)
class Stands:
    """A verdict on a changed plan.

    Attributes:
        status: word of :class:`Status`.
        failing_step: None where it stands.
    """

    status: str
    failing_step: int | None

    @property
    def stands(self) -> bool:
        """Whether the plan stands."""
        return self.status == Status.DONE and self.failing_step is None


class EngineUnit(Asked[Stands], question="does a changed plan stand"):
    """A changed plan, judged by a simulation."""

    layout: Layout
    method: str
    made_by: Mapping[str, str]

    def describe(self, part: int) -> str:
        """Description of the judgement for messages."""
        return f"{self.method}: {self.layout.name}"

    def measure(self) -> Stands:
        """Judge it."""
        verdict = method_named(self.method).judge(self.layout)
        return Stands(str(verdict.status), verdict.failing_step)


@dataclass(frozen=True, slots=True)
class Labelled:
    """The answer of the reference on a changed plan.

    Attributes:
        status: word of :class:`Status`.
        failing_step: None where it stands.
        seconds: CPU time.
    """

    status: str
    failing_step: int | None
    seconds: float

    @property
    def settled(self) -> bool:
        """Whether there is an answer."""
        return self.status == Status.DONE

    @property
    def stands(self) -> bool:
        """Whether the plan stands."""
        return self.settled and self.failing_step is None


class LabelUnit(Asked[Labelled], question="label of a changed plan", method=REFERENCE):
    """A changed plan, judged at every step by the reference."""

    layout: Layout
    made_by: Mapping[str, str]

    def describe(self, part: int) -> str:
        """Description of the labelling for messages."""
        return f"label of {self.layout.name}, {len(self.layout)} boxes"

    def measure(self) -> Labelled:
        """Label it."""
        method = method_named(REFERENCE)
        method.prepare(len(self.layout))
        begun = time.process_time()
        verdict = method.judge(self.layout)
        return Labelled(str(verdict.status), verdict.failing_step, time.process_time() - begun)


def engine_units(layouts: list[Layout]) -> list[EngineUnit]:
    """All of these layouts by all of :data:`ENGINES`, engine by engine."""
    made = {spec: made_by(make_method(spec)) for spec in ENGINES.values()}
    return [EngineUnit(each, spec, made[spec]) for spec in made for each in layouts]


def label_units(layouts: list[Layout]) -> list[LabelUnit]:
    """A unit a layout."""
    made = made_by(make_method(REFERENCE))
    return [LabelUnit(each, made) for each in layouts]
