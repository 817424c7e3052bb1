"""Errors of engines against the record, put together for the page."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import pandas as pd

from steadyload.engines.world import Support
from steadyload.measured.flight import FlightFacts
from steadyload.reports.columns import (
    column,
    decimal,
    fixed,
    one_decimal,
    row,
    significant,
)
from steadyload.statistics.estimate import Estimate
from steadyload.studies.reality.chances import Calibration, Chances, calibration
from steadyload.studies.reality.errors import (
    BothHalves,
    Errors,
    Step,
    as_good_as,
    both_halves,
    errors_of,
    guessed,
    of_half,
    steps_of,
)
from steadyload.studies.reality.fitting import OFF_CM, SPACE, TURN_DEG
from steadyload.studies.reality.loading import (
    Changed,
    Difference,
    Ranking,
    changed,
    differences,
    rankings,
    verdicts,
)
from steadyload.studies.reality.on_the_way import Grown, Rest, by_impacts, by_time, rest_of
from steadyload.studies.reality.record import FIT, MEASURED, Recorded
from steadyload.studies.reality.running import FREQUENCY, JITTERS, AllMeasured, ByEngine, Way
from steadyload.studies.reality.tosses import Worst, worst


@row
class Flight:
    """Facts of free flight: of the body and of its record, by the trials that they are of."""

    trials: str = column("trials", left=True)
    n: int = column()
    x_mm: Estimate = column("centre of mass, x mm", one_decimal)
    y_mm: Estimate = column("y mm", one_decimal)
    z_mm: Estimate = column("z mm", one_decimal)
    gravity: Estimate = column("gravity m/s2", decimal)
    offset_mm: float
    scale: float = column("lengths times", lambda scale: fixed(scale, 3))


@row
class Cost:
    """CPU time of an engine."""

    engine: str = column(left=True)
    trial_ms: float | None = column("ms a throw", significant)
    fit_s: float | None = column("fit s", fixed)
    tried: int = column("sets tried")
    jitters_s: float | None = column("jitters s", fixed)


@row
class Closeness:
    """How close the trials of the half for fitting end, by a contact parameter.

    Of all sets with that value the closest one counts.
    """

    engine: str
    name: str
    value: float
    closeness: float


@row
class Found:
    """Everything the page shows.

    Attributes:
        best: the engine that is closest on the half for fitting, on the other half with the
            contacts fitted.
        as_good: see :func:`steadyload.studies.reality.errors.as_good_as`.
    """

    recorded: Recorded
    best: Errors
    as_good: Mapping[str, float]
    fitted: Sequence[Errors]
    guesses: Sequence[Errors]
    ways: Sequence[BothHalves]
    flights: Sequence[Flight]
    steps: Sequence[Step]
    by_time: Sequence[Grown]
    by_impacts: Sequence[Grown]
    rests: Sequence[Rest]
    costs: Sequence[Cost]
    friction: Sequence[Closeness]
    calibrations: Sequence[Calibration]
    differences: Sequence[Difference]
    changed: Sequence[Changed]
    rankings: Sequence[Ranking]
    worst: Sequence[Worst]
    missing: Sequence[str]
    scale: float
    cpu_hours: float
    made_with: Mapping[str, str]
    measured: AllMeasured
    frequency: int = FREQUENCY
    jitters: int = JITTERS
    space: str = SPACE
    half_off_cm: float = OFF_CM
    half_turn_deg: float = TURN_DEG

    @property
    def all_fitted(self) -> Sequence[Errors]:
        """Fitted engines on the half that is measured, and guesses."""
        return [*self.fitted, *self.guesses]

    @property
    def released(self) -> Errors:
        """The guess that a body stays as it is released."""
        return self.guesses[0]

    @property
    def landed(self) -> Errors:
        """The guess that it flies freely and stays as it first touches the floor."""
        return self.guesses[1]

    @property
    def near_best(self) -> Sequence[Errors]:
        """Engines whose right faces do not differ significantly from the best one's, and that one,
        by their right faces.
        """
        own = [one for one in self.fitted if one.engine in self.as_good]
        return sorted(own, key=lambda one: one.face.value)

    @property
    def shown(self) -> Sequence[float]:
        """Least differences from the best one that the throws show, of others in `near_best`."""
        return sorted(self.as_good[one.engine] for one in self.near_best if one != self.best)

    @property
    def presets(self) -> Sequence[Errors]:
        """Engines with presets, on the half that is measured."""
        return [one.measured for one in self.ways if one.way == Way.PRESET]

    @property
    def without_restitution(self) -> Sequence[str]:
        """Titles of engines that have no coefficient of restitution."""
        return [e.title for e in self.measured.engines if e.restitution is Support.IGNORED]

    @property
    def emulating(self) -> Sequence[str]:
        """Titles of engines that emulate one."""
        return [e.title for e in self.measured.engines if e.restitution is Support.ON_REQUEST]

    @property
    def sliding_badly(self) -> Sequence[str]:
        """Titles of engines that declare to fail the check of a fast slide."""
        return [one.title for one in self.measured.engines if one.slides_badly]

    @property
    def usual_departure_mm(self) -> float:
        """By how much a record departs from free flight before its first contact, median [mm]."""
        return 1e3 * float(np.median([toss.departure_m for toss in self.recorded.tosses]))

    @property
    def ranked(self) -> int:
        """Engines that judged layouts, without the reference."""
        own = [one for one in self.measured.engines if one.evaluation is not None]
        return sum(not one.is_reference for one in own)

    @property
    def slow(self) -> Sequence[str]:
        """Titles of the engines that run once a trial, without jitters."""
        return [one.title for one in self.measured.engines if one.slow]

    @property
    def measured_trials(self) -> int:
        """Trials of the half on which errors are measured."""
        return self.best.trials

    @property
    def fit_trials(self) -> int:
        """Trials of the half on which contacts are fitted."""
        return len(self.recorded.tosses) - self.best.trials

    @property
    def chosen(self) -> Sequence[Chances]:
        """Chances on the half that is measured, with the factor that was chosen."""
        return [one.chosen for one in self.calibrations]

    @property
    def plain(self) -> Sequence[Chances]:
        """Likewise with the noise as it is."""
        return [one.plain for one in self.calibrations]

    @property
    def surest(self) -> Chances | None:
        """Chances of least log loss; None where none are jittered."""
        return min(self.chosen, key=lambda one: one.log_loss.value, default=None)

    @property
    def alike(self) -> int:
        """Trials that all engines get wrong in the same way."""
        return sum(one.alike for one in self.worst)

    @property
    def flight(self) -> Flight:
        """Facts of the flights of the half for fitting, which engines are given."""
        return next(one for one in self.flights if one.trials == FIT)

    @property
    def height_mm(self) -> float:
        """Height of the centre at rest in the record, median [mm]."""
        return 1e3 * self.recorded.height_m

    @property
    def noise_mm(self) -> float:
        """Noise of a released position [mm]."""
        return 1e3 * self.recorded.noise.position_m

    @property
    def noise_cms(self) -> float:
        """Noise of a released velocity [cm/s]."""
        return 1e2 * self.recorded.noise.velocity_ms

    @property
    def differing(self) -> Sequence[Difference]:
        """Fitted parameters that differ from those of the preset."""
        return [one for one in self.differences if one.differs]


def compare(found: AllMeasured) -> Found:
    """Errors of all engines; every interval resamples trials."""
    recorded = found.recorded
    faces = {toss.name: toss.face for toss in recorded.tosses}
    scale, tosses = found.taken.scale, of_half(recorded, MEASURED)
    fitted = {one.name: errors_of(one, Way.FITTED, recorded, MEASURED) for one in found.engines}
    closest = max(found.engines, key=lambda one: one.fitted.closeness)
    jittered = [one for one in found.engines if one.jittered]
    reference = next((one for one in found.engines if one.is_reference), None)
    verdicts_changed = _verdicts_changed(found.engines, reference)
    return Found(
        recorded=recorded,
        best=fitted[closest.name],
        as_good=as_good_as(closest.title, found),
        fitted=list(fitted.values()),
        guesses=[
            guessed("stays as released", [toss.as_released for toss in tosses], scale),
            guessed("stays as it lands", [toss.as_landed for toss in tosses], scale),
        ],
        ways=[both_halves(one, way, recorded) for one in found.engines for way in one.batches],
        flights=[_flight(name, facts) for name, facts in recorded.flights.items()],
        steps=list(steps_of(found)),
        by_time=[point for one in found.engines for point in by_time(one)],
        by_impacts=[point for one in found.engines for point in by_impacts(one)],
        rests=[rest_of(one, recorded) for one in found.engines],
        costs=[_cost(one, len(of_half(recorded, FIT))) for one in found.engines],
        friction=[point for one in found.engines for point in _by_value(one, "friction")],
        calibrations=[calibration(one.title, one.name, one.jittered, faces) for one in jittered],
        differences=[
            each
            for one in found.engines
            for each in differences(one.title, one.preset, one.label, one.fitted)
        ],
        changed=verdicts_changed,
        rankings=rankings(verdicts_changed, reference.title if reference else ""),
        worst=worst(found),
        missing=found.missing,
        scale=scale,
        cpu_hours=sum(map(_seconds, found.engines)) / 3600.0,
        made_with=found.made_with,
        measured=found,
    )


def _verdicts_changed(engines: Sequence[ByEngine], reference: ByEngine | None) -> list[Changed]:
    """Of the engines that judged layouts, each beside the reference, where that did, too."""
    by_reference: Mapping[str, pd.Series] = {}
    if reference is not None and reference.evaluation is not None:
        by_reference = verdicts(reference.preset, reference.fitted, reference.evaluation)
    return [
        each
        for one in engines
        if one.evaluation is not None
        for each in changed(one.title, one.preset, one.fitted, one.evaluation, by_reference)
    ]


def _flight(name: str, facts: FlightFacts) -> Flight:
    x, y, z = (_in_mm(part) for part in facts.mass_offset)
    offset_mm = math.hypot(x.value, y.value, z.value)
    return Flight(name, facts.gravity.n, x, y, z, facts.gravity, offset_mm, facts.scale)


def _in_mm(metres: Estimate) -> Estimate:
    return Estimate(1e3 * metres.value, 1e3 * metres.low, 1e3 * metres.high, metres.n)


def _cost(one: ByEngine, trials: int) -> Cost:
    return Cost(
        one.title,
        one.trial_ms(trials),
        one.fitted.cpu_s if one.is_timed else None,
        len(one.fitted.tried),
        sum(each.cpu_s for each in one.jittered.values()) if one.jittered else None,
    )


def _seconds(one: ByEngine) -> float:
    """CPU time of an engine, all of it [s]; a batch counts once."""
    batches = {id(each): each for each in (*one.batches.values(), *one.steps.values())}
    return (
        sum(each.cpu_s for each in batches.values())
        + one.fitted.cpu_s
        + sum(each.cpu_s for each in one.jittered.values())
    )


def _by_value(one: ByEngine, gene: str) -> Iterator[Closeness]:
    best: dict[float, float] = {}
    for tried in one.fitted.tried:
        value = tried.parameters[gene]
        best[value] = max(best.get(value, 0.0), tried.closeness)
    for value in sorted(best):
        yield Closeness(one.title, one.name, value, best[value])
