"""Both questions about single steps of a loading, answered by one simulation a step."""

from __future__ import annotations

import dataclasses
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from steadyload.engines.world import Box, EngineError, FloatArray, Poses
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.question import Question
from steadyload.methods.contract.method import Finding, Status, Stopwatch
from steadyload.methods.simulation.criteria import Criterion, Examiner, Indices
from steadyload.methods.simulation.loading import Loading
from steadyload.methods.simulation.simulation import Simulation
from steadyload.methods.simulation.simulation_parameters import OF_STANDS, BetweenSteps, Scope

VERSION = 1
"""Of the answers: raised when they come out differently."""

WITHIN_SAMPLES = 10
"""Looks at a placement that the question ``within`` has: the last, after 0.3 s, decides."""

NO_RETURN = 2.0
"""Multiple of a threshold from which nothing comes back within these looks, as for a label."""

CALM_LOOKS = 10
"""Rest is found by comparing movements over so many looks: 0.3 s."""

CALM = 1e-4
"""Items that move by no more of a threshold in that time are at rest: 0.01 mm, 0.001 degrees."""

CREEP = 0.01
"""Items that creep by no more of a threshold, and not faster than in the time before, are at rest,
too, where going on until 3 s would not take them past a threshold. Friction is regularised in all
engines: boxes that lean on each other creep by some mm a second. What tips moves faster and faster:
in 0.3 s, a cube of 1 m past its point of balance by three times as much as in the 0.3 s before."""

_FASTER = 1.5

JITTER = 1e-3
"""Items that crept by no more of a threshold may be faster or slower than in the time before."""


@dataclass(frozen=True, slots=True)
class StepAnswer:
    """Answers about one step.

    Attributes:
        status: ``done``, or how the simulation ended without an answer.
        reason: of that, one sentence.
        fails_within: something had moved too far after 0.3 s.
        fails_standing: something moved too far by the time all rested, or after 3 s; None where
            that was not asked, or where something still moved then.
        item: the one furthest beyond its thresholds at any look, or closest to them.
        beyond: how far that got, in units of the threshold.
        corner_last, corner_most: how far a corner had moved along an axis after 0.3 s, and by then
            [cm].
        angle_last, angle_most: likewise the angle about an axis [degrees].
    """

    status: Status
    reason: str
    fails_within: bool
    fails_standing: bool | None
    item: int
    beyond: float
    corner_last: float
    corner_most: float
    angle_last: float
    angle_most: float


class StepAnswers:
    """Answers both questions about steps of one layout, each step from the planned positions.

    A step is simulated until both are answered: 0.3 s, and on until all items rest, at most 3 s.

    Args:
        layout: what is loaded.
        method: a simulation that reseats, with criterion ``adams``; its times, its scope and when
            it ends early play no part.

    Raises:
        ValueError: the method carries the state over, or has another criterion.
        RefusedError: see :class:`steadyload.methods.simulation.loading.Loading`.
    """

    def __init__(self, layout: Layout, method: Simulation) -> None:
        p = method.parameters
        if p.between_steps is not BetweenSteps.RESEAT or p.criterion is not Criterion.ADAMS:
            raise ValueError(f"{method.spec}: allowed: between_steps=reseat and criterion=adams")
        own = dataclasses.replace(
            p, **OF_STANDS, question=Question.STANDS, rest_speed=0.0, early_stop=0.0,
            scope=Scope.ALL,
        )  # fmt: skip
        self._loading = Loading(layout, method.engine, own, Stopwatch(), _Watch)
        watch = self._loading.examiner
        assert isinstance(watch, _Watch)
        self._watch = watch

    def ask(self, step: int, *, standing: bool = True, patient: bool = False) -> StepAnswer:
        """Answers about a step.

        Args:
            step: above that of the call before.
            standing: ask whether the load stands, too.
            patient: simulate all 3 s for that, also where everything seems to rest: what is within
                a hair of its point of balance begins to tip so slowly that it does.
        """
        self._watch.begin(standing, patient)
        try:
            finding = self._loading.place(step)
        except EngineError as error:
            finding = Finding(status=Status.ERROR, reason=str(error))
        return self._watch.answer(finding)

    def close(self) -> None:
        """Release resources. Closing twice is allowed."""
        self._loading.close()


