"""Settings of a world, and which of them each engine honours, emulates or ignores, as data."""

from __future__ import annotations

import dataclasses
import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType

from steadyload.engines.errors import BadNumberError
from steadyload.engines.limits import are_within, is_within

GRAVITY = 9.8
"""Gravitational acceleration [m/s2]; 980 cm/s2 in the paper's reference simulation."""


_LARGEST = sys.float_info.max
_BELOW_ONE = math.nextafter(1.0, 0.0)

_SETTINGS = {
    "friction": (0.0, _LARGEST, "a finite number, 0 or more"),
    "restitution": (0.0, 1.0, "0 to 1"),
    "linear_damping": (0.0, _BELOW_ONE, "0 to less than 1"),
    "angular_damping": (0.0, _BELOW_ONE, "0 to less than 1"),
    "margin": (0.0, _LARGEST, "a finite number, 0 or more [m]"),
}


class BroadPhase(StrEnum):
    """Broad-phase collision detection, as in Table 3 of the paper."""

    SIMPLE = "simple"
    DBVT = "dbvt"
    SWEEP = "sweep"


@dataclass(frozen=True, slots=True)
class WorldSettings:
    """Settings of a world. Every value is that of the *contact* or the *body*, in SI.

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
        options: settings that only this engine has (its ``options`` in the registry); None leaves
            all of them at their defaults.

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
        """Names of the settings that are requested, that is: differ from "nothing special"."""
        neutral = WorldSettings(friction=0.0)
        return tuple(n for n in SETTINGS if getattr(self, n) != getattr(neutral, n))

    def decay_rates(self) -> tuple[float, float]:
        """Rates at which the damping alone slows a body, linear and angular [1/s]: -ln(1 - d)."""
        return -math.log1p(-self.linear_damping), -math.log1p(-self.angular_damping)


def check_settings(settings: WorldSettings) -> None:
    """Refuse settings that are outside the limits of all engines.

    Raises:
        BadNumberError: a number that is not finite or out of range.
    """
    for name, (least, most, allowed) in _SETTINGS.items():
        value = getattr(settings, name)
        if not is_within(value, least, most):
            raise BadNumberError(f"{name} is {value!r}; allowed: {allowed}")
    iterations = settings.solver_iterations
    counts = iterations is None or (is_within(iterations, 1, _LARGEST) and iterations % 1 == 0)
    if not counts:
        raise BadNumberError(
            f"solver_iterations is {iterations!r}; allowed: None, or a whole number from 1 on"
        )
    check_gravity(settings.gravity)


def check_gravity(gravity: tuple[float, float, float]) -> None:
    """Refuse a gravity that no engine takes.

    Raises:
        BadNumberError: it is no three finite numbers.
    """
    if not are_within(gravity, -_LARGEST, _LARGEST):
        raise BadNumberError(f"gravity is {gravity!r}; allowed: three finite numbers")


SETTINGS: tuple[str, ...] = tuple(
    f.name
    for f in dataclasses.fields(WorldSettings)
    if f.name not in ("emulate", "gravity", "options")
)
"""Names of the settings that an engine may honour, emulate or ignore."""


class Support(StrEnum):
    """Support of a setting by an engine: honoured, emulated (also on request) or ignored."""

    HONOURED = "honoured"
    EMULATED = "emulated"
    ON_REQUEST = "emulated on request"
    IGNORED = "ignored"


@dataclass(frozen=True, slots=True)
class SettingSupport:
    """Support of one setting by one engine.

    ``values`` limits the support to some of the values; any other value counts as ignored.
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
    ``subsets``: a world can leave out some of its boxes and take them in again.
    ``single_precision``: its numbers have 24 bits, some seven digits.
    ``changing_gravity``: how a world takes another gravity while it runs. ``in_flight``: how it
    takes a box that is turned or moves when it is added.
    ``version``: of the adapter, raised by hand when its worlds move otherwise; stored verdicts are
    stale then. ``numerics``: packages that its motion hangs on, beside those of the registry.
    """

    title: str
    dimensions: int
    settings: Mapping[str, SettingSupport]
    notes: str = ""
    known_failures: tuple[KnownFailure, ...] = ()
    error_controlled: bool = False
    compliant: bool = False
    subsets: bool = False
    single_precision: bool = False
    changing_gravity: SettingSupport = SettingSupport(Support.IGNORED)
    in_flight: SettingSupport = SettingSupport(Support.IGNORED)
    version: int = 1
    numerics: tuple[str, ...] = ("numpy",)

    def support(self, name: str, settings: WorldSettings) -> Support:
        """Support of the setting ``name`` under ``settings``: honoured, emulated or ignored."""
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


def declare(**settings: SettingSupport) -> Mapping[str, SettingSupport]:
    """The settings part of a :class:`Capabilities`, checked to cover every setting.

    Raises:
        ValueError: a setting of :class:`WorldSettings` is missing, or a name is no setting.
    """
    if set(SETTINGS) != set(settings):
        raise ValueError(f"declare exactly {sorted(SETTINGS)}, got {sorted(settings)}")
    return MappingProxyType(dict(settings))
