"""The part of the page of tuning on whether tuned parameters reach their targets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from steadyload.reports.pages.page import Section
from steadyload.reports.table import Column, Table, factor, names, percent, significant
from steadyload.runs.evaluation import MethodEvaluation
from steadyload.statistics.estimate import Estimate
from steadyload.studies.method_sections import (
    ACCURACY,
    AHEAD,
    COST_RATIO,
    CPU,
    METHOD,
    OVER,
    UNDER,
    N,
    titled,
)
from steadyload.studies.tuning.summary import TunedTable

_HELD_AGAINST = {"ps3": "PS_3", "ps5": "PS_5"}
"""Families that a tuned method is to exceed in accuracy."""

_DEAR = "ps3"
"""The family whose cost is the reference of the cost limit of a tuned method."""

_START = "label"
"""The family of the genotype with which a search begins."""

_AS_LABELS = {"t_max=0.3", "eps_t=10", "eps_r=10", "between_steps=reseat", "criterion=adams"}
"""Parameters of a simulation under the criterion of the labels."""

_SHARE_OF_COST = 0.2
_ACCURATE = 0.98

_OUTCOMES = (
    METHOD,
    N,
    ACCURACY,
    titled(AHEAD, "tuned minus it"),
    CPU,
    titled(COST_RATIO, "tuned CPU / its"),
    OVER,
    UNDER,
)


def came_out(tests: Sequence[TunedTable]) -> Section:
    """Section of the tuned parameters on other cases, beside other methods and the targets."""
    parts = list(dict.fromkeys(t.part for t in tests))
    said, tables = [], []
    for part in parts:
        mine = [t for t in tests if t.part == part]
        said += [_verdict(part, mine), "\n".join(_sentence(t) for t in mine), *_begun(mine)]
        rows = [row for t in mine for row in (t.tuned, *t.others)]
        columns = list(_OUTCOMES)
        if any(row.robust.n for row in rows):
            columns.append(Column("robust labels %", "robust", percent))
        tables.append(Table(rows, columns, f"**Part {part}**" if len(parts) > 1 else ""))
    return Section("What came out", "\n\n".join(said), tables)


def answer(tests: Sequence[TunedTable]) -> str:
    """Paragraph on the tuned parameters of the first part, and on what their search brought."""
    mine = [test for test in tests if test.part == tests[0].part]
    if not mine:
        return ""
    right = "; ".join(f"{percent(t.tuned.accuracy)} % on {t.engine}" for t in mine)
    starts = _starts(mine)
    gains = _gains(starts)
    brought = "; ".join(f"{percent(gain)} points on {engine}" for engine, gain in gains.items())
    return (
        f"Tuned parameters are right on {right} (n = {mine[0].tuned.accuracy.n}, part "
        f"`{mine[0].part}`)"
        + (f"; to the protocol of the label their search adds {brought}." if brought else ".")
        + (f" {_little_to_gain([starts[engine] for engine in gains])}" if gains else "")
        + "\n\n"
    )


def _little_to_gain(starts: Sequence[MethodEvaluation]) -> str:
    """Sentences on how much a search could gain on these cases at most."""
    right = sorted(100 * start.accuracy.value for start in starts)
    already = " to ".join(dict.fromkeys(f"{value:.1f}" for value in (right[0], right[-1])))
    return (
        f"Without any search {already} % of these cases are right already, so a search can add at "
        f"most {100 - right[0]:.1f} points here; on harder cases it may add more (docs/tuning.md)."
    )


@dataclass(frozen=True, slots=True)
class _Target:
    """A target of a tuned method, and whether it is reached."""

    title: str
    met: bool
    said: str


def _targets(table: TunedTable) -> list[_Target]:
    """The targets for which the record has values."""
    targets = [
        _Target(
            f"beats {_HELD_AGAINST[other.method.family]}",
            other.ahead.low > 0.0,
            f"{percent(other.ahead)} points",
        )
        for other in table.others
        if other.method.family in _HELD_AGAINST and other.ahead is not None
    ]
    targets += [
        _Target(
            "costs at most a fifth of PS_3's CPU time",
            other.cost_ratio.value <= _SHARE_OF_COST,
            f"{factor(other.cost_ratio)} of it{_unsure(other.cost_ratio, _SHARE_OF_COST)}",
        )
        for other in table.others
        if other.method.family == _DEAR and other.cost_ratio is not None
    ]
    accuracy = table.tuned.accuracy
    return [
        *targets,
        _Target(
            f"accuracy of at least {100 * _ACCURATE:g} %",
            accuracy.value >= _ACCURATE,
            f"{percent(accuracy)} %{_unsure(accuracy, _ACCURATE)}",
        ),
    ]


def _unsure(found: Estimate, bar: float) -> str:
    return ", the interval holds the bar" if found.low < bar < found.high else ""


def _verdict(part: str, tests: Sequence[TunedTable]) -> str:
    missed = {t.engine: [b.title for b in _targets(t) if not b.met] for t in tests}
    met = [engine for engine, titles in missed.items() if not titles]
    said = f"On part `{part}` the tuned parameters meet every bar on {names(met or ['no engine'])}"
    failed = [f"{e} ({', '.join(titles)})" for e, titles in missed.items() if titles]
    said += f"; they miss one or more on {'; '.join(failed)}." if failed else "."
    if len(tests) > 1:
        mean = sum(t.tuned.accuracy.value for t in tests) / len(tests)
        place = "at least" if mean >= _ACCURATE else "below"
        said += (
            f" Their mean accuracy over {len(tests)} engines is {100 * mean:.1f} %, {place} "
            f"{100 * _ACCURATE:g} %."
        )
    return said


def _sentence(table: TunedTable) -> str:
    targets = _targets(table)
    groups = [
        f"{word}: {'; '.join(f'{b.title} ({b.said})' for b in targets if b.met is met)}."
        for word, met in (("Met", True), ("Missed", False))
        if any(b.met is met for b in targets)
    ]
    tuned = table.tuned
    return (
        f"- {table.engine}: {100 * tuned.accuracy.value:.1f} % accurate at "
        f"{significant(tuned.cpu.value)} ms of CPU time a layout. {' '.join(groups)}"
    )


def _starts(tests: Sequence[TunedTable]) -> dict[str, MethodEvaluation]:
    """The start of the search, by engine."""
    return {t.engine: o for t in tests for o in t.others if o.method.family == _START}


def _gains(starts: Mapping[str, MethodEvaluation]) -> dict[str, Estimate]:
    """Accuracy of the tuned parameters less that of the start, by engine."""
    return {engine: o.ahead for engine, o in starts.items() if o.ahead is not None}


def _begun(tests: Sequence[TunedTable]) -> list[str]:
    """Sentences on the accuracy of the start of a search, and on the gain of the search."""
    starts = _starts(tests)
    gains = _gains(starts)
    if not gains:
        return []
    asked = [set(o.method.spec.partition(":")[2].split(",")) for o in starts.values()]
    own = (
        " They follow the label's own protocol (reseat, corner markers, 10 cm, 10 degrees, 0.3 s)."
        if all(given >= _AS_LABELS for given in asked)
        else ""
    )
    alone = "; ".join(f"{percent(starts[e].accuracy)} % on {e}" for e in gains)
    added = "; ".join(f"{percent(gain)} points on {e}" for e, gain in gains.items())
    unsure = [e for e, gain in gains.items() if gain.low <= 0.0 <= gain.high]
    sure = [e for e in gains if e not in unsure]
    told = [
        f"The interval of this gain {word} 0 on {names(engines)}."
        for word, engines in (("includes", unsure), ("excludes", sure))
        if engines
    ]
    return [
        "The parameters that a search begins with are judged as well, in the rows *start of the "
        f"search*.{own} Alone they are right on {alone}. To that the tuned parameters add {added}. "
        + " ".join(told)
    ]
