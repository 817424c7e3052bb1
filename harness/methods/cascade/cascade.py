"""A cascade: cheap methods decide the steps beyond their thresholds, and the rest is simulated.

Every step of a loading that starts from planned positions can be judged by itself. So methods are
cascaded over steps, not over layouts: in the order of loading, a step is scored by one stage after
the other until one accepts or rejects it, and the first unstable step ends the loading. Stages give
step scores by :meth:`Method.steps`; their accept and reject thresholds were fitted
(:mod:`steadyload.methods.cascade.thresholds`).
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
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.question import Question
from steadyload.methods.cascade.thresholds import (
    FILE,
    Ladder,
    Stage,
    Thresholds,
    ThresholdsError,
    fingerprint,
    fit_command,
    load_thresholds,
)
from steadyload.methods.contract.declared import LABEL_LIMITS, LayoutRange, MovementLimits, Trait
from steadyload.methods.contract.method import (
    STABLE,
    Effort,
    Finding,
    Method,
    RefusedError,
    Status,
    StepScorer,
    Stopwatch,
)
from steadyload.methods.registry import make_method


@dataclass(frozen=True)
class CascadeParameters:
    """Parameters of a cascade: its error budget, its thresholds' file, and its question."""

    budget: float | None = quantity(
        None, "points of accuracy that thresholds may cost; none: the one they come with",
        least=0, most=100,
    )  # fmt: skip
    thresholds: str = quantity("", "file of thresholds; empty: those that come with the package")
    question: Question = quantity(
        Question.WITHIN, "what is asked of a placement, and what thresholds were fitted for",
        later=True,
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Decision:
    """The decision on one step.

    Attributes:
        step: counted from 0.
        stage: spec of the method that decided.
        step_score: of that method, on its own scale; not a number where even the last method has
            none.
        unstable: the loading ends here.
    """

    step: int
    stage: str
    step_score: float
    unstable: bool


class Cascade(Method):
    """A cascade: every step goes to the cheapest method that can decide it, the rest is simulated.

    Stages and thresholds were fitted on labelled layouts, so that all stages before the last lose
    no more accuracy than an error budget. A stage that refuses a layout, or has no score of a step,
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

    @property
    def layout_range(self) -> LayoutRange:
        """See :attr:`Method.layout_range`: that of the last stage, which judges the rest."""
        return self.stage_methods[-1].layout_range

    @property
    def movement_limits(self) -> MovementLimits:
        """See :attr:`Method.movement_limits`: those of the labels it was fitted to."""
        return LABEL_LIMITS[self.parameters.question]

    @cached_property
    def thresholds(self) -> Thresholds:
        """The thresholds that were fitted for the engine.

        Raises:
            ThresholdsError: nothing was.
        """
        assert self.spec.engine is not None, "make_method asks for an engine"
        file = self.parameters.thresholds
        question = self.parameters.question
        return load_thresholds(self.spec.engine, Path(file) if file else FILE, question)

    @cached_property
    def ladder(self) -> Ladder:
        """The stages, with their accept and reject thresholds.

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
    def stage_methods(self) -> tuple[Method, ...]:
        """The methods of all stages, in order.

        Raises:
            ThresholdsError: one has changed since thresholds were fitted.
            UserError: as :attr:`Method.trained` of a stage.
        """
        methods = tuple(make_method(spec) for spec in self.ladder.methods)
        for spec, method in zip(self.ladder.methods, methods, strict=True):
            if fingerprint(method) != self.thresholds.made_of.get(spec):
                raise ThresholdsError(
                    f"{self.spec}: its thresholds were fitted with another {spec}, whose weights "
                    "or parameters have changed since; to fit them anew run "
                    f"{fit_command(self.spec.engine or '', self.parameters.question)}"
                )
        return methods

    def made_of(self) -> str:
        """See :meth:`Method.made_of`: the ladder, and the hashes of its methods."""
        ladder = self.ladder.stored() | {"found": None}
        own = [[fingerprint(method), method.made_of()] for method in self.stage_methods]
        return hashlib.sha256(json.dumps([ladder, own]).encode()).hexdigest()

    def parts(self) -> Mapping[str, int]:
        """See :meth:`Method.parts`: those of every stage, too."""
        of_stages = {
            f"{part} of {spec}": version
            for spec, judge in zip(self.ladder.methods, self.stage_methods, strict=True)
            for part, version in judge.parts().items()
        }
        return {**super().parts(), **of_stages}

    def numerics(self) -> frozenset[str]:
        """See :meth:`Method.numerics`."""
        return super().numerics().union(*(judge.numerics() for judge in self.stage_methods))

    def classes(self) -> tuple[type, ...]:
        """See :meth:`Method.classes`."""
        of_stages = (each for judge in self.stage_methods for each in judge.classes())
        return tuple(dict.fromkeys((*super().classes(), *of_stages)))

    def prepare(self, item_count: int = 0) -> None:
        """Make every stage ready.

        Raises:
            ThresholdsError: see :attr:`stage_methods`.
            UserError: as :meth:`Method.prepare` of a stage.
        """
        for method in self.stage_methods:
            method.prepare(item_count)

    def decisions(self, layout: Layout) -> list[Decision]:
        """The decision on every step, up to the first one that is not called stable.

        Raises:
            RefusedError: the last method was needed, and refuses the layout.
        """
        with closing(
            _LayoutRun(self.stage_methods, self.ladder.stages, layout, Stopwatch())
        ) as run:
            return list(run.decide())

    def _judge(self, layout: Layout, watch: Stopwatch) -> Finding:
        with closing(_LayoutRun(self.stage_methods, self.ladder.stages, layout, watch)) as run:
            *_, decision = run.decide()
            return run.finding(decision)


class _LayoutRun:
    """Decisions of all stages on one layout; a stage is set up when it is first needed."""

    def __init__(
        self, methods: Sequence[Method], stages: Sequence[Stage], layout: Layout, watch: Stopwatch
    ) -> None:
        self._methods, self._layout, self._watch = methods, layout, watch
        self._stages = stages
        self._scorers: dict[int, StepScorer | None] = {}

    def decide(self) -> Iterator[Decision]:
        """A decision a step, up to the first that is not stable."""
        for step in range(len(self._layout)):
            self._watch.check()
            decision = self._decide(step)
            yield decision
            if decision.unstable or math.isnan(decision.step_score):
                return

    def _decide(self, step: int) -> Decision:
        for number, stage in enumerate(self._stages):
            if not stage.scores(step):
                continue
            scorer = self._scorer(number)
            if scorer is not None:
                score = scorer.step_score(step)
                unstable = stage.unstable(step, score)
                if unstable is not None:
                    return Decision(step, stage.method, score, unstable)
        last = self._scorer(len(self._stages))
        assert last is not None
        score = last.step_score(step)
        return Decision(step, str(self._methods[-1].spec), score, score > last.decision_threshold)

    def _scorer(self, number: int) -> StepScorer | None:
        """A stage's scorer of this layout; None where the stage refuses it."""
        if number not in self._scorers:
            method = self._methods[number]
            try:
                self._scorers[number] = method.steps(self._layout, self._watch)
            except RefusedError:
                if method is self._methods[-1]:
                    raise
                self._scorers[number] = None
        return self._scorers[number]

    def finding(self, decision: Decision) -> Finding:
        """The finding of the verdict, after the last decision."""
        opened = dict(sorted(self._scorers.items()))
        scorers = [scorer for scorer in opened.values() if scorer is not None]
        found = STABLE
        if decision.unstable or math.isnan(decision.step_score):
            by = next(
                scorer
                for number, scorer in opened.items()
                if str(self._methods[number].spec) == decision.stage and scorer is not None
            )
            found = _spoken(by.finding(decision.step), decision)
        return dataclasses.replace(
            found,
            ignored=tuple(dict.fromkeys(name for scorer in scorers for name in scorer.ignored)),
            emulated=tuple(dict.fromkeys(name for scorer in scorers for name in scorer.emulated)),
            effort=sum((scorer.effort for scorer in scorers), Effort()),
        )

    def close(self) -> None:
        """Release resources of all stages."""
        for scorer in self._scorers.values():
            if scorer is not None:
                scorer.close()


def _spoken(finding: Finding, decision: Decision) -> Finding:
    """A stage's finding, with the stage in its reason."""
    if decision.unstable:
        why = finding.reason or f"risk {decision.step_score:.4g}"
        reason = f"{decision.stage}: {why}"
        return dataclasses.replace(
            finding, failing_step=decision.step, reason=reason, stage=decision.stage
        )
    status = Status.ERROR if finding.status is Status.DONE else finding.status
    why = finding.reason or f"no stage has an opinion of step {decision.step}"
    return Finding(status=status, reason=why)
