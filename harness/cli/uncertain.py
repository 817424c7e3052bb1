"""Tables of ``steadyload score --uncertain``: the reliability of verdicts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from steadyload.cli.box_names import named_reason
from steadyload.runs.verdict_reliability import Ending

_SHOWN = 3
"""Number of failing steps in a cell, the most probable first."""


def without_effect(records: Iterable[Mapping[str, Any]]) -> list[str]:
    """A sentence for each method on which an uncertain quantity has no effect."""
    found = {
        record["method"]: record["uncertain"]["without_effect"]
        for record in records
        if record.get("uncertain")
    }
    return [
        f"{method}: has no parameter {' and '.join(names)}; that it is uncertain has no effect"
        for method, names in found.items()
        if names
    ]


def uncertain_table(
    records: Iterable[Mapping[str, Any]],
) -> tuple[Sequence[str], list[tuple[str, ...]]]:
    """Header and rows of the table."""
    header = (
        "layout", "method", "items", "score", "failing step", "stands %", "fails at",
        "expected score", "samples", "seconds", "why",
    )  # fmt: skip
    return header, [_row(record, record["uncertain"]) for record in records]


def _row(record: Mapping[str, Any], found: Mapping[str, Any] | None) -> tuple[str, ...]:
    items, score, step = (record[key] for key in ("items", "score", "failing_step"))
    plan = (
        record["layout"],
        record["method"],
        "-" if items is None else str(items),
        record["status"] if score is None else f"{score:.3f}",
        "-" if step is None else str(step),
    )
    if found is None or found["stands"] is None:
        return (*plan, "-", "-", "-", "-", "-", named_reason(record))
    low, high = (100.0 * end for end in found["interval"])
    return (
        *plan,
        f"{100.0 * found['stands']:.1f} [{low:.1f}, {high:.1f}]",
        _distribution(found["distribution"]),
        f"{found['expected_score']:.3f}",
        str(found["samples"]),
        f"{found['wall_seconds']:.2f}",
        "; ".join(filter(None, (named_reason(record), _shortage(found)))),
    )


def _distribution(shares: Mapping[str, float]) -> str:
    order = sorted(shares.items(), key=lambda entry: -entry[1])
    more = ", ..." if len(order) > _SHOWN else ""
    return ", ".join(f"{step} ({100.0 * share:.0f} %)" for step, share in order[:_SHOWN]) + more


def _shortage(found: Mapping[str, Any]) -> str:
    """Reason why an interval is wider than required; empty where it is not."""
    lost = ", ".join(f"{count} {status}" for status, count in found["without_verdict"].items())
    said = [f"samples without a verdict: {lost}, the first: {found['why']}"] if lost else []
    if found["ending"] == Ending.SPENT:
        said.append("more samples would narrow the interval")
    return "; ".join(said)
