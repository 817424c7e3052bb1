"""Typed records for the page of the extremes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum


class Outcome(StrEnum):
    """Outcome of an engine in one cell of a sweep.

    ``close``: within the stricter of a sweep's two limits. ``held``: within the other one.
    ``failed``: beyond both, or diverged. ``no verdict``: no result within the time limit of a cell,
    or an error. ``undefined``: the engine has no such setting.
    """

    CLOSE = "close"
    HELD = "held"
    FAILED = "failed"
    NO_VERDICT = "no verdict"
    UNDEFINED = "undefined"

    @property
    def good(self) -> bool:
        """Within at least the wider limit."""
        return self in (Outcome.CLOSE, Outcome.HELD)


@dataclass(frozen=True, slots=True)
class ExtremeSweep:
    """One axis of a sweep.

    ``axis`` names the value, ``unit`` is its unit. ``close`` and ``held`` describe the two limits
    in words. ``quantity`` names the quantity that is compared with a closed form, empty where no
    box may move. ``shown``: the value that represents the sweep in a figure of errors;
    ``resolution``: errors below it count as none [% of the closed form].
    ``stops``: number of consecutive values not held after which larger ones are not measured.
    """

    name: str
    title: str
    definition: str
    axis: str
    unit: str
    values: tuple[float, ...]
    close: str
    held: str
    quantity: str = ""
    shown: float | None = None
    resolution: float = 1e-3
    stops: int | None = None


@dataclass(frozen=True, slots=True)
class ExtremeCell:
    """Result of one engine at one frequency and value.

    ``frequency`` is None for an engine that chooses its own steps. ``numbers``, by name:
    ``found`` and ``expected`` where there is a closed form, else ``moved`` [mm], ``turned`` [deg],
    ``penetration`` [mm], ``energy`` [mm]; always ``cpu`` [ms]. ``note``: a remark on the result.
    """

    sweep: str
    engine: str
    frequency: int | None
    value: float
    outcome: Outcome
    numbers: Mapping[str, float] = field(default_factory=dict)
    note: str = ""


@dataclass(frozen=True, slots=True)
class EnvelopeRow:
    """Envelope of an engine at one frequency, at the label's thresholds.

    ``tower_height`` in items, mass ratios as numbers, sizes in cm, 0 where nothing was held.
    ``sees_falls``: a plate beyond an edge falls, and one before it stays.
    """

    engine: str
    frequency: int | None
    tower_height: int
    heavy_on_light: float
    light_on_heavy: float
    least_size: float
    most_size: float
    item_count: int
    sees_falls: bool


@dataclass(frozen=True, slots=True)
class Extremes:
    """All results of the study of extremes.

    ``envelope``: at the label's thresholds; ``rests``: at those of rest. ``from_here_on`` and
    ``at_rest``: the same, for values held at that frequency and all higher ones; only where falls
    are detected and two cubes hold, and one row where two are equal. ``timeout``: of a cell [s].
    """

    sweeps: tuple[ExtremeSweep, ...]
    cells: tuple[ExtremeCell, ...]
    envelope: tuple[EnvelopeRow, ...]
    rests: tuple[EnvelopeRow, ...]
    from_here_on: tuple[EnvelopeRow, ...]
    at_rest: tuple[EnvelopeRow, ...]
    timeout: float
