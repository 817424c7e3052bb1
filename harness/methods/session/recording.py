"""Recording of a judgement: the poses of all items, step by step, for display.

A recording runs the loading of a simulation once more, looks at the items more often, and goes on
with the step that fails until its time is up. Neither changes what the simulation does: reading
never advances time, and a world's clock counts substeps exactly however they are asked for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from steadyload.engines.world import EngineError, FixedStepWorld, FloatArray, Poses
from steadyload.errors import UserError
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.naming import with_ids
from steadyload.methods.cascade.cascade import Cascade
from steadyload.methods.contract.method import Finding, Method, Status, Stopwatch, Verdict
from steadyload.methods.simulation.criteria import Indices
from steadyload.methods.simulation.loading import Loading
from steadyload.methods.simulation.placements import NOTHING
from steadyload.methods.simulation.scene import in_layout
from steadyload.methods.simulation.simulation import Simulation
from steadyload.methods.simulation.simulation_parameters import BetweenSteps, SimulationParameters
from steadyload.statics.movement import Movement

_FRAMES_A_SECOND = 80
_FRAMES = (20, 60)
"""Least and most looks at a placement, where its samples allow it."""


class RecordingError(UserError):
    """There is nothing to show, or an engine did not repeat its verdict."""


@dataclass(frozen=True, slots=True)
class RecordedStep:
    """One placement: the motion of the items placed so far.

    Attributes:
        times: since the placement [s], shape (frames,); empty where nothing was simulated.
        poses: centres [cm] and quaternions w, x, y, z in the layout's axes (y up), shapes
            (frames, step + 1, 3) and (frames, step + 1, 4). What did not take part is as planned.
        most_moved: by frame, the item with the largest movement as the verdict measures it.
        judged: so many frames lie before the verdict or at it; later ones show what follows.
    """

    times: FloatArray
    poses: Poses
    most_moved: tuple[Movement, ...]
    judged: int


@dataclass(frozen=True, slots=True)
class Recording:
    """A judgement that can be shown.

    Attributes:
        method: spec string.
        verdict: what :meth:`Method.judge` said, with the time it took; the recording's own work is
            not in it.
        planned: centres of all items as the method was given them [cm], shape (J, 3).
        sizes: of all items as the method was given them [cm], shape (J, 3).
        simulates: the method moves items; False: it only looks at the plan.
        steps: up to the last that was simulated.
        reseats: every step begins with all items at their planned poses.
        headline: the answer in a few words where it is another one than the verdict's, such as
            what the complete load does on the road; the last step shows that.
        crushed: the moved item is a box that bears more than it may.
    """

    method: str
    verdict: Verdict
    planned: FloatArray
    sizes: FloatArray
    simulates: bool
    steps: tuple[RecordedStep, ...]
    reseats: bool
    headline: str = ""
    crushed: bool = False


def record_loading(layout: Layout, method: Method) -> Recording:
    """Judge a layout, and record what a simulation does with it.

    Args:
        layout: any layout.
        method: any method. Of a cascade the failing step alone is recorded; a method that
            simulates nothing has no steps.

    Raises:
        RecordingError: the method refuses the layout, or the engine failed elsewhere the second
            time.
    """
    verdict = method.judge(layout)
    if verdict.status is Status.REFUSED:
        reason = with_ids(verdict.reason, layout.items)
        raise RecordingError(f"{method.spec} refuses layout {layout.name!r}: {reason}")
    if not isinstance(method, Simulation):
        shown_by = simulation_of(method)
        if shown_by is None or verdict.failing_step is None:
            return record_plan(layout, str(method.spec), verdict)
        return record_failure(layout, str(method.spec), verdict, shown_by)
    sizes = layout.upper - layout.lower
    assert method.spec.engine is not None, "a simulation has an engine"
    run = _RecordedLoading(layout, method.spec.engine, method.parameters, Stopwatch())
    try:
        finding = run.load()
    except EngineError as error:
        finding = Finding(status=Status.ERROR, reason=str(error))
    if (finding.status, finding.failing_step) != (verdict.status, verdict.failing_step):
        raise RecordingError(
            f"{method.spec} did not answer twice the same: first {_said(verdict)}, then "
            f"{_said(finding)}"
        )
    return Recording(
        str(method.spec), verdict, run.planned.centres, sizes, True, run.steps(), run.reseats
    )


def simulation_of(method: Method) -> Simulation | None:
    """The simulation that can show a single step of a method: itself, or the last stage of a
    cascade; None where there is none that begins a step with the items as planned.
    """
    last = method.stage_methods[-1] if isinstance(method, Cascade) else method
    if not isinstance(last, Simulation):
        return None
    return last if last.parameters.between_steps is BetweenSteps.RESEAT else None


def record_plan(layout: Layout, method: str, verdict: Verdict) -> Recording:
    """A recording in which nothing moves.

    Args:
        layout: what was judged.
        method: spec of the method that judged it.
        verdict: of the method.
    """
    planned, sizes = 0.5 * (layout.lower + layout.upper), layout.upper - layout.lower
    return Recording(method, verdict, planned, sizes, False, (), reseats=True)


def record_failure(
    layout: Layout, method: str, verdict: Verdict, shown_by: Simulation
) -> Recording:
    """Record what a simulation does with the step at which another method says that a load fails.

    Args:
        layout: what was judged.
        method: spec of the method that judged it.
        verdict: of the method, with a failing step.
        shown_by: simulates that step alone; see :func:`simulation_of`.

    Returns:
        The recording; one without motion where that simulation lets the step stand, or breaks.
    """
    step = verdict.failing_step
    assert step is not None, "the load fails"
    run = _RecordedLoading(layout, shown_by.engine, shown_by.parameters, Stopwatch())
    try:
        finding = run.place(step)
    except EngineError:
        finding = None
    finally:
        run.close()
    if finding is None or finding.status is not Status.DONE:
        return record_plan(layout, method, verdict)
    sizes = layout.upper - layout.lower
    return Recording(method, verdict, run.planned.centres, sizes, True, run.steps(), run.reseats)


def _said(answer: Verdict | Finding) -> str:
    if answer.status is not Status.DONE:
        return answer.status
    return "stable" if answer.failing_step is None else f"step {answer.failing_step} fails"


@dataclass(slots=True)
class _Take:
    """Frames of one step, as they come."""

    items: Indices
    asked: float = 0.0
    times: list[float] = field(default_factory=list)
    poses: list[Poses] = field(default_factory=list)
    most_moved: list[Movement] = field(default_factory=list)
    judged: int | None = None


class _RecordedLoading(Loading):
    """A loading that records its poses; see :class:`Loading`."""

    def __init__(
        self, layout: Layout, engine: str, parameters: SimulationParameters, watch: Stopwatch
    ) -> None:
        super().__init__(layout, engine, parameters, watch)
        self._takes: dict[int, _Take] = {}
        self._placing = 0
        least, most = _FRAMES
        wanted = min(max(parameters.t_max * _FRAMES_A_SECOND, least), most)
        self._looks_a_sample = math.ceil(wanted / parameters.samples)
        centres = np.array([box.centre for box in self.items])
        upright = np.tile([1.0, 0.0, 0.0, 0.0], (len(centres), 1))
        self.planned = in_layout(Poses(centres, upright), layout, across=self.across)
        self.reseats = parameters.between_steps is BetweenSteps.RESEAT

    def place(self, step: int) -> Finding | None:
        """See :meth:`Loading.place`."""
        self._placing = step
        return super().place(step)

    def _hold(self, items: Indices, fixed: Indices = NOTHING) -> FixedStepWorld:
        # A step that is simulated again, with more items, is shown as it was simulated last.
        self._take = _Take(np.concatenate((items, fixed)))
        self._takes[self._placing] = self._take
        self._world = super()._hold(items, fixed)
        return self._world

    def _step(self, world: FixedStepWorld, duration: float) -> int:
        executed = 0
        for _ in range(self._looks_a_sample):
            executed += super()._step(world, duration / self._looks_a_sample)
            self._look(world, duration / self._looks_a_sample)
        return executed

    def _look(self, world: FixedStepWorld, duration: float) -> None:
        take, poses = self._take, self.poses(world)
        take.asked += duration
        if np.isfinite(poses.centres).all() and np.isfinite(poses.quaternions).all():
            take.times.append(take.asked)
            take.poses.append(poses)
            take.most_moved.append(self.examiner.most_moved(poses, take.items))

    def _settle(self, step: int, items: Indices, fixed: Indices = NOTHING) -> Finding | None:
        finding = super()._settle(step, items, fixed)
        if finding is not None and finding.status is Status.DONE:
            self._take.judged = len(self._take.times)
            self._go_on()
        return finding

    def _go_on(self) -> None:
        """Follow the fall to the end of the step's time, as far as the engine goes."""
        world, p = self._world, self.parameters
        sample = p.t_max / p.samples
        try:
            while self._take.asked < p.t_max - 0.5 * sample:
                self._step(world, sample)
        except EngineError:
            pass

    def steps(self) -> tuple[RecordedStep, ...]:
        """All steps so far, also those that were not simulated."""
        count = max(self._takes, default=-1) + 1
        return tuple(self._recorded(step) for step in range(count))

    def _recorded(self, step: int) -> RecordedStep:
        take = self._takes.get(step, _Take(NOTHING))
        frames = len(take.times)
        centres = np.tile(self.planned.centres[: step + 1], (frames, 1, 1))
        quaternions = np.tile(self.planned.quaternions[: step + 1], (frames, 1, 1))
        for frame, poses in enumerate(take.poses):
            seen = in_layout(poses, self.layout, across=self.across)
            centres[frame, take.items] = seen.centres
            quaternions[frame, take.items] = seen.quaternions
        judged = frames if take.judged is None else take.judged
        return RecordedStep(
            np.array(take.times), Poses(centres, quaternions), tuple(take.most_moved), judged
        )
