"""Worlds of engines that are built when they first move, and anew after every reset.

Nothing of the past can survive in an engine that is made anew, and poses as planned are those that
were asked for, to the last bit. It suits engines that build a world in little time.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import Any

from steadyload.engines.world import (
    Box,
    FixedStepWorld,
    Poses,
    Velocities,
    WorldSettings,
    planned_poses,
    planned_velocities,
)


class RebuiltWorld(FixedStepWorld):
    """Base of such an engine: an adapter builds a world and bodies, and reads and moves one body.

    ``_native`` is what :meth:`_build` returned, None before a world is built. A body is whatever
    :meth:`_body` returns, None for a fixed box.
    """

    def __init__(self, settings: WorldSettings) -> None:
        super().__init__(settings)
        self._native: Any = None
        self._bodies: list[Any] = []

    def _add(self, box: Box) -> None:
        if self._native is not None:
            self._bodies.append(self._body(box))

    def _take_part(self, chosen: list[int]) -> None:
        """Nothing: the world that moves next is built of the boxes that take part."""

    def _prepare(self) -> None:
        if self._native is None:
            self._native = self._build()
            self._bodies = [self._body(box) for box in self.boxes]

    def _advance(self, substeps: int, length: float) -> None:
        self._prepare()
        self._run(substeps, length)

    def _poses(self) -> Poses:
        poses = planned_poses(self.boxes)
        for index, body in enumerate(self._bodies):
            if body is not None:
                poses.centres[index], poses.quaternions[index] = self._pose(body)
        return poses

    def _velocities(self) -> Velocities:
        velocities = planned_velocities(self.boxes)
        for index, body in enumerate(self._bodies):
            if body is not None:
                velocities.linear[index], velocities.angular[index] = self._velocity(body)
        return velocities

    def _set_velocities(self, velocities: Velocities) -> None:
        self._prepare()
        for body, linear, angular in zip(self._bodies, *velocities, strict=True):
            if body is not None:
                self._set_velocity(body, linear.tolist(), angular.tolist())

    def _reset(self) -> None:
        self._native, self._bodies = None, []

    def _close(self) -> None:
        self._reset()

    @abstractmethod
    def _build(self) -> Any:
        """A native world with nothing in it but the floor."""

    @abstractmethod
    def _body(self, box: Box) -> Any:
        """Add a box to the native world; returns what moves it, None for a fixed box."""

    @abstractmethod
    def _run(self, substeps: int, length: float) -> None:
        """Run ``substeps`` >= 1 native steps of ``length`` > 0 seconds each."""

    @abstractmethod
    def _pose(self, body: Any) -> tuple[Any, Any]:
        """Geometric centre [m] and attitude (w, x, y, z)."""

    @abstractmethod
    def _velocity(self, body: Any) -> tuple[Any, Any]:
        """Velocities in world axes: of the centre of mass [m/s], and angular [rad/s]."""

    @abstractmethod
    def _set_velocity(self, body: Any, linear: Sequence[float], angular: Sequence[float]) -> None:
        """Give a body the velocities that :meth:`_velocity` returns."""
