"""Errors of engines against the record, put together for the page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from types import SimpleNamespace

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
from steadyload.studies.reality.fitting import OFF_CM, TURN_DEG
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


class Found(SimpleNamespace):
    """All that the page shows."""

    recorded: Recorded
    best: Errors
    fitted: Sequence[Errors]
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
    measured: AllMeasured
    all_fitted: Sequence[Errors]
    released: Errors
    landed: Errors
    near_best: Sequence[Errors]
    presets: Sequence[Errors]
    chosen: Sequence[Chances]
    plain: Sequence[Chances]
    surest: Chances | None
    flight: Flight
    made_with: Mapping[str, str]


def compare(found: AllMeasured) -> Found:
    """Errors of all engines; every interval resamples trials."""
    recorded, engines = found.recorded, found.engines
    faces = {toss.name: toss.face for toss in recorded.tosses}
    scale, tosses = found.taken.scale, of_half(recorded, MEASURED)
    fitted = {one.name: errors_of(one, Way.FITTED, recorded, MEASURED) for one in engines}
    closest = max(engines, key=lambda one: one.fitted.closeness)
    best, as_good = fitted[closest.name], as_good_as(closest.title, found)
    guesses = [
        guessed("stays as released", [toss.as_released for toss in tosses], scale),
        guessed("stays as it lands", [toss.as_landed for toss in tosses], scale),
    ]
    near_best = sorted(
        (one for one in fitted.values() if one.engine in as_good), key=lambda one: one.face.value
    )
    ways = [both_halves(one, way, recorded) for one in engines for way in one.batches]
    flights = {name: _flight(name, facts) for name, facts in recorded.flights.items()}
    calibrations = [
        calibration(one.title, one.name, one.jittered, faces) for one in engines if one.jittered
    ]
    chosen = [one.chosen for one in calibrations]
    fitted_values = [
        each
        for one in engines
        for each in differences(one.title, one.preset, one.label, one.fitted)
    ]
    reference = next((one for one in engines if one.is_reference), None)
    verdicts_changed, lost = _verdicts_changed(engines, reference), worst(found)
    judged = [one for one in engines if one.evaluation is not None]
    return Found(
        recorded=recorded,
        best=best,
        fitted=list(fitted.values()),
        released=guesses[0],
        landed=guesses[1],
        all_fitted=[*fitted.values(), *guesses],
        near_best=near_best,
        shown=sorted(as_good[one.engine] for one in near_best if one != best),
        ways=ways,
        presets=[one.measured for one in ways if one.way == Way.PRESET],
        without_restitution=[e.title for e in engines if e.restitution is Support.IGNORED],
        emulating=[e.title for e in engines if e.restitution is Support.ON_REQUEST],
        sliding_badly=[one.title for one in engines if one.slides_badly],
        slow=[one.title for one in engines if one.slow],
        missing=found.missing,
        flight=flights[FIT],
        flights=list(flights.values()),
        steps=list(steps_of(found)),
        by_time=[point for one in engines for point in by_time(one)],
        by_impacts=[point for one in engines for point in by_impacts(one)],
        rests=[rest_of(one, recorded) for one in engines],
        costs=[_cost(one, len(of_half(recorded, FIT))) for one in engines],
        friction=[point for one in engines for point in _by_value(one, "friction")],
        calibrations=calibrations,
        chosen=chosen,
        plain=[one.plain for one in calibrations],
        surest=min(chosen, key=lambda one: one.log_loss.value, default=None),
        differences=fitted_values,
        differing=sum(one.differs for one in fitted_values),
        changed=verdicts_changed,
        rankings=rankings(verdicts_changed, reference.title if reference else ""),
        ranked=sum(not one.is_reference for one in judged),
        worst=lost,
        alike=sum(one.alike for one in lost),
        departure_mm=1e3 * float(np.median([toss.departure_m for toss in recorded.tosses])),
        measured_trials=best.trials,
        fit_trials=len(recorded.tosses) - best.trials,
        height_mm=1e3 * recorded.height_m,
        noise_mm=1e3 * recorded.noise.position_m,
        noise_cms=1e2 * recorded.noise.velocity_ms,
        jitters=JITTERS,
        frequency=FREQUENCY,
        half_off_cm=OFF_CM,
        half_turn_deg=TURN_DEG,
        cpu_hours=sum(map(_seconds, engines)) / 3600.0,
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
    return Flight(name, facts.gravity.n, x, y, z, facts.gravity, facts.scale)


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
