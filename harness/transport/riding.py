"""A loaded pallet in an engine: at rest, then under a history of acceleration."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from steadyload.engines.registry import world_class
from steadyload.engines.world import EngineError, FixedStepWorld, Poses
from steadyload.layouts.model.layout import FloatArray, Layout
from steadyload.methods.simulation.scene import CM, boxes, surroundings
from steadyload.methods.simulation.simulation_parameters import SimulationParameters
from steadyload.transport.balance import Mode
from steadyload.transport.errors import TransportError
from steadyload.transport.history import History

_SETTLING = 0.3
"""Time in which a load comes to rest in its contacts before it is accelerated [s]."""

_LOOK = 0.01
"""Time between two looks at the boxes, and between two values of gravity [s]."""

_AFTER = 5.0
"""Time for which a load is followed after a box has moved too far [s]: longer than any rule's."""


@dataclass(frozen=True)
class Ride:
    """Movements of a load under a history.

    Attributes:
        held: no box moved too far, before or during it, or in the time of watching after it.
        moved_item: the box that moved too far first; else the one that moved furthest.
        displacement: of the centre of that box relative to the deck, at most [cm].
        left: of that box in the end [cm].
        rotation: of that box, at most [degrees].
        mode: how it moved.
        seconds: when it moved too far, from the start of the history; the whole time where none
            did.
        fell: boxes that dropped by more than half their height.
    """

    held: bool
    moved_item: int
    displacement: float
    left: float
    rotation: float
    mode: Mode
    seconds: float
    fell: tuple[int, ...]


@dataclass(frozen=True)
class Look:
    """The boxes at one moment of a history.

    Attributes:
        seconds: from the start of the history.
        poses: of the boxes, in the world's units and axes.
        shifts: of their centres since the history began [cm].
        angles: by which they have turned since [degrees].
    """

    seconds: float
    poses: Poses
    shifts: FloatArray
    angles: FloatArray


Watch = Callable[[Look], None]


class LoadedWorld:
    """A complete load in a world, which is used for any number of rides; a context manager.

    Args:
        layout: the load.
        engine: registered name, of three dimensions.
        parameters: of a simulation on that engine: those of its world, its frequency and shrink.

    Raises:
        TransportError: the engine has two dimensions.
        EngineNotInstalledError: its library is missing.
    """

    def __init__(self, layout: Layout, engine: str, parameters: SimulationParameters) -> None:
        kind = world_class(engine)
        if kind.capabilities.dimensions != 3:
            raise TransportError(
                f"engine {engine}: has two dimensions; allowed: one of three, since loads are "
                "accelerated in any direction"
            )
        self._gravity = parameters.gravity
        self._substep = 1.0 / parameters.frequency
        self._world: FixedStepWorld = kind(parameters.world_settings())
        self._around = surroundings(layout)
        self._sizes = layout.upper - layout.lower
        for box in (*self._around, *boxes(layout, shrink=parameters.shrink)):
            self._world.add_box(box)

    def __enter__(self) -> LoadedWorld:
        return self

    def __exit__(self, *_: object) -> None:
        self._world.close()

    def ride(
        self,
        history: History,
        direction_deg: float,
        *,
        displacement: float,
        rotation: float,
        rest: float = 0.0,
        whole: bool = False,
        watch: Watch = lambda look: None,
    ) -> Ride:
        """Put the load through a history, from its planned positions.

        Args:
            history: of acceleration.
            direction_deg: of the force on the boxes.
            displacement: what a box may move by [cm].
            rotation: what a box may turn by [degrees].
            rest: time of watching after the history [s].
            whole: go on after a box has moved too far, to see how far boxes get: to the end, for
                5 s, or until the engine gives up, whichever comes first.
            watch: is called with every look.

        Raises:
            EngineError: the engine gave up before a box moved too far, or a pose is not finite.
        """
        world = self._world
        world.reset_poses()
        planned = self._read()
        self._advance(_SETTLING)
        settled = self._read()
        shifts, angles = _moved(planned, settled)
        most = np.maximum(shifts / displacement, angles / rotation)
        if most.max() >= 1.0:
            drops = _drops(planned, settled)
            return self._ended(int(most.argmax()), shifts, shifts, angles, 0.0, drops, Mode.FALLS)
        farthest, steepest = np.zeros_like(shifts), np.zeros_like(angles)
        first: tuple[int, float] | None = None
        end, time = history.duration + rest, 0.0
        while time < end - 1e-9:
            span = min(_LOOK, end - time)
            across, up, along = history.gravity(time, span, direction_deg, self._gravity)
            world.set_gravity((along, across, up))  # world (x, y, z) = layout (z, x, y)
            try:
                self._advance(span)
                now = self._read()
            except EngineError:
                if first is None:
                    raise
                break
            time += span
            shifts, angles = _moved(settled, now)
            farthest, steepest = np.maximum(farthest, shifts), np.maximum(steepest, angles)
            most = np.maximum(farthest / displacement, steepest / rotation)
            watch(Look(time, now, shifts, angles))
            if first is None and most.max() >= 1.0:
                first = int(most.argmax()), time
            if first is not None and (not whole or time - first[1] >= _AFTER):
                break
        drops = _drops(settled, now)
        item, seconds = first or (int(most.argmax()), time)
        return self._ended(item, farthest, shifts, steepest, seconds, drops, None, first is None)

    def _advance(self, seconds: float) -> None:
        steps = max(1, math.ceil(seconds / self._substep))
        self._world.stepSimulation(seconds, steps + 1, self._substep)

    def _read(self) -> Poses:
        poses = self._world.poses()
        if not (np.isfinite(poses.centres).all() and np.isfinite(poses.quaternions).all()):
            raise EngineError("the simulation diverged: a pose is not finite")
        first = len(self._around)
        return Poses(poses.centres[first:], poses.quaternions[first:])

    def _ended(
        self,
        item: int,
        farthest: FloatArray,
        left: FloatArray,
        steepest: FloatArray,
        seconds: float,
        drops: FloatArray,
        mode: Mode | None,
        held: bool = False,
    ) -> Ride:
        fell = tuple(np.flatnonzero(drops > 0.5 * self._sizes[:, 1]).tolist())
        # A box that turns about an edge moves its centre by up to half its diagonal a radian.
        reach = 0.5 * float(np.linalg.norm(self._sizes[item]))
        turned = math.radians(float(steepest[item])) * reach
        if mode is None:
            mode = Mode.TIPS if turned > 0.5 * farthest[item] else Mode.SLIDES
        return Ride(
            held, item, float(farthest[item]), float(left[item]), float(steepest[item]), mode,
            seconds, fell,
        )  # fmt: skip


def _drops(before: Poses, now: Poses) -> FloatArray:
    """How far every centre came down [cm]."""
    return (before.centres - now.centres)[:, 2] / CM


def _moved(before: Poses, now: Poses) -> tuple[FloatArray, FloatArray]:
    """How far every centre moved [cm], and by what angle every box turned [degrees]."""
    shifts = np.linalg.norm(now.centres - before.centres, axis=1) / CM
    alike = np.abs((before.quaternions * now.quaternions).sum(axis=1))
    return shifts, np.degrees(2.0 * np.arccos(np.minimum(1.0, alike)))
