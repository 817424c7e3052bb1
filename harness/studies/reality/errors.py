"""Errors of rest by engine: with contacts of every source, and by what the body is taken to be."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial

import numpy as np

from steadyload.reports.columns import (
    column,
    decimal,
    fixed,
    one_decimal,
    percent,
    row,
    significant,
)
from steadyload.runs.comparison import detectable
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, median, quantile, share
from steadyload.studies.reality.record import FIT, MEASURED, Guess, Recorded, Toss
from steadyload.studies.reality.releasing import Batch, Ended
from steadyload.studies.reality.running import AllMeasured, ByEngine, Way

_whole = partial(decimal, digits=0)

FITTED_CONTACTS = "fitted contacts"
"""Title of the last step of :func:`steps_of`."""

MOST = 0.9
"""Share of the trials in the second figure of how far rest is off."""


@row
class Errors:
    """Errors of an engine, or of a guess without one, on trials of a half.

    A failed simulation has the wrong face, and is farther off than any.
    """

    engine: str = column("", left=True)
    name: str
    way: str = column(left=True)
    half: str = column(left=True)
    trials: int = column("n")
    face: Estimate = column("right face %", percent)
    off_cm: Estimate = column("rest off cm, median", one_decimal)
    most_cm: Estimate = column("90 % within cm", one_decimal)
    turn_deg: Estimate = column("attitude off degrees, median", _whole)
    cpu_ms: float | None = column("CPU ms", significant, "a throw")


@row
class BothHalves:
    """Errors of an engine with contacts of one source, on both halves."""

    engine: str = column(left=True)
    way: str = column("contact", left=True)
    fit: Errors
    measured: Errors


@row
class Step:
    """Errors with one thing more that is taken from the record, all engines together.

    Attributes:
        gain: points of right faces more than with the step before, of the same throws and engines.
    """

    step: str = column("what is taken from the record", left=True)
    face: Estimate = column("right face %", percent)
    gain: Estimate | None = column("more than before, points", percent)
    off_cm: float = column("rest off cm, median", lambda cm: fixed(cm, 1))
    turn_deg: float = column("attitude off degrees, median", fixed)
    by_engine: Mapping[str, Estimate] = column("{}: right face %", percent)


def of_half(recorded: Recorded, half: str) -> list[Toss]:
    """The trials of a half of a record."""
    return [toss for toss in recorded.tosses if toss.half == half]


def _ends(batch: Batch, recorded: Recorded, half: str) -> list[Ended]:
    own = {toss.name for toss in of_half(recorded, half)}
    return [end for end in batch.ended if end.name in own]


def errors_of(one: ByEngine, way: Way, recorded: Recorded, half: str) -> Errors:
    """Errors of an engine on the trials of a half, with contacts of one source."""
    batch = one.batches[way]
    ends = _ends(batch, recorded, half)
    return _errors(
        one.title, one.name, way, half,
        [end.same_face for end in ends],
        [math.inf if end.off_m is None else 100.0 * end.off_m for end in ends],
        [180.0 if end.turn_deg is None else end.turn_deg for end in ends],
        one.trial_ms(len(of_half(recorded, FIT))),
    )  # fmt: skip


def guessed(title: str, guesses: Sequence[Guess], scale: float) -> Errors:
    """Errors of guesses without an engine, on the trials of the half that is measured.

    Args:
        title: of the guess.
        guesses: one a trial, in lengths of the record.
        scale: that these are multiplied by.
    """
    return _errors(
        title, "", "", MEASURED,
        [one.same_face for one in guesses],
        [100.0 * scale * one.off_m for one in guesses],
        [one.turn_deg for one in guesses],
        None,
    )  # fmt: skip


def _errors(
    engine: str,
    name: str,
    way: str,
    half: str,
    faces: Sequence[bool],
    off_cm: Sequence[float],
    turns: Sequence[float],
    cpu_ms: float | None,
) -> Errors:
    return Errors(
        engine,
        name,
        str(way),
        half,
        len(faces),
        share(list(faces)),
        median(off_cm),
        quantile(off_cm, MOST),
        median(turns),
        cpu_ms,
    )


def both_halves(one: ByEngine, way: Way, recorded: Recorded) -> BothHalves:
    """Errors of an engine on both halves, with contacts of one source."""
    fit, measured = (errors_of(one, way, recorded, half) for half in (FIT, MEASURED))
    return BothHalves(one.title, str(way), fit, measured)


def steps_of(found: AllMeasured) -> Iterator[Step]:
    """Errors by what is taken from the record, on the half that is measured.

    First the body, with the contacts that the record states, and fitted contacts at last; none
    where it states no friction.
    """
    own = [one for one in found.engines if one.steps]
    if not own:
        return
    last = {one.title: one.batches[Way.FITTED] for one in own}
    batches = {step: {one.title: one.steps[step] for one in own} for step in own[0].steps}
    before: list[bool] = []
    for step, by_engine in {**batches, FITTED_CONTACTS: last}.items():
        ends = {title: _ends(one, found.recorded, MEASURED) for title, one in by_engine.items()}
        together = [end for each in ends.values() for end in each]
        names, right = [end.name for end in together], [end.same_face for end in together]
        gains = np.subtract(right, before, dtype=float) if before else None
        yield Step(
            step,
            share(right, names),
            None if gains is None else mean(gains, names),
            float(np.median([math.inf if e.off_m is None else 100.0 * e.off_m for e in together])),
            float(np.median([180.0 if e.turn_deg is None else e.turn_deg for e in together])),
            {title: share([end.same_face for end in each]) for title, each in ends.items()},
        )
        before = right


def as_good_as(best: str, found: AllMeasured) -> dict[str, float]:
    """Engines whose right faces do not differ significantly from those of one, and that one: on the
    half that is measured, the paired 95 % interval of the difference holds 0.

    Returns:
        By title the least difference from that one which so many throws show.
    """
    right = {
        one.title: np.array(
            [end.same_face for end in _ends(one.batches[Way.FITTED], found.recorded, MEASURED)],
            dtype=int,
        )
        for one in found.engines
    }
    less = {title: mean(right[best] - own) for title, own in right.items()}
    return {
        title: detectable(each, each.n) for title, each in less.items()
        if each.low <= 0.0 <= each.high
    }  # fmt: skip
