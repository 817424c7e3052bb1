"""Errors of engines against the record, put together for the page."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from types import SimpleNamespace

import numpy as np
import pandas as pd

from steadyload.engines.world import Support
from steadyload.reports import frames
from steadyload.statistics.estimate import Estimate
from steadyload.studies.reality import errors
from steadyload.studies.reality.chances import AS_MEASURED, calibration
from steadyload.studies.reality.fitting import OFF_CM, TURN_DEG
from steadyload.studies.reality.loading import (
    FRICTION,
    changed,
    differences,
    rankings,
    verdicts,
)
from steadyload.studies.reality.record import FIT, MEASURED, Recorded
from steadyload.studies.reality.running import FREQUENCY, JITTERS, AllMeasured, ByEngine, Way
from steadyload.studies.reality.tosses import worst


class Found(SimpleNamespace):
    """All that the page shows."""

    recorded: Recorded
    measured: AllMeasured
    made_with: Mapping[str, str]


def compare(found: AllMeasured) -> Found:
    """Errors of all engines; every interval resamples trials."""
    recorded, engines = found.recorded, found.engines
    faces = {toss.name: toss.face for toss in recorded.tosses}
    trials = Counter(toss.half for toss in recorded.tosses)
    thrown = errors.throws(found)
    fitted = thrown[thrown["way"] == Way.FITTED]
    measured = thrown[thrown["half"] == MEASURED]
    measured_fitted = fitted[fitted["half"] == MEASURED]
    costs = _costs(engines, trials[FIT])
    guesses = errors.guesses(recorded, found.taken.scale)
    all_fitted = errors.errors(pd.concat([measured_fitted, guesses]), ["engine", "name"])
    all_fitted = all_fitted.reset_index().merge(costs[["engine", "throw_cpu"]], "left", "engine")
    *by_engine, released, landed = frames.records(all_fitted)
    best = max(engines, key=lambda one: one.fitted.closeness).title
    as_good = errors.as_good_as(best, measured_fitted)
    near_best = sorted(
        (one for one in by_engine if one["engine"] in as_good),
        key=lambda one: one["right_face"].value,
    )
    presets = errors.errors(measured[measured["way"] == Way.PRESET], ["engine"])
    flights = _flights(recorded)
    chances = [
        {"engine": one.title, "name": one.name, **each}
        for one in engines
        if one.jittered
        for each in calibration(one.jittered, faces)
    ]
    chosen = [one for one in chances if one["chosen"]]
    plain = [one for one in chances if (one["half"], one["factor"]) == (MEASURED, AS_MEASURED)]
    fitted_values = pd.DataFrame(
        [
            each
            for one in engines
            for each in differences(one.title, one.preset, one.label, one.fitted)
        ]
    )
    reference = next((one for one in engines if one.is_reference), None)
    verdicts_changed, lost = _verdicts_changed(engines, reference), worst(found)
    judged = [one for one in engines if one.evaluation is not None]
    return Found(
        recorded=recorded,
        best=best,
        fitted=by_engine,
        released=released,
        landed=landed,
        all_fitted=all_fitted,
        near_best=[one["engine"] for one in near_best if one["engine"] != best],
        shown=sorted(as_good[one["engine"]] for one in near_best if one["engine"] != best),
        ways=errors.by_half(thrown[thrown["way"].isin(list(Way))]),
        presets=frames.records(presets.reset_index()),
        without_restitution=[e.title for e in engines if e.restitution is Support.IGNORED],
        emulating=[e.title for e in engines if e.restitution is Support.ON_REQUEST],
        sliding_badly=[one.title for one in engines if one.slides_badly],
        slow=[one.title for one in engines if one.slow],
        missing=found.missing,
        flight=flights.loc[FIT],
        flights=flights,
        steps=errors.steps(thrown),
        stepped=sum(bool(one.steps) for one in engines),
        by_time=frames.records(errors.by_time(fitted)),
        by_impacts=frames.records(errors.by_impacts(fitted)),
        rests=errors.rests(fitted, recorded),
        costs=costs,
        friction=frames.records(_closeness(engines, FRICTION)),
        chosen=pd.DataFrame(chosen),
        plain=pd.DataFrame(plain),
        surest=min(chosen, key=lambda one: one["log_loss"].value, default=None),
        by_factor=[one for one in chances if one["half"] == FIT],
        bins=[
            {"engine": one["engine"], "name": one["name"], "mean": b.mean, "happened": b.happened}
            for one in chosen
            for b in one["bins"]
        ],
        differences=fitted_values,
        differing=fitted_values["differs"].sum(),
        changed=verdicts_changed,
        rankings=rankings(verdicts_changed, reference.title if reference else ""),
        ranked=sum(not one.is_reference for one in judged),
        worst=pd.DataFrame(lost),
        alike=sum(len(one["predicted"]) == 1 for one in lost),
        departure_mm=1e3 * float(np.median([toss.departure_m for toss in recorded.tosses])),
        measured_trials=trials[MEASURED],
        fit_trials=trials[FIT],
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


def _verdicts_changed(engines: Sequence[ByEngine], reference: ByEngine | None) -> pd.DataFrame:
    """Of the engines that judged layouts, each beside the reference, where that did, too."""
    by_reference: Mapping[str, pd.Series] = {}
    if reference is not None and reference.evaluation is not None:
        by_reference = verdicts(reference.preset, reference.fitted, reference.evaluation)
    return pd.DataFrame(
        [
            each
            for one in engines
            if one.evaluation is not None
            for each in changed(one.title, one.preset, one.fitted, one.evaluation, by_reference)
        ]
    )


def _flights(recorded: Recorded) -> pd.DataFrame:
    """Facts of free flight: of the body and of its record, by the trials that they are of."""
    rows = []
    for trials, facts in recorded.flights.items():
        offset = dict(zip(["x_mm", "y_mm", "z_mm"], map(_in_mm, facts.mass_offset), strict=True))
        about = {"trials": trials, "n": facts.gravity.n, **offset}
        rows.append({**about, "gravity": facts.gravity, "scale": facts.scale})
    return pd.DataFrame(rows, index=list(recorded.flights))


def _in_mm(metres: Estimate) -> Estimate:
    return Estimate(1e3 * metres.value, 1e3 * metres.low, 1e3 * metres.high, metres.n)


def _costs(engines: Sequence[ByEngine], trials: int) -> pd.DataFrame:
    """CPU time by engine; ``trials``: on the half for fitting."""
    return pd.DataFrame(
        [
            {
                "engine": one.title,
                "throw_cpu": one.trial_ms(trials),
                "fit_s": one.fitted.cpu_s if one.is_timed else None,
                "tried": len(one.fitted.tried),
                "jitters_s": sum(each.cpu_s for each in one.jittered.values()) or None,
            }
            for one in engines
        ]
    )


def _seconds(one: ByEngine) -> float:
    """CPU time of an engine, all of it [s]; a batch counts once."""
    batches = {id(each): each for each in (*one.batches.values(), *one.steps.values())}
    return (
        sum(each.cpu_s for each in batches.values())
        + one.fitted.cpu_s
        + sum(each.cpu_s for each in one.jittered.values())
    )


def _closeness(engines: Sequence[ByEngine], gene: str) -> pd.DataFrame:
    """How close the trials of the half for fitting end at best, by value of a contact parameter."""
    tried = [
        [one.title, one.name, each.parameters[gene], each.closeness]
        for one in engines
        for each in sorted(one.fitted.tried, key=lambda each: each.parameters[gene])
    ]
    by = ["engine", "name", "value"]
    found = pd.DataFrame(tried, columns=[*by, "closeness"])
    return found.groupby(by, sort=False)["closeness"].max().reset_index()
