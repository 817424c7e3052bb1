"""Tests of engines by quantities whose values are known from mechanics."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np

from steadyload.engines.world import EngineError
from steadyload.properties import closed_forms as runs
from steadyload.properties import mechanics, rocking

BLOCK_COUNTS = (2, 3, 4, 5, 6, 7, 8)

ROCKING_SHARES = (0.2, 0.5, 0.8)

PULSES = (0.2, 0.5)
"""Durations of half sines of ground acceleration [s]."""

MASS_RATIOS = (1e1, 1e2, 1e3, 1e4, 1e5)

_REGULARISED = (
    "regularised friction needs a sliding speed to hold: 0.09 mm/s at 0.99 of the limit, which is "
    "how far a body at rest creeps in a second and what delays a body that slides"
)

_COMPLIANT = (
    "a compliant contact gives way under the load, by the load over the stiffness, and while it "
    "does it lets the body turn a little"
)


@dataclass(frozen=True, slots=True)
class ClosedFormTest:
    """A quantity whose value is known from mechanics.

    ``series`` is the heading; tests that differ in one number share it and have that number as
    ``argument``, named ``argument_name``. ``expected`` is in ``unit``. An error is the difference
    in ``unit``, or in per cent of the expected value where ``relative``. ``resolution``, in the
    unit of the error: smaller errors count as none. ``when_soft``: the reason why an engine with
    compliant contact and regularised friction cannot be exact here, however small its steps.
    ``measure``: what an engine finds; None where results come from another study.
    """

    name: str
    series: str
    definition: str
    expected: float
    unit: str
    relative: bool
    resolution: float
    argument: float | None = None
    argument_name: str = ""
    when_soft: str = ""
    measure: Callable[[runs.Stage], float] | None = None

    @property
    def error_unit(self) -> str:
        """Per cent, or the unit of the measured quantity."""
        return "%" if self.relative else self.unit


@dataclass(frozen=True, slots=True)
class ClosedFormResult:
    """Result of one engine: ``found`` in the test's unit, ``error`` in its error unit.

    ``frequency`` is None for an engine that chooses its own steps. ``note`` gives the reason why
    there is no value, or a remark on it.
    """

    test: str
    engine: str
    frequency: int | None
    found: float | None
    error: float | None
    note: str = ""

    @property
    def defined(self) -> bool:
        """Whether the test asks for nothing that the engine does not have."""
        return not self.note.startswith(runs.UNDEFINED)


def closed_form_tests() -> list[ClosedFormTest]:
    """All tests, in the order of the page."""
    return [*_tests(), *rocking_tests()]


def result_of(test: ClosedFormTest, stage: runs.Stage, frequency: int | None) -> ClosedFormResult:
    """Result of a test on a stage; ``frequency`` as the result has it."""
    assert test.measure is not None, "a test of this study"
    note, found = "", None
    try:
        with np.errstate(all="ignore"):  # a diverging state
            found = test.measure(stage)
    except runs.NoValueError as reason:
        note = str(reason)
    except EngineError as failure:
        note = f"error: {failure}"
    if found is None:
        return ClosedFormResult(test.name, stage.engine, frequency, None, None, note)
    error = found - test.expected
    if test.relative:
        error *= 100.0 / test.expected
    return ClosedFormResult(test.name, stage.engine, frequency, found, error)


@cache
def _tests() -> tuple[ClosedFormTest, ...]:
    single = (
        ClosedFormTest(
            "free fall",
            "Free fall",
            f"Change of height of a box that falls for {runs.FALL_SECONDS} s: -g t^2 / 2.",
            1e3 * mechanics.height_change(runs.FALL_SECONDS),
            unit="mm",
            relative=False,
            resolution=1e-9,
            measure=runs.fall,
        ),
        ClosedFormTest(
            "intermediate-axis spin",
            "Spin about the intermediate axis",
            "Angle between the attitude found and that of Euler's equations after 1 s without "
            "gravity: a box of 10, 20 and 30 cm with 10 rad/s about its intermediate axis and "
            "0.1 rad/s about the two others, which turns over in that time. 3-D engines only.",
            0.0,
            unit="deg",
            relative=False,
            resolution=1e-6,
            measure=runs.spin,
        ),
        ClosedFormTest(
            "sliding distance",
            "Sliding distance",
            "Way of a flat box in 1 s from rest on a slope of 0.6 at friction 0.5: "
            "g (sin - 0.5 cos) t^2 / 2.",
            mechanics.slid(0.6, runs.FRICTION, runs.SLIDE_SECONDS),
            unit="m",
            relative=True,
            resolution=1e-7,
            when_soft=_REGULARISED,
            measure=partial(runs.way, slope=0.6),
        ),
        ClosedFormTest(
            "sliding threshold",
            "Sliding threshold",
            "The slope, by bisection to 1e-5, on which a flat box slides in 1 s from rest as "
            "far as it should on 1.005 times the limit at friction 0.5: 11.0 mm. A box that "
            "creeps by less than 0.1 mm (friction regularised at 0.1 mm/s) shifts it by less "
            "than 0.005 %.",
            runs.BEYOND * runs.FRICTION,
            unit="",
            relative=True,
            resolution=1e-3,
            when_soft=_REGULARISED,
            measure=runs.sliding_threshold,
        ),
        ClosedFormTest(
            "creep",
            "Creep below the limit",
            "Way of a flat box in 1 s on a slope of 0.99 times the limit, on which it stays.",
            0.0,
            unit="mm",
            relative=False,
            resolution=1e-6,
            when_soft=_REGULARISED,
            measure=lambda stage: 1e3 * runs.way(stage, 0.99 * runs.FRICTION),
        ),
        ClosedFormTest(
            "tipping offset",
            "Tipping offset",
            "Where the centre of mass of the upper of two cubes of 10 cm stands, relative to "
            "the edge of the lower one, when it just turns over by 10 degrees within 3 s; by "
            "bisection to 0.001 mm. Negative: it tips too early.",
            0.0,
            unit="mm",
            relative=False,
            resolution=1e-3,
            when_soft=_COMPLIANT,
            measure=runs.tipping_offset,
        ),
        *(
            ClosedFormTest(
                f"time to 10 degrees, {past:g} mm",
                f"Tipping from {past:g} mm past the edge",
                f"Time in which a cube of 10 cm whose centre of mass stands {past:g} mm past "
                "the edge of a fixed one turns by 10 degrees about that edge, at friction 5, "
                "against the equation of the pendulum; sampled every substep, by a spline.",
                runs.tipping_time(1e-3 * past),
                unit="s",
                relative=True,
                resolution=1e-4,
                when_soft=_COMPLIANT,
                measure=partial(runs.time_to_turn, past_edge=1e-3 * past),
            )
            for past in (10.0, 1.0)
        ),
        ClosedFormTest(
            "bounce",
            "Bounce",
            "Height to which a cube rebounds over the 0.2 m from which it fell, at restitution "
            "0.5: e^2. Where an engine imitates restitution on request, it is asked to.",
            runs.RESTITUTION**2,
            unit="",
            relative=True,
            resolution=1e-6,
            measure=runs.bounce,
        ),
    )
    stacks = tuple(
        ClosedFormTest(
            f"overhang of {count}",
            "Harmonic overhang",
            "Blocks of 20 x 10 x 5 cm on the floor, each standing out over the one below by "
            "f L / 2k (k counted from the top): the f, next to 1, from which on a block turns "
            "by 10 degrees within 2 s, by bisection to 1e-5. At f = 1 every upper part is just "
            "in balance.",
            1.0,
            unit="",
            relative=True,
            resolution=1e-3,
            argument=float(count),
            argument_name="blocks",
            when_soft=_COMPLIANT,
            measure=partial(runs.overhang, count=count),
        )
        for count in BLOCK_COUNTS
    )
    loads = tuple(
        ClosedFormTest(
            f"sink under {ratio:g}",
            "Sink under a heavy load",
            "How far a cube of 10 cm sinks in 1 s that stands on a cube of 1 kg and has the "
            "given multiple of its mass; 100 mm is the whole height: it fell through.",
            0.0,
            unit="mm",
            relative=False,
            resolution=1e-6,
            argument=ratio,
            argument_name="mass ratio",
            when_soft="a contact of stiffness K gives way by the load over K: the load is all "
            "there is to see, at any mass ratio",
            measure=partial(runs.sink, ratio=ratio),
        )
        for ratio in MASS_RATIOS
    )
    return (*single, *stacks, *loads)


@cache
def rocking_tests() -> tuple[ClosedFormTest, ...]:
    """Those of a block that rocks."""
    return (
        *(
            ClosedFormTest(
                f"rocking from {share:g} alpha",
                "Period of free rocking",
                "Time in which a block of 10 x 10 x 40 cm, released at rest on an edge at the "
                "given share of the angle alpha at which it stands over it, falls back to its "
                "base, a quarter of a period, at friction 1: by a'' = -p^2 sin(alpha - a), p^2 = "
                "3 g / (4 R); for a slender block acosh(1 / (1 - share)) / p (Housner 1963).",
                rocking.time_to_impact(runs.ROCKING, share),
                unit="s",
                relative=True,
                resolution=1e-3,
                argument=share,
                argument_name="amplitude over alpha",
                when_soft=_COMPLIANT,
                measure=partial(runs.time_to_impact, share=share),
            )
            for share in ROCKING_SHARES
        ),
        *(
            ClosedFormTest(
                f"energy after rocking from {share:g} alpha",
                "Energy after an impact of rocking",
                "Share of the energy that the first impact leaves to that block, released at the "
                "given share of alpha, by the angle of its next turning point: (1 - 3/2 sin^2 "
                "alpha)^2 of Housner (1963), who keeps the angular momentum about the edge that "
                "is struck.",
                rocking.energy_after_impact(runs.ROCKING),
                unit="",
                relative=True,
                resolution=1e-3,
                argument=share,
                argument_name="amplitude over alpha",
                when_soft=_COMPLIANT,
                measure=partial(runs.energy_after_impact, share=share),
            )
            for share in ROCKING_SHARES
        ),
        *(
            ClosedFormTest(
                f"overturning by a pulse of {seconds:g} s",
                "Overturning by a pulse of the ground",
                "The least peak of a half sine of horizontal acceleration of the ground, over g "
                "tan(alpha), that overturns that block at rest, by bisection to 2e-4: by its "
                "equation of motion from the moment it lifts off, as Shi et al. (1996) corrected "
                "Housner (1963).",
                rocking.overturning_pulse(runs.ROCKING, seconds),
                unit="",
                relative=True,
                resolution=1e-2,
                argument=seconds,
                argument_name="duration in s",
                when_soft=_COMPLIANT,
                measure=partial(runs.overturning_pulse, seconds=seconds),
            )
            for seconds in PULSES
        ),
    )
