"""Errors of engines, test by test, and how many tests every engine meets."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from types import MappingProxyType, SimpleNamespace
from typing import Any

import pandas as pd

from steadyload.properties.closed_form_tests import (
    ClosedFormResult,
    ClosedFormTest,
    closed_form_tests,
    rocking_tests,
)
from steadyload.reports import frames
from steadyload.reports.columns import compact
from steadyload.studies.closed_form_errors import (
    OWN_STEPS,
    errors_by_argument,
    errors_by_frequency,
    hertz,
)

_RIGHT_WITHIN = 1.0
"""Error up to which an engine counts as right: in per cent of what is expected, and in the unit of
a test (mm or degrees) whose errors are not relative."""


class Found(SimpleNamespace):
    """All that the page shows."""

    left_out: Mapping[str, str]
    made_with: Mapping[str, str]


def compare(
    results: Sequence[ClosedFormResult],
    made_with: Mapping[str, str],
    left_out: Mapping[str, str] = MappingProxyType({}),
) -> Found:
    """Results beside what is expected; tests without any result are left out."""
    measured = {r.test for r in results}
    tests = [test for test in closed_form_tests() if test.name in measured]
    series: dict[str, list[ClosedFormTest]] = {}
    for test in tests:
        series.setdefault(test.series, []).append(test)
    middle = [group[len(group) // 2] for group in series.values()]
    frame = _frame(results, tests)
    highest = frame.groupby("engine")["frequency"].transform("max")
    finest = frame[(frame["frequency"] == highest) | highest.isna()]
    return Found(
        scores=_scores(finest[finest["defined"]]),
        overview=_overview(finest),
        rocked=_rocked(frame),
        points=errors_by_frequency(middle, results),
        beaten=pd.DataFrame(_beaten(tests, frame)),
        series=[
            {
                "tests": group,
                "runs": _runs(frame[frame["series"] == name]),
                "points": errors_by_argument(group, results) if len(group) > 1 else [],
                "is_wide": (group[-1].argument or 0.0) > 10 * (group[0].argument or 0.0),
            }
            for name, group in series.items()
        ],
        made_with=made_with,
        left_out=left_out,
        right_within=_RIGHT_WITHIN,
        own_steps=OWN_STEPS,
    )


def _frame(results: Sequence[ClosedFormResult], tests: Sequence[ClosedFormTest]) -> pd.DataFrame:
    """A row a result; ``off``: the size of its error, endless without one."""
    known = {test.name: test for test in tests}
    return pd.DataFrame(
        asdict(r)
        | {
            "series": test.series,
            "argument": "" if test.argument is None else f"{test.argument_name} {test.argument:g}",
            "error_unit": test.error_unit,
            "rate": hertz(r.frequency),
            "defined": r.defined,
            "right": _is_right(test, r),
            "error": _error(test, r),
            "off": math.inf if r.error is None else abs(r.error),
        }
        for r in results
        for test in [known[r.test]]
    ).astype({"frequency": float})


def _is_right(test: ClosedFormTest, result: ClosedFormResult) -> bool:
    if result.error is None:
        return False
    share = 0.0 if test.relative else abs(test.expected) * _RIGHT_WITHIN / 100.0
    return abs(result.error) <= max(_RIGHT_WITHIN, share, test.resolution)


def _error(test: ClosedFormTest, result: ClosedFormResult) -> str:
    """The error as text, the reason why there is none, or that it is below the resolution."""
    if result.error is None:
        return result.note
    small = abs(result.error) < test.resolution
    return f"< {test.resolution:g}" if small else compact(result.error)


def _scores(asked: pd.DataFrame) -> list[dict[str, Any]]:
    """How many of the tests that are defined for an engine it meets at its highest frequency."""
    rows = asked.groupby("engine", sort=False)["right"]
    found = pd.DataFrame({"right": rows.sum(), "of": rows.size(), "share": rows.mean()})
    return found.reset_index().to_dict("records")


def _overview(finest: pd.DataFrame) -> pd.DataFrame:
    """Errors in every test, by engine at its highest frequency."""
    at = finest["engine"] + ", " + finest["rate"]
    errors = finest.assign(at=at).set_index(["test", "at"])["error"]
    units = finest.drop_duplicates("test").set_index("test")[["error_unit"]]
    return units.join(frames.across(errors, "at", "error_of")).reset_index()


def _across(rows: pd.DataFrame, by: str) -> pd.DataFrame:
    """Errors of every engine and frequency, side by side."""
    runs = ["engine", "rate"]
    wide = frames.across(rows.set_index([*runs, by])["error"], by, "error_of")
    return wide.loc[pd.MultiIndex.from_frame(rows[runs].drop_duplicates())].reset_index()


def _rocked(frame: pd.DataFrame) -> pd.DataFrame:
    """The largest error in every series of a rocking block, of those that have all tests."""
    names = [test.name for test in rocking_tests()]
    own, run = frame[frame["test"].isin(names)], ["engine", "rate"]
    whole = own[own.groupby(run)["test"].transform("size") == len(names)]
    return _across(whole.loc[whole.groupby([*run, "series"], sort=False)["off"].idxmax()], "series")


def _beaten(tests: Sequence[ClosedFormTest], frame: pd.DataFrame) -> Iterable[dict[str, Any]]:
    """Tests in which an engine that chooses its own steps is not the best, and why."""
    for test in tests:
        mine = frame[(frame["test"] == test.name) & (frame["off"] < math.inf)]
        others = mine[mine["frequency"] == mine["frequency"].max()]
        if others.empty:
            continue
        best = others.loc[others["off"].idxmin()]
        is_worse = mine["frequency"].isna() & (mine["off"] > max(best["off"], test.resolution))
        for own in mine[is_worse].to_dict("records"):
            beaten_by = f"{best['error']} ({best['engine']}, {best['rate']})"
            yield own | {"best": beaten_by, "why": test.when_soft}


def _runs(own: pd.DataFrame) -> pd.DataFrame:
    """Results in a single test, or errors in those of a series side by side."""
    if own["test"].nunique() > 1:
        return _across(own, "argument")
    return own.assign(value=own["found"], error_shown=own["error"])
