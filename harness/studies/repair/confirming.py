"""Answers of independent judges on plans: of engines, and of the reference with two contacts."""

from __future__ import annotations

import time
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from steadyload.app.check_defaults import GAPS_CM
from steadyload.app.repairs import chance_to_stand
from steadyload.labelling.close_steps import (
    CONTACTS,
    CloseSteps,
    StepVerdicts,
    last_and_earlier,
    made_for,
)
from steadyload.labelling.label_rows import LABEL
from steadyload.layouts.benchmark.confidence import Reason
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.question import Question
from steadyload.layouts.model.snapping import snap
from steadyload.methods.contract.method import Status
from steadyload.methods.equilibrium.margin import margin_of
from steadyload.methods.registry import make_method
from steadyload.runs.methods_here import method_named
from steadyload.runs.provenance import made_by
from steadyload.statics.load_margin import MarginKind
from steadyload.studies.kit import Asked

ENGINES: Mapping[str, str] = {
    "Bullet": "ps_opt@bullet:question=stands",
    "MuJoCo": "ps_opt@mujoco:question=stands",
    "DART": "ps_opt@dart:question=stands",
}
"""Simulations that judge plans at every step, by title."""

SECONDS = 30.0
"""CPU time of their judgement, at most: what has no answer by then has none."""

STIFF, SOFT = "reference, 1e9 N/m", "reference, 1e7 N/m"
REFERENCES: Mapping[str, str] = {
    STIFF: LABEL,
    SOFT: next(each.spec for each in CONTACTS if each.reason is Reason.MODEL),
}
"""The reference that labels the cases of the sets, and the same with contacts a hundredth as stiff,
which throws of a real cube fit."""


@dataclass(frozen=True, slots=True)
class Judged:
    """The answer of a judge on a plan.

    Attributes:
        status: word of :class:`Status`.
        failing_step: None where it stands, or without an answer.
    """

    status: str
    failing_step: int | None

    @property
    def stands(self) -> bool:
        """Whether the judge says so: no answer is no yes."""
        return self.is_known and self.failing_step is None

    @property
    def is_known(self) -> bool:
        """Whether there is an answer."""
        return self.status == Status.DONE


class EngineUnit(Asked[Judged], what="does a plan stand"):
    """A plan, judged by a simulation at every step.

    Attributes:
        plan: to be judged.
        method: spec of the simulation.
        limit: see :data:`SECONDS`.
        made_by: versions of what it rests on.
    """

    plan: Layout
    method: str
    limit: float
    made_by: Mapping[str, str]

    def describe(self, part: int) -> str:
        """Description of the judgement for messages."""
        return f"{self.method}: {self.plan.name}"

    def measure(self) -> Judged:
        """Judge it."""
        verdict = method_named(self.method).judge(self.plan, timeout=self.limit)
        return Judged(str(verdict.status), verdict.failing_step)


@dataclass(frozen=True, slots=True)
class Firmness:
    """How firmly a plan stands, small gaps closed.

    Attributes:
        margin_cm: see :class:`steadyload.statics.load_margin.LoadMargin`; None without one.
        as_planned: whether that is the margin of the plan itself.
        step: at which it is smallest, from 0; None where it is nowhere small.
        chance: see :func:`steadyload.app.repairs.chance_to_stand`.
        seconds: CPU time of both.
    """

    margin_cm: float | None
    as_planned: bool
    step: int | None
    chance: float
    seconds: float


class FirmnessUnit(
    Asked[Firmness], what="margin of a plan and its chance to stand", gaps_cm=GAPS_CM
):
    """A plan, its gaps of up to :data:`GAPS_CM` closed, measured by exact equilibrium.

    Attributes:
        plan: to be measured.
        made_by: versions of equilibrium.
    """

    plan: Layout
    made_by: Mapping[str, str]

    def describe(self, part: int) -> str:
        """Description of the measurement for messages."""
        return f"margin of {self.plan.name}"

    def measure(self) -> Firmness:
        """Measure it."""
        begun, closed = time.process_time(), snap(self.plan, GAPS_CM)
        margin, chance = margin_of(closed), chance_to_stand(closed)
        seconds = time.process_time() - begun
        if margin is None:
            return Firmness(None, False, None, chance, seconds)
        is_planned = margin.kind is MarginKind.AS_PLANNED
        return Firmness(margin.cm, is_planned, margin.step, chance, seconds)


def engine_units(plans: Sequence[Layout]) -> list[EngineUnit]:
    """All of these plans by all of :data:`ENGINES`, plan by plan."""
    made = {spec: made_by(make_method(spec)) for spec in ENGINES.values()}
    return [EngineUnit(plan, spec, SECONDS, made[spec]) for plan in plans for spec in made]


def firmness_units(plans: Sequence[Layout]) -> list[FirmnessUnit]:
    """A unit a plan."""
    made = made_by(make_method("settling")) | made_by(make_method("equilibrium"))
    return [FirmnessUnit(plan, made) for plan in plans]


def reference_units(plans: Sequence[Layout], firmness: Sequence[Firmness]) -> list[CloseSteps]:
    """All of these plans by all of :data:`REFERENCES`, plan by plan."""
    made = {spec: made_for(spec) for spec in REFERENCES.values()}
    return [
        CloseSteps(plan, spec, judged_steps(plan, own), made[spec])
        for plan, own in zip(plans, firmness, strict=True)
        for spec in made
    ]


def judged_steps(plan: Layout, firmness: Firmness) -> tuple[int, ...]:
    """The steps that the references judge: the last, the narrowest, and earlier ones at random."""
    chosen = last_and_earlier(len(plan), zlib.crc32(plan.name.encode()))
    return tuple(sorted(chosen if firmness.step is None else chosen | {firmness.step}))


def judged(said: StepVerdicts) -> Judged:
    """The answer of a reference to the question ``stands``."""
    return Judged(*said.verdict(Question.STANDS))
