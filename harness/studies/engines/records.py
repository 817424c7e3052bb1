"""Results of the engine study: agreement, options, speed and declared settings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from steadyload.statistics.estimate import Estimate


@dataclass(frozen=True, slots=True)
class EngineAgreement:
    """Agreement between engines at one frequency [Hz]; ``cpu`` in ms a layout."""

    frequency: int
    stable: Mapping[str, Estimate]
    cpu: Mapping[str, Estimate]
    agreement: Mapping[tuple[str, str], Estimate]


@dataclass(frozen=True, slots=True)
class OptionEffect:
    """Effect of an option on one engine.

    ``changed``: share of layouts with another failing step. ``ratio``: CPU time with the option
    over that without. ``cpu``: with it, in ms a layout.
    """

    option: str
    engine: str
    changed: Estimate
    ratio: float
    cpu: Estimate


@dataclass(frozen=True, slots=True)
class EngineSettings:
    """An engine's declared capabilities: setting -> (capability, a note)."""

    name: str
    title: str
    dimensions: int
    answers: Mapping[str, tuple[str, str]]
    notes: str


@dataclass(frozen=True, slots=True)
class SpeedPoint:
    """Cost of one layout [CPU ms, medians over ``repeats``].

    ``floor`` is the engine's own stepping, ``create`` the adding of boxes; None where they were not
    measured.
    """

    item_count: int
    total: float
    build: float
    step: float
    read: float
    floor: float | None
    create: float | None
    repeats: int


@dataclass(frozen=True, slots=True)
class SpeedCurve:
    """Cost against the number of items: one engine, one scene, one scope."""

    engine: str
    scene: str
    scope: str
    points: tuple[SpeedPoint, ...]
    exponent: float


@dataclass(frozen=True, slots=True)
class Throughput:
    """Layouts a second [1/s, wall time] over one process and over two."""

    engine: str
    layouts: int
    one: float
    two: float
