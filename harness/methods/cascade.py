"""A cascade: the cheapest judge that is sure of a step decides it, and only the rest is simulated.

Every step of a loading that starts from planned positions is a question of its own. So judges are
cascaded over steps, not over layouts: a step is asked of one stage after the other until one is
sure, in the order of loading, and the first unstable step ends the loading. What is asked of a
stage is :meth:`Method.steps`; what counts as sure was fitted
(:mod:`steadyload.methods.thresholds`).
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from steadyload.engines.quantities import quantity
from steadyload.layouts.model import Layout
from steadyload.methods.method import (
    STABLE,
    Effort,
    Finding,
    Method,
    RefusedError,
    Status,
    StepJudge,
    Stopwatch,
    Trait,
)
from steadyload.methods.registry import make_method
from steadyload.methods.thresholds import (
    FILE,
    Ladder,
    Stage,
    Thresholds,
    ThresholdsError,
    fingerprint,
    load_thresholds,
)


@dataclass(frozen=True)
class CascadeParameters:
    """Which thresholds a cascade has."""

    budget: float | None = quantity(
        None, "points of accuracy that thresholds may cost; none: the one they come with",
        least=0, most=100,
    )  # fmt: skip
    thresholds: str = quantity("", "file of thresholds; empty: those that come with the package")


@dataclass(frozen=True, slots=True)
class Decision:
    """What became of a step.

    Attributes:
        step: counted from 0.
        stage: spec of the method that decided.
        risk: what it said of the step, on its own scale; not a number where even the last method
            had no opinion.
        unstable: the loading ends here.
    """

    step: int
    stage: str
    risk: float
    unstable: bool


class Cascade(Method):
    """A cascade: every step goes to the cheapest judge that is sure of it, the rest is simulated.

    Stages and thresholds were fitted on labelled layouts, so that all stages before the last cost
    no more than a budget of accuracy. A stage that refuses a layout, or has no opinion of a step,
    leaves it to the next one. Thresholds that were fitted with other weights or parameters than
    there are now are refused.
    """

    title = "Cascade"
    Parameters = CascadeParameters
    needs_engine = True

    @property
    def traits(self) -> frozenset[Trait]:
        """See :attr:`Method.traits`."""
        return frozenset((Trait.STEPWISE, Trait.CENTRES_OF_MASS))

    @cached_property
    def thresholds(self) -> Thresholds:
        """What was fitted for the engine.

        Raises:
            ThresholdsError: nothing was.
        """
        assert self.spec.engine is not None, "make_method asks for an engine"
        file = self.parameters.thresholds
        return load_thresholds(self.spec.engine, Path(file) if file else FILE)

    @cached_property
    def ladder(self) -> Ladder:
        """The stages, and what they hold sure.

        Raises:
            ThresholdsError: nothing was fitted for the engine and the budget.
        """
        fitted, asked = self.thresholds, self.parameters.budget
        budget = fitted.default if asked is None else asked
        if budget not in fitted.ladders:
            allowed = ", ".join(f"{b:g}" for b in fitted.ladders)
            raise ThresholdsError(f"{self.spec}: budget is {budget:g}; allowed: {allowed}")
        return fitted.ladders[budget]

    @cached_property
    def judges(self) -> tuple[Method, ...]:
        """The methods that are asked, in order.

        Raises:
            ThresholdsError: one is not what it was when thresholds were fitted.
            as :attr:`Method.trained` of a stage.
        """
        judges = tuple(make_method(spec) for spec in self.ladder.methods)
        for spec, judge in zip(self.ladder.methods, judges, strict=True):
            if fingerprint(judge) != self.thresholds.made_of.get(spec):
                raise ThresholdsError(
                    f"{self.spec}: its thresholds were fitted with another {spec}, whose weights "
                    "or parameters have changed since; to fit them anew run steadyload cascade fit "
                    f"--engine {self.spec.engine}"
                )
        return judges

    def made_of(self) -> str:
        """See :meth:`Method.made_of`: the ladder, and what its methods are made of."""
        ladder = dataclasses.asdict(self.ladder) | {"found": None}
        own = [[fingerprint(judge), judge.made_of()] for judge in self.judges]
        return hashlib.sha256(json.dumps([ladder, own]).encode()).hexdigest()

    def parts(self) -> Mapping[str, int]:
        """See :meth:`Method.parts`: those of every stage, too."""
        of_stages = {
            f"{part} of {spec}": version
            for spec, judge in zip(self.ladder.methods, self.judges, strict=True)
            for part, version in judge.parts().items()
        }
        return {**super().parts(), **of_stages}

    def numerics(self) -> frozenset[str]:
        """See :meth:`Method.numerics`."""
        return super().numerics().union(*(judge.numerics() for judge in self.judges))

    def classes(self) -> tuple[type, ...]:
        """See :meth:`Method.classes`."""
        of_stages = (each for judge in self.judges for each in judge.classes())
        return tuple(dict.fromkeys((*super().classes(), *of_stages)))

    def prepare(self, item_count: int = 0) -> None:
        """Make every stage ready.

        Raises:
            ThresholdsError: see :attr:`judges`.
            as :meth:`Method.prepare` of a stage.
        """
        for judge in self.judges:
            judge.prepare(item_count)

    def decisions(self, layout: Layout) -> list[Decision]:
        """Who decided which step: all of them, or up to the first that no stage calls stable.

        Raises:
            RefusedError: the last method refuses the layout, and was asked.
        """
        with closing(_Hearing(self.judges, self.ladder.stages, layout, Stopwatch())) as hearing:
            return list(hearing.decide())

    def _judge(self, layout: Layout, watch: Stopwatch) -> Finding:
        with closing(_Hearing(self.judges, self.ladder.stages, layout, watch)) as hearing:
            *_, decision = hearing.decide()
            return hearing.finding(decision)


class _Hearing:
    """One layout before all stages; a stage is brought in when it is needed first."""

    def __init__(
        self, methods: Sequence[Method], stages: Sequence[Stage], layout: Layout, watch: Stopwatch
    ) -> None:
        self._methods, self._layout, self._watch = methods, layout, watch
        self._stages = stages
        self._asked: list[StepJudge | None] = []

    def decide(self) -> Iterator[Decision]:
        """A decision a step, up to the first that is not stable."""
        for step in range(len(self._layout)):
            self._watch.check()
            decision = self._decide(step)
            yield decision
            if decision.unstable or math.isnan(decision.risk):
                return

    def _decide(self, step: int) -> Decision:
        for number, stage in enumerate(self._stages):
            judge = self._judge(number)
            if judge is not None:
                risk = judge.risk(step)
                unstable = stage.unstable(risk)
                if unstable is not None:
                    return Decision(step, stage.method, risk, unstable)
        last = self._judge(len(self._stages))
        assert last is not None
        risk = last.risk(step)
        return Decision(step, str(self._methods[-1].spec), risk, risk > last.brink)

    def _judge(self, number: int) -> StepJudge | None:
        """A stage's judge of this layout; None where the stage refuses it."""
        while len(self._asked) <= number:
            method = self._methods[len(self._asked)]
            try:
                judge = method.steps(self._layout, self._watch)
            except RefusedError:
                if method is self._methods[-1]:
                    raise
                judge = None
            self._asked.append(judge)
        return self._asked[number]

    def finding(self, decision: Decision) -> Finding:
        """What a verdict says after the last decision."""
        asked = [judge for judge in self._asked if judge is not None]
        found = STABLE
        if decision.unstable or math.isnan(decision.risk):
            by = next(
                judge
                for method, judge in zip(self._methods, self._asked, strict=False)
                if str(method.spec) == decision.stage and judge is not None
            )
            found = _spoken(by.finding(decision.step), decision)
        return dataclasses.replace(
            found,
            ignored=tuple(dict.fromkeys(name for judge in asked for name in judge.ignored)),
            emulated=tuple(dict.fromkeys(name for judge in asked for name in judge.emulated)),
            effort=sum((judge.effort for judge in asked), Effort()),
        )

    def close(self) -> None:
        """Give back what stages took."""
        for judge in self._asked:
            if judge is not None:
                judge.close()


def _spoken(finding: Finding, decision: Decision) -> Finding:
    """A stage's finding, with the stage in its reason."""
    if decision.unstable:
        why = finding.reason or f"risk {decision.risk:.4g}"
        reason = f"{decision.stage}: {why}"
        return dataclasses.replace(finding, failing_step=decision.step, reason=reason)
    status = Status.ERROR if finding.status is Status.DONE else finding.status
    why = finding.reason or f"no stage has an opinion of step {decision.step}"
    return Finding(status=status, reason=why)
