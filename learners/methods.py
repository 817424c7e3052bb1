"""The methods ``lstm_1`` and ``lstm_e``: trained networks that judge; torch is not needed."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from steadyload.core.constants import VERSION as CORE
from steadyload.engines.quantities import quantity
from steadyload.layouts.model.growing import GrowingLayout
from steadyload.layouts.model.layout import Arrangement, Layout
from steadyload.layouts.model.question import Question
from steadyload.learners import LearnerError
from steadyload.learners.features import VERSION as FEATURES
from steadyload.learners.features import Array32, features
from steadyload.learners.inference import VERSION as INFERENCE
from steadyload.learners.inference import Memory
from steadyload.learners.scoring import THRESHOLD
from steadyload.learners.weights import Weights, load_weights
from steadyload.methods.contract.declared import (
    EVERY_LAYOUT,
    LABEL_LIMITS,
    LayoutRange,
    MovementLimits,
    Trait,
)
from steadyload.methods.contract.method import (
    STABLE,
    Finding,
    Loader,
    Method,
    RefusedError,
    Status,
    StepScorer,
    Stopwatch,
    Verdict,
)


class Outside(StrEnum):
    """Treatment of a layout outside the ranges that the networks were trained on.

    ``refuse``: it is not judged. ``accept``: it is, and the verdict says so.
    """

    REFUSE = "refuse"
    ACCEPT = "accept"


@dataclass(frozen=True)
class LearnedParameters:
    """Parameters of a learned method."""

    weights: str = quantity("lstm_1", "name of shipped weights, or a folder of others")
    threshold: float = quantity(
        THRESHOLD, "probability above which a step is unstable", least=0.0, most=1.0
    )
    outside: Outside = quantity(Outside.REFUSE, "a layout outside what was trained on")
    batch: int = quantity(64, "layouts at once where many are judged", least=1, most=65536)
    question: Question = quantity(
        Question.WITHIN, "what is asked of a placement, and what networks were trained for",
        later=True,
    )  # fmt: skip


@dataclass(frozen=True)
class EnsembleParameters(LearnedParameters):
    """Parameters of an ensemble of networks."""

    weights: str = quantity("lstm_e", "name of shipped weights, or a folder of others")


class LearnedMethod(Method):
    """LSTM_1: a trained network gives every step a probability of being unstable (Section 4.3).

    The failing step is the first one whose probability exceeds ``threshold``. Layouts outside what
    the network was trained on (:func:`steadyload.learners.ranges.quantities_of`) are refused: it
    would give a number there, too, of unknown reliability.
    """

    title = "LSTM_1"
    Parameters: ClassVar[type[Any]] = LearnedParameters
    built_on: ClassVar[Mapping[str, int]] = {
        "core": CORE, "features": FEATURES, "inference": INFERENCE
    }  # fmt: skip
    members: ClassVar[int | None] = 1
    """Number of networks of the weights that judge, the first ones; None for all."""

    @classmethod
    def implied_by(cls, values: Mapping[str, Any]) -> Mapping[str, Any]:
        """See :meth:`Method.implied_by`: every question has networks of its own."""
        question = values.get("question", Question.WITHIN)
        usual = cls.Parameters().weights
        return {} if question == Question.WITHIN else {"weights": f"{usual}-{question}"}

    @property
    def traits(self) -> frozenset[Trait]:
        """See :attr:`Method.traits`."""
        return frozenset((Trait.STEPWISE, Trait.CENTRES_OF_MASS, Trait.LEARNED))

    @property
    def layout_range(self) -> LayoutRange:
        """See :attr:`Method.layout_range`: what the networks were trained on.

        Raises:
            LearnerError: see :attr:`weights`.
        """
        if self.parameters.outside is Outside.ACCEPT:
            return EVERY_LAYOUT
        return self.weights.ranges.of_layouts()

    @property
    def movement_limits(self) -> MovementLimits:
        """See :attr:`Method.movement_limits`: those of the labels that networks were trained on."""
        return LABEL_LIMITS[self.parameters.question]

    @cached_property
    def weights(self) -> Weights:
        """The trained weights.

        Raises:
            LearnerError: there are no such weights, or they were trained for another question; says
                which command makes some.
        """
        loaded = load_weights(self.parameters.weights)
        learnt = loaded.manifest.get("question", str(Question.WITHIN))
        if learnt != self.parameters.question:
            raise LearnerError(
                f"weights {self.parameters.weights!r} were trained for the question {learnt}, not "
                f"{self.parameters.question}; state question={learnt}, or other weights"
            )
        return replace(loaded, networks=loaded.networks[: self.members])

    @property
    def trained(self) -> str:
        """See :attr:`Method.trained`."""
        return self.weights.digest

    def made_of(self) -> str:
        """See :meth:`Method.made_of`: the weights."""
        return self.trained

    def prepare(self, item_count: int = 0) -> None:
        """Read the weights.

        Raises:
            LearnerError: see :attr:`weights`.
        """
        _ = self.weights

    def probabilities(self, layout: Layout) -> Array32:
        """That a step is unstable, for every step, shape (J,): the members' mean (Eq. 8).

        Whether the layout is inside the training ranges is not checked.
        """
        return self.go_on(layout, self.start())[0]

    def start(self) -> list[Memory]:
        """States of the members before the first step."""
        return [network.start() for network in self.weights.networks]

    def go_on(
        self, layout: Arrangement, memories: Sequence[Memory]
    ) -> tuple[Array32, list[Memory]]:
        """As :meth:`probabilities`, for the steps that the members have not seen.

        Args:
            layout: with the steps that they have.
            memories: of the members; they stay as they are.

        Returns:
            Probabilities of the other steps, and the members' states then.
        """
        rows = features(layout, self.weights.kind)
        found: list[Array32] = []
        after: list[Memory] = []
        for network, memory in zip(self.weights.networks, memories, strict=True):
            probabilities, remembered = network.go_on(rows, memory)
            found.append(probabilities)
            after.append(remembered)
        # The mean over one network is its own probability, but takes longer.
        mean: Array32 = found[0]
        if len(found) > 1:
            mean = np.mean(found, axis=0, dtype=np.float32)
        return mean, after

    def probabilities_of_many(self, layouts: Iterable[Layout]) -> list[Array32]:
        """As :meth:`probabilities`, in batches; layouts of about one length go together."""
        rows = [features(layout, self.weights.kind) for layout in layouts]
        order = sorted(range(len(rows)), key=lambda k: len(rows[k]))
        found: list[Array32] = [rows[k][:, 0] for k in range(len(rows))]
        size = self.parameters.batch
        for start in range(0, len(order), size):
            chosen = order[start : start + size]
            padded = np.zeros((len(chosen), len(rows[chosen[-1]]), rows[0].shape[1]), np.float32)
            for place, k in enumerate(chosen):
                padded[place, : len(rows[k])] = rows[k]
            networks = self.weights.networks
            mean = np.mean([n.probabilities_of_many(padded) for n in networks], axis=0)
            for place, k in enumerate(chosen):
                found[k] = mean[place, : len(rows[k])]
        return found

    def judge_many(
        self, layouts: Iterable[Layout], *, timeout: float | None = None
    ) -> list[Verdict]:
        """See :meth:`Method.judge_many`; the time of a batch is shared among its layouts.

        Args:
            layouts: any.
            timeout: not looked at: a layout takes some microseconds.
        """
        watch = Stopwatch()
        given = list(layouts)
        findings = [self._outside(layout) for layout in given]
        known = [k for k, finding in enumerate(findings) if finding.status is Status.DONE]
        for k, found in zip(
            known, self.probabilities_of_many(given[k] for k in known), strict=True
        ):
            findings[k] = self._finding(found, findings[k].reason)
        cpu, wall = (spent.shared(len(given)) for spent in watch.stop())
        return [
            Verdict(
                item_count=len(layout),
                status=finding.status,
                failing_step=finding.failing_step,
                reason=finding.reason,
                cpu=cpu,
                wall=wall,
            )
            for layout, finding in zip(given, findings, strict=True)
        ]

    def steps(self, layout: Layout, watch: Stopwatch) -> StepScorer:
        """See :meth:`Method.steps`: the score is the probability that the step is unstable.

        There is no step score from the first item on that lies outside what the networks were
        trained on.
        """
        known = len(layout)
        if self.parameters.outside is Outside.REFUSE:
            known = self.weights.ranges.steps_inside(layout)
        return _LikelySteps(self.probabilities(layout)[:known], self.parameters.threshold)

    def begin(self, layout: GrowingLayout) -> Loader:
        """A loader that carries the states of the networks; features are computed anew."""
        return _LearnedLoader(self, layout)

    def finding_from(
        self, layout: Arrangement, memories: Sequence[Memory]
    ) -> tuple[Finding, list[Memory]]:
        """The finding on the steps that the members have not seen; see :meth:`go_on`.

        Raises:
            RefusedError: the layout is outside the training ranges.
        """
        outside = self._outside(layout)
        if outside.status is not Status.DONE:
            raise RefusedError(outside.reason)
        found, after = self.go_on(layout, memories)
        return self._finding(found, outside.reason, first=len(layout) - len(found)), after

    def _judge(self, layout: Layout, watch: Stopwatch) -> Finding:
        return self.finding_from(layout, self.start())[0]

    def _outside(self, layout: Arrangement) -> Finding:
        """Finding on a layout from the training ranges alone, before it is judged."""
        sentence = self.weights.ranges.outside(layout)
        if not sentence:
            return STABLE
        if self.parameters.outside is Outside.ACCEPT:
            return Finding(reason=f"outside what was trained on: {sentence}")
        return Finding(
            status=Status.REFUSED, reason=f"{sentence}; with outside=accept it is judged"
        )

    def _finding(self, probabilities: Array32, said: str, first: int = 0) -> Finding:
        """Finding that follows from the probabilities of the steps from ``first`` on."""
        if not np.isfinite(probabilities).all():
            # Not a number is above no threshold, and would pass for stable.
            reason = "the network says no number of a step: its weights are not fit to judge by"
            return Finding(status=Status.ERROR, reason=reason)
        fails = probabilities > self.parameters.threshold
        if not fails.any():
            return Finding(reason=said)
        at = int(fails.argmax())
        step, likely = first + at, probabilities[at]
        reason = f"item {step} makes the layout unstable with probability {likely:.2f}"
        return Finding(failing_step=step, reason=f"{reason}; {said}" if said else reason)


class _LearnedLoader(Loader):
    """Keeps the states of the networks after every placement."""

    def __init__(self, method: LearnedMethod, layout: GrowingLayout) -> None:
        super().__init__(layout)
        self._method = method
        self._memories = [method.start()]

    def place(self, watch: Stopwatch) -> Finding:
        finding, memories = self._method.finding_from(self.layout, self._memories[-1])
        self._memories.append(memories)
        return finding

    def go_back(self, count: int) -> None:
        del self._memories[count + 1 :]

    def fork(self, layout: GrowingLayout) -> _LearnedLoader:
        other = _LearnedLoader(self._method, layout)
        other._memories = list(self._memories)
        return other


class _LikelySteps(StepScorer):
    def __init__(self, probabilities: Array32, threshold: float) -> None:
        self._risks: list[float] = probabilities.tolist()
        self.decision_threshold = threshold

    def step_score(self, step: int) -> float:
        return self._risks[step] if step < len(self._risks) else math.nan


class LearnedEnsemble(LearnedMethod):
    """LSTM_e: the mean of the probabilities of several trained networks (Eq. 8)."""

    title = "LSTM_e"
    Parameters = EnsembleParameters
    members = None
