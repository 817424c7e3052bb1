"""What the page of the extremes shows, as small typed records."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum


class Outcome(StrEnum):
    """How an engine fared in one cell of a sweep.

    ``close``: within the stricter of a sweep's two limits. ``held``: within the other one.
    ``failed``: beyond both, or diverged. ``no verdict``: no answer within the time a cell has, or
    an error. ``undefined``: the engine cannot be asked.
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
    """One axis that is swept to its ends.

    ``axis`` names the value, ``unit`` is its unit. ``close`` and ``held`` say in words what the two
    limits are. ``quantity`` names what is compared with a closed form, empty where the closed form
    is to stay where one is. ``shown``: the value that stands for the sweep in a figure of errors;
    ``resolution``: errors below it are not told from none [% of the closed form].
    ``stops``: after so many values in a row that were not held, larger ones are not measured.
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
    """What one engine did at one frequency and value.

    ``frequency`` is None for an engine that chooses its own steps. ``numbers``, by name:
    ``found`` and ``expected`` where there is a closed form, else ``moved`` [mm], ``turned`` [deg],
    ``penetration`` [mm], ``energy`` [mm]; always ``cpu`` [ms]. ``note`` says what is special.
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
    """What an engine was measured to hold at one frequency, at the label's thresholds.

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
    """All that was measured at the edge.

    ``envelope``: at a label's thresholds; ``rests``: where nothing may move. ``from_here_on`` and
    ``at_rest``: the same, of what is held at that frequency and all higher ones; only where falls
    are seen and two cubes hold, and one row where two say the same. ``timeout``: of a cell [s].
    """

    sweeps: tuple[ExtremeSweep, ...]
    cells: tuple[ExtremeCell, ...]
    envelope: tuple[EnvelopeRow, ...]
    rests: tuple[EnvelopeRow, ...]
    from_here_on: tuple[EnvelopeRow, ...]
    at_rest: tuple[EnvelopeRow, ...]
    timeout: float
