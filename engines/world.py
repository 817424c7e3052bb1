"""The contract between the loading algorithm and a physics engine.

A :class:`World` holds boxes on an infinite horizontal floor at z = 0 under gravity. Units are SI,
z is up, poses are those of a box's *geometric* centre, quaternions are ``w, x, y, z``. A world is
headless, owns everything it touches and shares no state with any other world.
"""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType
from typing import ClassVar, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from engines.errors import BadNumberError, WorldClosedError
from engines.errors import EngineError as EngineError
from engines.errors import EngineNotInstalledError as EngineNotInstalledError
from engines.limits import check_box, check_settings
from engines.substeps import StepCount, SubstepClock

FloatArray = NDArray[np.float64]

GRAVITY = 9.8
"""Gravitational acceleration [m/s2]; 980 cm/s2 in the paper's reference simulation."""


class BroadPhase(StrEnum):
    """Broad-phase collision detection, as in Table 3 of the paper."""

    SIMPLE = "simple"
    DBVT = "dbvt"
    SWEEP = "sweep"


@dataclass(frozen=True, slots=True)
class Box:
    """One rigid box of uniform density about a shifted centre of mass.

    Args:
        size: full edge lengths along the world's x, y, z [m], all positive.
        mass: [kg], positive.
        centre: planned position of the geometric centre [m].
        mass_offset: centre of mass minus geometric centre [m], inside the box.
        fixed: part of the surroundings: it carries and stops others and never moves.
    """

    size: tuple[float, float, float]
    mass: float
    centre: tuple[float, float, float]
    mass_offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    fixed: bool = False

    @property
    def inertia(self) -> tuple[float, float, float]:
        """Principal moments of the uniform box [kg m2], taken about the centre of mass.

        All engines are given the same moments wherever the centre of mass lies, so that they
        answer the same question; a shifted centre alone does not define an inertia.
        """
        x, y, z = self.size
        twelfth = self.mass / 12.0
        return (twelfth * (y * y + z * z), twelfth * (x * x + z * z), twelfth * (x * x + y * y))


@dataclass(frozen=True, slots=True)
class WorldSettings:
    """What a world is asked to be. Every value is that of the *contact* or the *body*, in SI.

    Each engine declares which of these it honours, emulates or ignores (:class:`Capabilities`).

    Args:
        friction: Coulomb coefficient of every contact, >= 0.
        restitution: coefficient of every contact, 0 to 1.
        linear_damping: share of linear velocity lost per second, 0 to < 1.
        angular_damping: share of angular velocity lost per second, 0 to < 1.
        margin: collision margin [m], >= 0.
        broad_phase: None leaves the choice to the engine.
        solver_iterations: None leaves the choice to the adapter.
        gravity: acceleration vector [m/s2]; tilting it is the same as tilting the floor.
        emulate: settings that the engine lacks and that it shall imitate where it can do so only
            at a price (see the engine's notes). Nothing is imitated at a price unasked.
        options: what only this engine can be asked (its ``options`` in the registry); None leaves
            all of it at its defaults.

    Raises:
        BadNumberError: a number is not finite, or not in its range.
    """

    friction: float = 0.5
    restitution: float = 0.0
    linear_damping: float = 0.0
    angular_damping: float = 0.0
    margin: float = 0.0
    broad_phase: BroadPhase | None = None
    solver_iterations: int | None = None
    gravity: tuple[float, float, float] = (0.0, 0.0, -GRAVITY)
    emulate: frozenset[str] = frozenset()
    options: object | None = None

    def __post_init__(self) -> None:
        check_settings(self)

    def requested(self) -> tuple[str, ...]:
        """Names of the settings that ask for something, that is: differ from "nothing special"."""
        neutral = WorldSettings(friction=0.0)
        return tuple(n for n in SETTINGS if getattr(self, n) != getattr(neutral, n))


SETTINGS: tuple[str, ...] = tuple(
    f.name
    for f in dataclasses.fields(WorldSettings)
    if f.name not in ("emulate", "gravity", "options")
)
"""Names of the settings that an engine may honour, emulate or ignore."""


class Support(StrEnum):
    """How an engine meets a setting."""

    HONOURED = "honoured"
    EMULATED = "emulated"
    ON_REQUEST = "emulated on request"
    IGNORED = "ignored"


@dataclass(frozen=True, slots=True)
class SettingSupport:
    """One engine's answer to one setting.

    ``values`` limits the answer to some of the values; any other value counts as ignored.
    """

    support: Support
    note: str = ""
    values: tuple[object, ...] | None = None


