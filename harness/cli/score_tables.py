"""Tables of ``steadyload score``: verdicts, and with ``--uncertain`` their reliability."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from steadyload.layouts.model.naming import box_label
from steadyload.runs.able import spec_with_question
from steadyload.runs.verdict_reliability import Ending

_SHOWN = 3
"""Number of failing steps in a cell, the most probable first."""

_PLAN = ("layout", "method", "boxes", "score", "fails at box")
"""First columns of both tables: a layout and the verdict on its plan. Boxes count from 1."""


def verdict_table(
    records: Iterable[Mapping[str, Any]],
) -> tuple[Sequence[str], list[tuple[str, ...]]]:
    """Header and rows of the table of verdicts."""
    return (*_PLAN, "status", "ms", "why"), [_verdict_row(record) for record in records]


def _verdict_row(record: Mapping[str, Any]) -> tuple[str, ...]:
    # Settings that the engine ignored are always shown.
    ignored = f"ignored: {', '.join(record['ignored'])}" if record["ignored"] else ""
    return (
        *_plan(record, "-"),
        record["status"],
        f"{1e3 * record['wall_seconds']:.2f}",
        "; ".join(filter(None, (_named_reason(record), ignored))),
    )


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
    """Header and rows of the table of the reliability of verdicts."""
    header = (
        *_PLAN, "stands %", "may fail at box", "expected score", "samples", "seconds", "why",
    )  # fmt: skip
    return header, [_row(record, record["uncertain"]) for record in records]


def _plan(record: Mapping[str, Any], without_score: str) -> tuple[str, ...]:
    """Cells of :data:`_PLAN`."""
    items, score, step = (record[key] for key in ("items", "score", "failing_step"))
    return (
        record["layout"],
        spec_with_question(record["method"]),
        "-" if items is None else str(items),
        without_score if score is None else f"{score:.3f}",
        "-" if step is None else str(step + 1),
    )


def _row(record: Mapping[str, Any], found: Mapping[str, Any] | None) -> tuple[str, ...]:
    plan = _plan(record, record["status"])
    if found is None or found["stands"] is None:
        return (*plan, "-", "-", "-", "-", "-", _named_reason(record))
    low, high = (100.0 * end for end in found["interval"])
    return (
        *plan,
        f"{100.0 * found['stands']:.1f} [{low:.1f}, {high:.1f}]",
        _distribution(found["distribution"]),
        f"{found['expected_score']:.3f}",
        str(found["samples"]),
        f"{found['wall_seconds']:.2f}",
        "; ".join(filter(None, (_named_reason(record), _shortage(found)))),
    )


def _distribution(shares: Mapping[str, float]) -> str:
    order = sorted(shares.items(), key=lambda entry: -entry[1])
    more = ", ..." if len(order) > _SHOWN else ""
    boxes = [(step if step == "none" else int(step) + 1, share) for step, share in order[:_SHOWN]]
    return ", ".join(f"{box} ({100.0 * share:.0f} %)" for box, share in boxes) + more


def _shortage(found: Mapping[str, Any]) -> str:
    """Reason why an interval is wider than required; empty where it is not."""
    lost = ", ".join(f"{count} {status}" for status, count in found["without_verdict"].items())
    said = [f"samples without a verdict: {lost}, the first: {found['why']}"] if lost else []
    if found["ending"] == Ending.SPENT:
        said.append("more samples would narrow the interval")
    return "; ".join(said)


def _named_reason(record: Mapping[str, Any]) -> str:
    """The reason of a record's verdict, with the box of the failing step, if it has an id."""
    reason, box = str(record["reason"]), record["failing_box"]
    if box is None:
        return reason
    label = box_label(record["failing_step"], box, record["items"])
    return reason if label in reason else ": ".join(filter(None, (label, reason)))
