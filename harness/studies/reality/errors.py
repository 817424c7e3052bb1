"""Throws as engines end them, compared with the record: at rest, on the way there, and by what the
body is taken to be.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pandas as pd

from steadyload.reports import frames
from steadyload.runs import frames as v
from steadyload.runs.comparison import detectable
from steadyload.statistics import metrics
from steadyload.studies.reality.record import FIT, MEASURED, Recorded
from steadyload.studies.reality.releasing import SINCE_CONTACT
from steadyload.studies.reality.running import AllMeasured, Way

FITTED_CONTACTS = "fitted contacts"
"""Title of the last step of :func:`steps`."""

MOST = 0.9
"""Share of the trials in the second figure of how far rest is off."""

_LEAST_TRIALS = 8
"""With an error after so many impacts, for it to be shown."""


def throws(found: AllMeasured) -> pd.DataFrame:
    """A row a throw, engine, and way or step of taking the body and its contact.

    A failed simulation has the wrong face, and is farther off than any.

    Returns:
        ``engine``, ``name``, ``way``; ``trial``, ``cluster``: the throw; ``half``; ``right_face``,
        ``off_cm``, ``turn_deg``: at rest; ``height_mm``, ``deepest_mm``, ``later_s``: missing
        without one; ``by_time``, ``by_impacts``: distances on the way [m]; ``failed``.
    """
    tosses = {toss.name: toss for toss in found.recorded.tosses}
    return pd.DataFrame(
        [
            {
                "engine": one.title,
                "name": one.name,
                "way": str(way),
                "trial": end.name,
                "cluster": end.name,
                "half": tosses[end.name].half,
                "right_face": end.same_face,
                "off_cm": math.inf if end.off_m is None else 100.0 * end.off_m,
                "turn_deg": 180.0 if end.turn_deg is None else end.turn_deg,
                "height_mm": None if end.height_m is None else 1e3 * end.height_m,
                "deepest_mm": None if end.deepest_m is None else -1e3 * end.deepest_m,
                "later_s": None if end.rest_s is None else end.rest_s - tosses[end.name].rest_s,
                "by_time": list(end.since_contact),
                "by_impacts": list(end.through_impacts),
                "failed": bool(end.failed),
            }
            for one in found.engines
            for way, batch in (*one.steps.items(), *one.batches.items())
            for end in batch.ended
        ]
    )


def guesses(recorded: Recorded, scale: float) -> pd.DataFrame:
    """Rows of guesses without an engine, on the half that is measured; ``scale`` makes lengths of
    the record true ones.
    """
    own = [toss for toss in recorded.tosses if toss.half == MEASURED]
    guessed = {
        "stays as released": [toss.as_released for toss in own],
        "stays as it lands": [toss.as_landed for toss in own],
    }
    return pd.DataFrame(
        [
            {
                "engine": title,
                "name": "",
                "cluster": toss.name,
                "right_face": one.same_face,
                "off_cm": 100.0 * scale * one.off_m,
                "turn_deg": one.turn_deg,
            }
            for title, ends in guessed.items()
            for toss, one in zip(own, ends, strict=True)
        ]
    )


def errors(frame: pd.DataFrame, by: Sequence[str]) -> pd.DataFrame:
    """Errors at rest."""
    groups = frame.groupby(list(by), sort=False).size()
    return pd.DataFrame(
        {
            "right_face": v.share(frame, "right_face", by),
            "off_cm": _median(frame, "off_cm", by),
            "most_cm": v.estimates(frame, by, lambda own: metrics.quantile(own["off_cm"], MOST)),
            "turn_deg": _median(frame, "turn_deg", by),
        },
        index=groups.index,
    )


def _median(frame: pd.DataFrame, column: str, by: Sequence[str]) -> pd.Series:
    known = frame.dropna(subset=column)
    return v.estimates(known, by, lambda own: metrics.median(own[column]))


def by_half(frame: pd.DataFrame) -> pd.DataFrame:
    """Errors by engine and way on the half for fitting, ``fit_``, and on the other, ``other_``."""
    by = ["engine", "way"]
    fit, other = (errors(frame[frame["half"] == half], by) for half in (FIT, MEASURED))
    return fit.add_prefix("fit_").join(other.add_prefix("other_")).reset_index()


def steps(frame: pd.DataFrame) -> pd.DataFrame:
    """Errors by what is taken from the record, on the half that is measured, of the engines that
    have steps together; of no row where none has.

    First the body, with the contacts that the record states, and fitted contacts at last.

    Returns:
        ``gain``: points of right faces more than with the step before, of the same throws and
        engines; ``engine_face``: by engine.
    """
    taken = ~frame["way"].isin([Way.IDENTIFIED, Way.PRESET])
    stepped = frame.loc[taken & (frame["way"] != Way.FITTED), "engine"]
    own = frame[taken & frame["engine"].isin(stepped) & (frame["half"] == MEASURED)]
    if own.empty:
        return own
    right = own["right_face"].astype(float)
    own = own.assign(
        step=own["way"].replace({str(Way.FITTED): FITTED_CONTACTS}),
        gain=right.groupby([own["engine"], own["trial"]]).diff(),
    )
    groups = own.groupby("step", sort=False)
    each = v.share(own, "right_face", ["step", "engine"])
    found = pd.DataFrame(
        {
            "right_face": v.share(own, "right_face", ["step"]),
            "gain_of_step": v.mean(own, "gain", ["step"]),
            "step_off": groups["off_cm"].median(),
            "step_turn": groups["turn_deg"].median(),
        },
        index=groups.size().index,
    )
    return found.join(frames.across(each, "engine", "engine_face")).reset_index(names="taken")


def as_good_as(best: str, frame: pd.DataFrame) -> dict[str, float]:
    """Engines whose right faces do not differ significantly from those of one, and that one: the
    paired 95 % interval of the difference holds 0.

    Returns:
        By title the least difference from that one which so many throws show.
    """
    right = {name: own.to_numpy(int) for name, own in frame.groupby("engine")["right_face"]}
    less = {name: metrics.mean(right[best] - right[name]) for name in frame["engine"].unique()}
    return {
        name: detectable(each, each.n) for name, each in less.items() if each.low <= 0 <= each.high
    }


def by_time(fitted: pd.DataFrame) -> pd.DataFrame:
    """Distances, all throws, by the time since the last frame of free flight [s]."""
    found = _grown(fitted, "by_time", 1)
    return found.assign(at=found["at"].map(dict(enumerate(SINCE_CONTACT))))


def by_impacts(fitted: pd.DataFrame) -> pd.DataFrame:
    """Likewise by the number of impacts, just before the next one or at the end of the record."""
    return _grown(fitted, "by_impacts", _LEAST_TRIALS)


def _grown(fitted: pd.DataFrame, column: str, least: int) -> pd.DataFrame:
    long = fitted[~fitted["failed"]].explode(column)
    long = long.assign(
        at=long.groupby(level=0).cumcount(), off_cm=100.0 * long[column].astype(float)
    )
    off = _median(long.sort_values("at", kind="stable"), "off_cm", ["engine", "name", "at"])
    return off[[one.n >= least for one in off]].rename("off_cm").reset_index()


def rests(fitted: pd.DataFrame, recorded: Recorded) -> pd.DataFrame:
    """How the body rests by engine, all throws."""
    there = fitted[~fitted["failed"]]
    heights = there.groupby("engine")["height_mm"].median()
    return pd.DataFrame(
        {
            "height_mm": _median(there, "height_mm", ["engine"]),
            "sunk_mm": recorded.half_edge_mm - heights if recorded.is_cube else np.nan,
            "deepest_mm": _median(there, "deepest_mm", ["engine"]),
            "later_s": _median(there, "later_s", ["engine"]),
            "moving": (fitted["later_s"].isna() & ~fitted["failed"])
            .groupby(fitted["engine"])
            .sum(),
            "no_end": fitted.groupby("engine")["failed"].sum(),
        },
        index=pd.Index(fitted["engine"].unique(), name="engine"),
    ).reset_index()