class FailureKind(StrEnum):
    """Whose a known failure is."""

    NOT_YET_WRITTEN = "not yet written"
    NOT_YET_UPSTREAM = "not yet upstream"
    NEVER = "never"


@dataclass(frozen=True, slots=True)
class KnownFailure:
    """A conformance check that an engine is known to fail: strict, so it goes when it passes.

    ``check`` is the check's name, ``evidence`` the smallest case with what was measured.
    """

    check: str
    kind: FailureKind
    reason: str
    evidence: str


@dataclass(frozen=True)
class Capabilities:
    """Facts about an engine, as data: tables, warnings and tests are made from them.

    ``error_controlled``: it chooses its own steps; a substep decides only when one can look at it.
    ``compliant``: contacts give way in proportion to their load, so that masses matter.
    """

    title: str
    dimensions: int
    settings: Mapping[str, SettingSupport]
    deterministic: bool = True
    notes: str = ""
    known_failures: tuple[KnownFailure, ...] = ()
    error_controlled: bool = False
    compliant: bool = False

    def support(self, name: str, settings: WorldSettings) -> Support:
        """How the setting ``name`` is met under ``settings``: honoured, emulated or ignored."""
        declared = self.settings[name]
        if declared.values is not None and getattr(settings, name) not in declared.values:
            return Support.IGNORED
        if declared.support is Support.ON_REQUEST:
            return Support.EMULATED if name in settings.emulate else Support.IGNORED
        return declared.support

    def ignored(self, settings: WorldSettings) -> tuple[str, ...]:
        """Names of requested settings that have no effect on this engine."""
        return tuple(
            name for name in settings.requested() if self.support(name, settings) is Support.IGNORED
        )

    def emulated(self, settings: WorldSettings) -> tuple[str, ...]:
        """Names of requested settings that this engine imitates by other means."""
        return tuple(
            name
            for name in settings.requested()
            if self.support(name, settings) is Support.EMULATED
        )


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


@runtime_checkable
class World(Protocol):
    """What the loading algorithm needs of an engine. One world judges one layout."""

    capabilities: ClassVar[Capabilities]

    def add_box(self, box: Box) -> int:
        """Add a box at rest at its planned pose; returns its index, counted from 0.

        Raises:
            BadNumberError: a number is not finite or out of range (:mod:`engines.limits`); the
                world stays as it was.
        """
        ...

    def prepare(self) -> None:
        """Do now what adding boxes has put off, so that stepping is nothing but stepping."""
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

    def set_velocities(self, velocities: Velocities) -> None:
        """Give every box the velocities that :meth:`velocities` returns; poses stay.

        Raises:
            BadNumberError: not a finite row for every box; rows of fixed boxes are ignored.
        """
        ...

    def reset_poses(self) -> None:
        """Put every box back to its planned pose, at rest ("reseat"), as in a world made anew."""
        ...

    def close(self) -> None:
        """Give back native resources. Closing twice is allowed."""
        ...


class FixedStepWorld(ABC):
    """Base of every engine: the protocol's bookkeeping, so that an adapter is only native calls.

    A subclass declares :attr:`capabilities` and implements the underscored operations.
    """

    capabilities: ClassVar[Capabilities]

    def __init__(self, settings: WorldSettings) -> None:
        self.settings = settings
        self.boxes: list[Box] = []
        self._clock = SubstepClock()
        self._closed = False

    def add_box(self, box: Box) -> int:
        """See :meth:`World.add_box`."""
        self._check_open()
        check_box(box, len(self.boxes))
        self._add(box)
        self.boxes.append(box)
        return len(self.boxes) - 1

    def prepare(self) -> None:
        """See :meth:`World.prepare`."""
        self._check_open()
        self._prepare()

    @classmethod
    def warm_up(cls, box_count: int) -> None:
        """Make what worlds of up to ``box_count`` boxes share and keep, such as compiled models.

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

    def reset_poses(self) -> None:
        """See :meth:`World.reset_poses`. Also drops the clock's remainder."""
        self._check_open()
        self._clock = SubstepClock()
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

    def _prepare(self) -> None:
        """Nothing to do, unless an engine puts something off."""

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


def declare(**settings: SettingSupport) -> Mapping[str, SettingSupport]:
    """The settings part of a :class:`Capabilities`, checked to answer for every setting.

    Raises:
        ValueError: a setting of :class:`WorldSettings` has no answer, or an answer no setting.
    """
    if set(SETTINGS) != set(settings):
        raise ValueError(f"declare exactly {sorted(SETTINGS)}, got {sorted(settings)}")
    return MappingProxyType(dict(settings))
