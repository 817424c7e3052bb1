"""Sweeps to the limits of numerical stability, as data: values and limits of what is held.

A cell is one engine at one frequency and one value. Cells are independent of each other;
:mod:`steadyload.studies.extremes.running` runs and stores them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial

from steadyload.engines.registry import warm_up
from steadyload.engines.world import Box, EngineError, WorldSettings
from steadyload.methods.contract.method import Stopwatch, TimeoutExpiredError
from steadyload.properties import closed_forms as runs
from steadyload.properties.closed_forms import CUBE, SIDE, NoValueError, Stage, stacked
from steadyload.studies.closed_form_errors import OWN_STEPS
from steadyload.studies.extremes import measuring, scenes
from steadyload.studies.extremes.measuring import Finding, Outcome, compared, settle

VERSION = 1
"""Version of values, limits and scenes of the sweeps: raised when cells change."""

FREQUENCIES = (5, 10, 15, 30, 60, 90, 120, 240, 480, 1000)

TIMEOUT = 30.0
"""Time limit of a cell [s of CPU time]."""

_RATIOS = (1, 3, 10, 30, 100, 300, 1e3, 3e3, 1e4, 3e4, 1e5, 3e5, 1e6)
_SIZES = (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
_FRICTIONS = (0, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1, 1.5, 2)
_RESTITUTIONS = (0, 0.1, 0.2, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95)

_REST = "no box moved by more than 1 mm or turned by more than 0.5 degrees"
_LABEL = "no box moved by more than 10 cm or turned by more than 10 degrees"
_NEAR = f"within {100 * measuring.CLOSE:g} % of the closed form"
_ROUGH = f"within {100 * measuring.HELD:g} %"
_SIDE = f"{100 * SIDE:g} cm"


@dataclass(frozen=True, slots=True)
class ExtremeSweep:
    """One axis of a sweep.

    ``axis`` names the value, ``unit`` is its unit; ``measure`` gets the value. ``close`` and
    ``held`` describe the two limits in words. ``quantity`` names the quantity that is compared
    with a closed form, empty where no box may move. ``shown``: the value that represents the sweep
    in a figure of errors; ``resolution``: errors below it count as none [% of the closed form].
    ``stops``: number of consecutive values not held after which larger ones are not measured.
    """

    name: str
    title: str
    definition: str
    axis: str
    values: tuple[float, ...]
    measure: Callable[[Stage, float], Finding]
    unit: str = ""
    close: str = _REST
    held: str = _LABEL
    quantity: str = ""
    shown: float | None = None
    resolution: float = 1e-3
    stops: int | None = None

    @property
    def label(self) -> str:
        """The axis with its unit."""
        return f"{self.axis} ({self.unit})" if self.unit else self.axis


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

    @property
    def steps(self) -> str:
        """Substeps a second, or that the engine chooses its own."""
        return OWN_STEPS if self.frequency is None else f"{self.frequency}"


def measure_cell(
    sweep: str, engine: str, frequency: int | None, value: float, timeout: float = TIMEOUT
) -> ExtremeCell:
    """Measure one cell. Failures of the engine are outcomes, not exceptions.

    Args:
        sweep: a name of :data:`SWEEPS`.
        engine: a registered name.
        frequency: substeps a second; None for an engine that chooses its own steps.
        value: on the sweep's axis, in its unit.
        timeout: CPU seconds after which there is no verdict; checked after every substep.
    """
    warm_up(engine, 0)
    watch = Stopwatch(timeout)
    stage = Stage(engine, frequency or runs.SAMPLING, watch)
    try:
        finding = SWEEPS[sweep].measure(stage, value)
    except TimeoutExpiredError as reason:
        finding = Finding(Outcome.NO_VERDICT, note=str(reason))
    except NoValueError as reason:
        undefined = str(reason).startswith(runs.UNDEFINED)
        outcome = Outcome.UNDEFINED if undefined else Outcome.FAILED
        finding = Finding(outcome, note=str(reason))
    except EngineError as failure:
        finding = Finding(Outcome.NO_VERDICT, note=f"error: {failure}")
    numbers = {**finding.numbers, "cpu": 1e3 * watch.stop()[0].total}
    return ExtremeCell(sweep, engine, frequency, value, finding.outcome, numbers, finding.note)


def _block(stage: Stage) -> list[Box]:
    """3 x 3 x 3 cubes without gaps; 3 x 3 for an engine with two dimensions."""
    return scenes.pile(3**stage.facts.dimensions, stage.facts.dimensions)


_stable = partial(ExtremeSweep, stops=3)
_sized = partial(
    ExtremeSweep, axis="edge", unit="cm", values=_SIZES,
    close="as elsewhere, but moved by at most a hundredth of an edge where that is less",
    held="as elsewhere, but moved by at most one edge where that is less",
)  # fmt: skip
_formula = partial(ExtremeSweep, close=_NEAR, held=_ROUGH)
"""Sweeps that end after some failures, of the size of cubes, and compared with a closed form."""

SWEEPS = {
    sweep.name: sweep
    for sweep in (
        _stable(
            "tower", "Tower", f"Equal cubes of {_SIDE} on top of each other.", "cubes",
            (1, 2, 3, 5, 7, 10, 15, 20, 25, 30, 40, 50, 60, 70, 85, 100),
            lambda stage, n: settle(stage, scenes.tower(round(n))),
        ),
        ExtremeSweep(
            "heavy-on-light", "Heavy on light",
            f"A cube of {_SIDE} on another one, heavier by the mass ratio r: root r kg on "
            "1 / root r kg.",
            "mass ratio", _RATIOS,
            lambda stage, r: settle(stage, stacked(CUBE, (r**-0.5, r**0.5))),
        ),
        ExtremeSweep(
            "heavy-on-two", "Heavy on two light ones",
            "The same heavy cube on a tower of two light ones.", "mass ratio", _RATIOS,
            lambda stage, r: settle(stage, stacked(CUBE, (r**-0.5, r**-0.5, r**0.5))),
        ),
        ExtremeSweep(
            "light-on-heavy", "Light on heavy", "The light cube on the heavy one.",
            "mass ratio", _RATIOS, lambda stage, r: settle(stage, stacked(CUBE, (r**0.5, r**-0.5))),
        ),
        _sized(
            "size-two", "Size of two cubes", "A cube on an equal one, of the density of water.",
            measure=lambda stage, cm: settle(stage, scenes.tower(2, 0.01 * cm), sized=True),
        ),
        _sized(
            "size-five", "Size of five cubes", "A tower of five such cubes.",
            measure=lambda stage, cm: settle(stage, scenes.tower(5, 0.01 * cm), sized=True),
        ),
        _stable(
            "items", "Number of items",
            f"Cubes of {_SIDE} without gaps, layer by layer, as nearly a cube as can be; in two "
            "dimensions a square wall.",
            "cubes", (1, 2, 5, 10, 20, 35, 50, 75, 100, 150, 200),
            lambda stage, n: settle(stage, scenes.pile(round(n), stage.facts.dimensions)),
        ),
        _stable(
            "plates", "Pile of plates", "Plates of 1 x 100 x 100 cm, 10 kg each.", "plates",
            (1, 2, 3, 5, 8, 10, 15, 20, 30, 40, 50),
            lambda stage, n: settle(stage, stacked(scenes.PLATE, [scenes.PLATE_MASS] * round(n))),
        ),
        ExtremeSweep(
            "plate-on-edge", "Plate over an edge",
            "One such plate on a fixed table, its centre of mass before the edge (negative), where "
            "it stays, or past it, where it turns by more than 10 degrees within 0.3 s.",
            "past the edge", (-10, -5, -2, 5, 10),
            lambda stage, cm: measuring.plate(stage, 0.01 * cm), unit="cm",
            close="it stays within 1 mm and 0.5 degrees, or it falls",
            held="it stays within 10 cm and 10 degrees",
        ),
        ExtremeSweep(
            "grid-friction", "Grid at a friction",
            f"3 x 3 x 3 cubes of {_SIDE} without gaps (3 x 3 in two dimensions) at a friction.",
            "friction", _FRICTIONS,
            lambda stage, f: settle(stage, _block(stage), WorldSettings(friction=f)),
        ),
        ExtremeSweep(
            "grid-restitution", "Grid at a restitution",
            "The same grid at friction 0.5 and a restitution; where an engine imitates it on "
            "request, it is asked to.",
            "restitution", _RESTITUTIONS,
            lambda stage, e: settle(
                stage, _block(stage), runs.bouncing(stage, e) if e else WorldSettings()
            ),
        ),
        _formula(
            "sliding", "Sliding to a stop",
            f"Way of a flat box from {measuring.PUSHED:g} m/s to rest on level ground: "
            "v^2 / (2 mu g); without friction it keeps its speed.",
            "friction", _FRICTIONS, measuring.slide, quantity="way (m)", shown=0.5,
        ),
        _formula(
            "bounce", "Bounce",
            f"Height to which a cube rebounds over the {runs.DROP:g} m from which it fell: e^2.",
            "restitution", _RESTITUTIONS,
            # A hundredth of the drop counts as no rebound.
            lambda stage, e: compared(runs.bounce(stage, e), e**2, slack=0.01),
            quantity="rebound", shown=0.5,
            held=f"{_ROUGH}; at either limit a tenth of it, in per cent of the drop, on top",
        ),
        _formula(
            "tipping", "Tipping",
            f"Time in which a cube of {_SIDE} with its centre of mass past the edge of a fixed one "
            "turns by 10 degrees, against the equation of the pendulum.",
            "past the edge", (1, 2, 5, 10, 20),
            lambda stage, mm: compared(
                runs.time_to_turn(stage, 1e-3 * mm), runs.tipping_time(1e-3 * mm)
            ),
            unit="mm", quantity="time (s)", shown=10,
        ),
        _formula(
            "overhang", "Harmonic overhang",
            "Blocks of 20 x 10 x 5 cm, each standing out over the one below by f L / 2k: the f "
            "from which on a block turns by 10 degrees within 2 s, by bisection to 0.001; next "
            "to 1.",
            "blocks", (2, 3, 4, 6, 8),
            lambda stage, n: compared(
                runs.overhang(stage, round(n), width=0.01, resolution=1e-3), 1.0
            ),
            quantity="f", shown=4, resolution=0.1,
        ),
    )
}  # fmt: skip
"""All sweeps by name, in the order of the page."""
