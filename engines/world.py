"""The contract between the loading algorithm and a physics engine.

A :class:`World` holds boxes on an infinite horizontal floor at z = 0 under gravity. Units are SI,
z is up, poses are those of a box's *geometric* centre, quaternions are ``w, x, y, z``. A world is
headless, owns everything it touches and shares no state with any other world.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar, NamedTuple, Protocol, TypeVar, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from steadyload.engines.attitudes import lengths
from steadyload.engines.box import Box as Box
from steadyload.engines.box import check_box
from steadyload.engines.capabilities import GRAVITY as GRAVITY
from steadyload.engines.capabilities import SETTINGS as SETTINGS
from steadyload.engines.capabilities import BroadPhase as BroadPhase
from steadyload.engines.capabilities import Capabilities as Capabilities
from steadyload.engines.capabilities import FailureKind as FailureKind
from steadyload.engines.capabilities import KnownFailure as KnownFailure
from steadyload.engines.capabilities import SettingSupport as SettingSupport
from steadyload.engines.capabilities import Support as Support
from steadyload.engines.capabilities import WorldSettings as WorldSettings
from steadyload.engines.capabilities import check_gravity
from steadyload.engines.capabilities import declare as declare
from steadyload.engines.errors import BadNumberError, WorldClosedError
from steadyload.engines.errors import EngineError as EngineError
from steadyload.engines.errors import (
    EngineNotInstalledError as EngineNotInstalledError,
)
from steadyload.engines.substeps import StepCount, SubstepClock

FloatArray = NDArray[np.float64]

_OptionsT = TypeVar("_OptionsT")

VERSION = 1
"""Of what all adapters share (clock, attitudes, boxes): raised when worlds move otherwise."""


class Poses(NamedTuple):
    """Poses of all boxes, in the order in which they were added.

    ``centres``: geometric centres [m], shape (n, 3). ``quaternions``: w, x, y, z, shape (n, 4).
    """

    centres: FloatArray
    quaternions: FloatArray


class Velocities(NamedTuple):
    """Velocities in world axes: ``linear`` [m/s] of the *centre of mass*, ``angular`` [rad/s]."""

    linear: FloatArray
    angular: FloatArray


def planned_poses(boxes: Sequence[Box]) -> Poses:
    """Poses of boxes that stand as planned."""
    centres = np.array([box.centre for box in boxes], dtype=np.float64).reshape(-1, 3)
    turns = np.array([box.unit_attitude for box in boxes], dtype=np.float64).reshape(-1, 4)
    return Poses(centres, turns)


def planned_velocities(boxes: Sequence[Box]) -> Velocities:
    """Velocities of boxes as they are added."""
    linear = np.array([box.velocity for box in boxes], dtype=np.float64).reshape(-1, 3)
    angular = np.array([box.angular_velocity for box in boxes], dtype=np.float64).reshape(-1, 3)
    return Velocities(linear, angular)


@runtime_checkable
class World(Protocol):
    """Operations of an engine that the loading algorithm needs. A world simulates one layout."""

    capabilities: ClassVar[Capabilities]

    def add_box(self, box: Box) -> int:
        """Add a box at its planned pose, with its velocities; returns its index, counted from 0.

        Raises:
            BadNumberError: a number is not finite or out of range
                (:mod:`steadyload.engines.box`); the world stays as it was.
            EngineError: it is turned or moves, and the engine declares that it ignores
                ``in_flight``, or it does so out of the plane of an engine of two dimensions.
        """
        ...

    def prepare(self) -> None:
        """Do the work that adding boxes has put off, so that stepping is nothing but stepping."""
        ...

    def stepSimulation(  # noqa: N802 - the spelling of Bullet and of the paper's Eq. 1
        self,
        timeStep: float,
        maxSubSteps: int,
        fixedTimeStep: float,
    ) -> StepCount:
        """Advance by ``timeStep`` seconds in at most ``maxSubSteps`` of ``fixedTimeStep`` each."""
        ...

    def poses(self) -> Poses:
        """Current poses; reading never advances time. The arrays belong to the caller."""
        ...

    def velocities(self) -> Velocities:
        """Current velocities. The arrays belong to the caller."""
        ...

    def speeds(self) -> FloatArray:
        """Speeds of every box, shape (n, 2): of the centre of mass [m/s], of rotation [rad/s]."""
        ...

    def set_velocities(self, velocities: Velocities) -> None:
        """Give every box the velocities that :meth:`velocities` returns; poses stay.

        Raises:
            BadNumberError: not a finite row for every box; rows of fixed boxes are ignored.
        """
        ...

    def set_gravity(self, gravity: tuple[float, float, float]) -> None:
        """Let another gravity act from the next step on, until the next one or a reset.

        In the frame of a floor that is accelerated, gravity is that at rest less the acceleration.

        Args:
            gravity: acceleration vector [m/s2].

        Raises:
            BadNumberError: it is no three finite numbers.
            EngineError: the engine declares that it ignores it, or it points out of the plane of
                an engine of two dimensions.
        """
        ...

    def reset_poses(self, only: Sequence[int] | None = None) -> None:
        """Put every box back as it was added ("reseat"), as in a world made anew.

        Args:
            only: ascending indices of the boxes that take part from now on, and any that is added
                later. The others are as if they had never been added: they touch nothing and have
                no row in poses and velocities. None: all take part.

        Raises:
            BadNumberError: not ascending indices of boxes.
            EngineError: boxes would be left out, and the engine declares no ``subsets``.
        """
        ...

    def close(self) -> None:
        """Release native resources. Closing twice is allowed."""
        ...


class FixedStepWorld(ABC):
    """Base of every engine: the protocol's bookkeeping, so that an adapter is only native calls.

    A subclass declares :attr:`capabilities` and implements the underscored operations.
    :attr:`boxes` are those that take part, :attr:`gravity` [m/s2] is that of the next step.
    """

    capabilities: ClassVar[Capabilities]

    def __init__(self, settings: WorldSettings) -> None:
        self.settings = settings
        self.gravity = settings.gravity
        self.boxes: list[Box] = []
        self._all_boxes: list[Box] = []
        self._clock = SubstepClock()
        self._closed = False

    def add_box(self, box: Box) -> int:
        """See :meth:`World.add_box`."""
        self._check_open()
        check_box(box, len(self._all_boxes))
        if box.launched and self.capabilities.in_flight.support is Support.IGNORED:
            raise EngineError(f"{self.capabilities.title} takes boxes upright and at rest alone")
        self._add(box)
        self._all_boxes.append(box)
        self.boxes.append(box)
        return len(self._all_boxes) - 1

    def prepare(self) -> None:
        """See :meth:`World.prepare`."""
        self._check_open()
        self._prepare()

    @classmethod
    def warm_up(cls, box_count: int) -> None:
        """Make everything that worlds of up to ``box_count`` boxes share, such as compiled models.

        Never needed; it moves a cost that occurs once out of the first judgement.
        """

    def stepSimulation(  # noqa: N802
        self,
        timeStep: float,
        maxSubSteps: int,
        fixedTimeStep: float,
    ) -> StepCount:
        """See :meth:`World.stepSimulation`."""
        self._check_open()
        count, length = self._clock.advance(timeStep, maxSubSteps, fixedTimeStep)
        if count.executed:
            self._advance(count.executed, length)
        return count

    def poses(self) -> Poses:
        """See :meth:`World.poses`."""
        self._check_open()
        return self._poses()

    def velocities(self) -> Velocities:
        """See :meth:`World.velocities`."""
        self._check_open()
        return self._velocities()

    def speeds(self) -> FloatArray:
        """See :meth:`World.speeds`."""
        self._check_open()
        return self._speeds()

    def set_velocities(self, velocities: Velocities) -> None:
        """See :meth:`World.set_velocities`."""
        self._check_open()
        moving = np.array([not box.fixed for box in self.boxes], dtype=bool)
        checked = Velocities(*(np.array(part, dtype=np.float64) for part in velocities))
        for part in checked:
            if part.shape != (len(moving), 3) or not np.isfinite(part[moving]).all():
                allowed = f"{len(moving)} rows of 3 finite numbers, in order of the boxes"
                raise BadNumberError(f"velocities {part.tolist()}; allowed: {allowed}")
            part[~moving] = 0.0
        self._set_velocities(checked)

    def set_gravity(self, gravity: tuple[float, float, float]) -> None:
        """See :meth:`World.set_gravity`."""
        self._check_open()
        check_gravity(gravity)
        if gravity == self.gravity:
            return
        self._check_gravity(gravity)
        before, self.gravity = self.gravity, gravity
        try:
            self._set_gravity()
        except EngineError:
            self.gravity = before
            raise

    def reset_poses(self, only: Sequence[int] | None = None) -> None:
        """See :meth:`World.reset_poses`. Also drops the clock's remainder."""
        self._check_open()
        everything = range(len(self._all_boxes))
        chosen = list(everything if only is None else only)
        if any(i not in everything for i in chosen) or chosen != sorted(set(chosen)):
            allowed = f"ascending, from 0 to less than {len(everything)}"
            raise BadNumberError(f"boxes {chosen}; allowed: {allowed}")
        if len(chosen) < len(everything) or len(self.boxes) < len(everything):
            self._take_part(chosen)
            self.boxes = [self._all_boxes[i] for i in chosen]
        self._clock = SubstepClock()
        self.set_gravity(self.settings.gravity)
        self._reset()

    def close(self) -> None:
        """See :meth:`World.close`."""
        if not self._closed:
            self._closed = True
            self._close()

    def __enter__(self) -> FixedStepWorld:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _check_open(self) -> None:
        if self._closed:
            raise WorldClosedError(f"this {type(self).__name__} has been closed")

    def _own_options(self, kind: type[_OptionsT]) -> _OptionsT:
        """The settings that only this engine has, all of them at their defaults where none is set.

        Raises:
            TypeError: they are those of another engine.
        """
        options = kind() if self.settings.options is None else self.settings.options
        if not isinstance(options, kind):
            raise TypeError(f"options are {options!r}; allowed: {kind.__name__}")
        return options

    def _prepare(self) -> None:
        """Nothing to do, unless an engine puts something off."""

    def _speeds(self) -> FloatArray:
        # For an engine that has them at less cost than velocities in world axes.
        return lengths(np.stack(self._velocities(), axis=1))

    def _check_gravity(self, gravity: tuple[float, float, float]) -> None:
        """Nothing to refuse, unless an engine has less than three dimensions."""

    def _set_gravity(self) -> None:
        """Let :attr:`gravity` act from the next step on."""
        raise EngineError(f"{self.capabilities.title} takes no other gravity while a world runs")

    def _take_part(self, chosen: list[int]) -> None:
        """From the reset that follows on, only these of all boxes take part."""
        raise EngineError(f"{self.capabilities.title} cannot leave out boxes of a world")

    @abstractmethod
    def _add(self, box: Box) -> None: ...

    @abstractmethod
    def _advance(self, substeps: int, length: float) -> None:
        """Run ``substeps`` >= 1 native steps of ``length`` > 0 seconds each."""

    @abstractmethod
    def _poses(self) -> Poses: ...

    @abstractmethod
    def _velocities(self) -> Velocities: ...

    @abstractmethod
    def _set_velocities(self, velocities: Velocities) -> None:
        """Take over checked velocities; rows of fixed boxes are zero."""

    @abstractmethod
    def _reset(self) -> None: ...

    @abstractmethod
    def _close(self) -> None: ...
