"""Movements of a layout's items at every step of its loading, whatever the thresholds.

One simulation answers for all criteria, thresholds up to :data:`LIMIT_T` and :data:`LIMIT_R`, and
times that end at a sample: each step is simulated until something is beyond these limits, and the
loading goes on past the step that a label names. Only steps judged afresh can be read this way
(``between_steps=reseat``).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from steadyload.engines.world import Box, EngineError, FloatArray, Poses
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.question import Question
from steadyload.methods.contract.method import Finding, Status, Stopwatch
from steadyload.methods.simulation.criteria import Criterion, Examiner, Indices
from steadyload.methods.simulation.loading import Loading
from steadyload.methods.simulation.scene import CM
from steadyload.methods.simulation.simulation import Simulation
from steadyload.methods.simulation.simulation_parameters import BetweenSteps, Scope

VERSION = 1
"""Of traces: raised when a layout has another one."""

LIMIT_T = 20.0
"""A step is simulated no further once a corner has moved by more along one axis [cm]."""

LIMIT_R = 20.0
"""A step is simulated no further once an item has turned by more about an axis [degrees]."""


class UndecidedError(ValueError):
    """A trace ends before it shows what was requested."""


@dataclass(frozen=True, slots=True)
class Trace:
    """Movements by step and sample, arrays of shape (steps, samples).

    A value is the largest over all items placed by then. A step that went beyond the limits at one
    of the samples that count ends the loading; its remaining samples repeat the last one that was
    simulated. A step during which the simulation itself failed is left out.

    Attributes:
        item_count: of the layout.
        status: ``done``, or why the loading ended without a verdict.
        reason: of that, one sentence.
        corner: how far a left-bottom-back corner moved along any one axis [cm].
        centre: how far a geometric centre moved [cm].
        angle: how far an item turned about any one axis [degrees].
        moved: the item with the largest corner shift or angle, each in units of its limit.
    """

    item_count: int
    status: Status
    reason: str
    corner: FloatArray
    centre: FloatArray
    angle: FloatArray
    moved: np.ndarray

    def failing_step(
        self, criterion: Criterion, eps_t: float, eps_r: float, samples: int
    ) -> int | None:
        """The first step at which something moved too far; None for a stable layout.

        Args:
            criterion: see :class:`steadyload.methods.simulation.criteria.Criterion`.
            eps_t: displacement that counts as unstable [cm], up to :data:`LIMIT_T`.
            eps_r: angle that counts as unstable [degrees], up to :data:`LIMIT_R`.
            samples: look at the first so many samples.

        Raises:
            ValueError: a threshold beyond the limits, or more samples than there are.
            UndecidedError: nothing moved too far by then, and later steps were not simulated.
        """
        if eps_t > LIMIT_T or eps_r > LIMIT_R:
            raise ValueError(
                f"thresholds are {eps_t:g} cm and {eps_r:g} degrees; allowed: up to {LIMIT_T:g} cm "
                f"and {LIMIT_R:g} degrees"
            )
        if not 1 <= samples <= self.corner.shape[1]:
            raise ValueError(f"samples is {samples}; allowed: 1 to {self.corner.shape[1]}")
        if criterion is Criterion.ADAMS:
            shift, angle = self.corner[:, samples - 1], self.angle[:, samples - 1]
        else:
            shift, angle = self.centre[:, :samples].max(axis=1), self.angle[:, :samples].max(axis=1)
        failed = np.flatnonzero((shift > eps_t) | (angle > eps_r))
        if len(failed):
            return int(failed[0])
        if len(self.corner) < self.item_count:
            raise UndecidedError(f"only {len(self.corner)} of {self.item_count} steps are known")
        return None


def trace_loading(
    layout: Layout, method: Simulation, *, t_max: float, samples: int, ending: int | None = None
) -> Trace:
    """Simulate a loading step by step, as ``method`` does, and keep what moved.

    Args:
        layout: any layout.
        method: a simulation that reseats; its thresholds, times and early exit play no part.
        t_max: simulated time a placement [s].
        samples: looks at the items a placement, evenly spaced, the last at its end.
        ending: what is beyond the limits at one of the first so many samples ends the loading; by
            default at any. Whoever asks what happens by an earlier sample must not be cut off by a
            later one.

    Raises:
        ValueError: the method carries the state over.
        RefusedError: see :class:`steadyload.methods.simulation.simulation.Loading`.
    """
    parameters = method.parameters
    if parameters.between_steps is not BetweenSteps.RESEAT:
        raise ValueError(f"{method.spec}: carries the state over; allowed: between_steps=reseat")
    assert method.spec.engine is not None, "a simulation has an engine"
    # What chooses its scope simulates a step more than once, or stops at rest; a trace follows
    # everything to the end.
    own_choice = parameters.scope in (Scope.WIDENING, Scope.MOVING)
    scope = Scope.ALL if own_choice else parameters.scope
    own = dataclasses.replace(
        parameters, t_max=t_max, samples=samples, criterion=Criterion.PAPER, early_exit=0.0,
        rest_speed=0.0, early_stop=0.0, scope=scope, question=Question.WITHIN,
    )  # fmt: skip
    loading = Loading(layout, method.spec.engine, own, Stopwatch(), _Recorder)
    recorder = loading.examiner
    assert isinstance(recorder, _Recorder)
    recorder.ending = samples if ending is None else ending
    try:
        finding = loading.load()
    except EngineError as error:
        finding = Finding(status=Status.ERROR, reason=str(error))
    if finding.status is not Status.DONE and recorder.seen:
        last = max(recorder.seen)
        if len(recorder.seen[last]) < samples:
            del recorder.seen[last]
    seen = [_padded(step, samples) for step in recorder.seen.values()]
    values = np.array(seen, dtype=float).reshape(len(seen), samples, 4)
    corner, centre, angle, moved = np.moveaxis(values, 2, 0)
    return Trace(
        item_count=len(layout),
        status=finding.status,
        reason=finding.reason if finding.status is not Status.DONE else "",
        corner=corner,
        centre=centre,
        angle=angle,
        moved=moved.astype(int),
    )


_Sample = tuple[float, float, float, int]


class _Recorder(Examiner):
    """Records movements, and reports only those beyond the limits."""

    def __init__(
        self, items: Sequence[Box], criterion: Criterion, eps_t: float, eps_r: float
    ) -> None:
        super().__init__(items, criterion, eps_t, eps_r)
        self.seen: dict[int, list[_Sample]] = {}
        self.ending = 0

    def examine(
        self, step: int, poses: Poses, items: Indices, excess: float = 1.0
    ) -> Finding | None:
        moved = self.movements(poses, items)
        if moved is None:
            return super().examine(step, poses, items, excess)
        corners, angles = moved
        beyond = np.maximum(corners / LIMIT_T, angles / LIMIT_R)
        worst = int(np.arange(len(self._planned))[items][int(beyond.argmax())])
        centre = float(self.centre_shifts(poses, items).max() / CM)
        sample = (float(corners.max()), centre, float(angles.max()), worst)
        samples = self.seen.setdefault(step, [])
        samples.append(sample)
        if beyond.max() > 1.0 and len(samples) <= self.ending:
            return Finding(failing_step=step, moved_item=worst)
        return None


def _padded(samples: list[_Sample], count: int) -> list[_Sample]:
    return samples + samples[-1:] * (count - len(samples))
