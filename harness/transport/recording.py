"""Recording of a complete load on the road, for display."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from steadyload.engines.world import EngineError, Poses
from steadyload.layouts.model.layout import FloatArray, Layout
from steadyload.layouts.model.naming import label_in
from steadyload.methods.contract.method import Method, Status, Verdict
from steadyload.methods.session.recording import RecordedStep, Recording
from steadyload.methods.simulation.scene import in_layout
from steadyload.methods.simulation.simulation import Simulation
from steadyload.statics.movement import Movement
from steadyload.transport.errors import TransportError
from steadyload.transport.riding import LoadedWorld, Look
from steadyload.transport.rules import Rule

_EVERY = 2
"""Of the looks at a ride so many are one frame."""


def record_ride(layout: Layout, rule: Rule, direction_deg: float, method: Method) -> Recording:
    """Put a load through a rule's history in one direction, and record its motion.

    Args:
        layout: the load.
        rule: what the load is put through.
        direction_deg: of the force on the boxes, seen from above; one of the rule's.
        method: its engine and the parameters of its world are used.

    Returns:
        A recording whose last step is the ride; earlier ones show the plan. An engine that gives up
        is a verdict of status ``error``.

    Raises:
        TransportError: the rule has no such direction, or the method simulates nothing.
    """
    if not isinstance(method, Simulation):
        raise TransportError(
            f"method {method.spec}: moves nothing; allowed: a simulation such as label@mujoco"
        )
    level = rule.level(direction_deg)
    method.prepare(len(layout))
    upright = np.tile([1.0, 0.0, 0.0, 0.0], (len(layout), 1))
    planned = Poses(0.5 * (layout.lower + layout.upper), upright)
    filmed = _Film(layout)
    asked = f"{rule.name}, {level:g} g at {direction_deg:g} degrees"
    count = len(layout)
    try:
        with LoadedWorld(layout, method.engine, method.parameters) as world:
            ride = world.ride(
                rule.history(level), direction_deg,
                displacement=rule.largest_displacement(float(layout.upper[:, 1].max())),
                rotation=rule.rotation, rest=rule.rest, whole=True, watch=filmed.take,
            )  # fmt: skip
    except EngineError as error:
        verdict = Verdict(count, Status.ERROR, reason=str(error))
        headline, judged = f"{asked}: no answer", 0
    else:
        label = label_in(layout.items, ride.moved_item)
        verdict = Verdict(
            count,
            failing_step=None if ride.held else count - 1,
            moved_item=ride.moved_item,
            displacement=ride.displacement,
            rotation=ride.rotation,
        )
        said = "held" if ride.held else f"{label} {ride.mode}"
        headline = f"{asked}: {said}"
        judged = len(filmed.times)
        if not ride.held:
            judged = int(np.searchsorted(filmed.times, ride.seconds)) + 1
    steps = [_still() for _ in range(count - 1)] + [
        filmed.step(judged, None if verdict.stable else verdict.moved_item)
    ]
    sizes = layout.upper - layout.lower
    return Recording(
        str(method.spec), verdict, planned.centres, sizes, True, tuple(steps), True, headline
    )


@dataclass
class _Film:
    """Frames of a ride, as they come."""

    layout: Layout
    looks: int = 0
    times: list[float] = field(default_factory=list)
    poses: list[Poses] = field(default_factory=list)
    moved: list[tuple[FloatArray, FloatArray]] = field(default_factory=list)

    def take(self, look: Look) -> None:
        self.looks += 1
        if self.looks % _EVERY:
            return
        self.times.append(look.seconds)
        self.poses.append(in_layout(look.poses, self.layout))
        self.moved.append((look.shifts, look.angles))

    def step(self, judged: int, moved_item: int | None) -> RecordedStep:
        """The ride as a step; from the frame of the verdict on its box is the one that is named.

        Args:
            judged: frames before the verdict or at it.
            moved_item: that moves too far; None where none does.
        """
        if not self.times:
            return _still()
        most = []
        for frame, (shifts, angles) in enumerate(self.moved, start=1):
            item = int(shifts.argmax())
            if moved_item is not None and frame >= judged:
                item = moved_item
            most.append(Movement(item, float(shifts[item]), float(angles[item]), 0.0))
        centres = np.stack([poses.centres for poses in self.poses])
        quaternions = np.stack([poses.quaternions for poses in self.poses])
        return RecordedStep(
            np.array(self.times), Poses(centres, quaternions), tuple(most),
            min(judged, len(self.times)),
        )  # fmt: skip


def _still() -> RecordedStep:
    return RecordedStep(np.empty(0), Poses(np.empty((0, 0, 3)), np.empty((0, 0, 4))), (), 0)