class _Watch(Examiner):
    """Follows a placement, and ends it as soon as both questions are answered."""

    def __init__(
        self, items: Sequence[Box], criterion: Criterion, eps_t: float, eps_r: float
    ) -> None:
        super().__init__(items, criterion, eps_t, eps_r)
        self.begin(True, False)

    def begin(self, standing: bool, patient: bool) -> None:
        """Begin a placement; see :meth:`StepAnswers.ask`."""
        self._standing, self._patient = standing, patient
        self._within: bool | None = None
        self._looks: list[tuple[float, float]] = []
        self._worst = (0.0, 0)
        self._before: deque[FloatArray] = deque(maxlen=2 * CALM_LOOKS)

    def examine(
        self, step: int, poses: Poses, items: Indices, excess: float = 1.0
    ) -> Finding | None:
        """A finding once there is no more to see, None before."""
        moved = self.movements(poses, items)
        if moved is None:
            return super().examine(step, poses, items, excess)
        corners, angles = moved
        self._looks.append((float(corners.max()), float(angles.max())))
        beyond = np.maximum(corners / self._eps_t, angles / self._eps_r)
        far, item = float(beyond.max()), int(np.arange(len(self._planned))[items][beyond.argmax()])
        self._worst = max(self._worst, (far, item))
        count = len(self._looks)
        if count == WITHIN_SAMPLES or far > NO_RETURN:
            self._within = far > 1.0 if self._within is None else self._within
        rests = self._rests(np.stack((corners / self._eps_t, angles / self._eps_r)))
        if self._within is None:
            return None
        decided = not self._standing or self._worst[0] > 1.0
        return Finding(failing_step=step) if decided or (rests and not self._patient) else None

    def _rests(self, now: FloatArray) -> bool:
        """Whether nothing moves any more but by creeping.

        Args:
            now: movements of the items, in units of their thresholds, shape (2, n).
        """
        if not self._before:
            self._before.append(np.zeros_like(now))
        seen, self._before = self._before, deque([*self._before, now], maxlen=2 * CALM_LOOKS)
        if len(seen) < CALM_LOOKS:
            return False
        moved = np.abs(now - seen[-CALM_LOOKS])
        still = moved <= CALM
        if len(seen) == 2 * CALM_LOOKS:
            before = np.abs(seen[-CALM_LOOKS] - seen[0])
            still |= (moved <= CREEP) & (moved <= np.maximum(_FASTER * before, JITTER))
        left = OF_STANDS["samples"] - len(self._looks)
        on = self._worst[0] + float(moved.max()) * left / CALM_LOOKS
        return bool(still.all() and on < 1.0)

    def answer(self, finding: Finding | None) -> StepAnswer:
        """Answers about the placement, which ended with a finding or after its full time."""
        failed = finding is not None and finding.status not in (Status.DONE, Status.UNSETTLED)
        far, item = self._worst
        standing: bool | None = far > 1.0
        if not self._standing or (finding is not None and finding.status is Status.UNSETTLED):
            standing = None
        looks = np.array(self._looks[:WITHIN_SAMPLES] or [(np.nan, np.nan)])
        return StepAnswer(
            status=finding.status if failed and finding is not None else Status.DONE,
            reason=finding.reason if failed and finding is not None else "",
            fails_within=bool(self._within),
            fails_standing=standing,
            item=item,
            beyond=far,
            corner_last=float(looks[-1, 0]),
            corner_most=float(looks[:, 0].max()),
            angle_last=float(looks[-1, 1]),
            angle_most=float(looks[:, 1].max()),
        )
