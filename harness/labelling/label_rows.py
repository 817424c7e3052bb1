"""One labelled case: simulated once, read under the label's limits and under others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pyarrow as pa

from steadyload.engines.registry import package_versions
from steadyload.layouts.benchmark.tables import CASES
from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.method import Status
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.criteria import Criterion
from steadyload.methods.simulation.simulation import Simulation
from steadyload.methods.simulation.trace import VERSION as TRACE
from steadyload.methods.simulation.trace import Trace, UndecidedError, trace_loading
from steadyload.runs.asked import AskedCases, asked
from steadyload.runs.provenance import made_by
from steadyload.statics.margins import margins

VERSION = 1
"""Version of the values read from a trace, margins included: raised when rows change."""

LABEL = "label@reference"

CASE_SECONDS = 3600.0
"""Hard limit on the CPU time of a case, far beyond that of any: for a call that hangs."""

T_MAX, SAMPLES = 0.33, 11
"""Length [s] and samples of a trace: one sample, of 0.03 s, more than the label needs."""

DECISIVE = 10
"""Number of samples of a placement that decide the label: 0.3 s."""

PAPER = f"{LABEL}:criterion=paper,early_exit=0"
THRESHOLDS = (f"{LABEL}:eps_t=9,eps_r=9", f"{LABEL}:eps_t=11,eps_r=11")
"""Further methods with other thresholds, by a tenth either way."""

LIMITS = (*THRESHOLDS, f"{LABEL}:t_max=0.27,samples=9", f"{LABEL}:t_max=0.33,samples=11")
"""Further methods whose verdicts a trace gives: other thresholds, other times."""

_DIGITS = 3
"""Decimals of stored trace values [cm, degrees]."""

TRACES = pa.schema(
    [f for f in CASES if f.name not in ("offsets", "split", "rank")]
    + [pa.field(spec, pa.int16()) for spec in LIMITS]
    + [pa.field("reason", pa.string(), nullable=False)]
)
"""A row a traced case: its part of :data:`CASES`, the failing steps under :data:`LIMITS`, and why
there is no label, where there is none."""


class TraceUnit(AskedCases, what="traces"):
    """Some cases to be traced."""

    made_by: Mapping[str, str] = asked("made by")

    def describe(self, part: int) -> str:
        """Description of a case for messages."""
        return f"{LABEL} on {super().describe(part)}"


def traced_by() -> dict[str, str]:
    """Everything besides the cases that rows depend on, with the present code and packages."""
    return {
        **made_by(make_method(LABEL)),
        **package_versions(("numpy", "scipy")),
        "version of traces": str(TRACE),
        "version of rows": str(VERSION),
    }


def trace_unit(unit: TraceUnit) -> Iterator[dict[str, Any]]:
    """Prepare, then trace a unit's cases: a row of :data:`TRACES` for every one, in turn."""
    make_method(LABEL).prepare(max(len(layout) for _, layout in unit.cases))
    return (trace_row(scenario, layout) for scenario, layout in unit.cases)


def lost_row(status: Status, unit: TraceUnit, part: int, reason: str) -> dict[str, Any]:
    """The row of a case that ends the process it is traced in, or exceeds its hard limit."""
    return case_row(*unit.cases[part], status, reason)


def case_row(scenario: str, layout: Layout, status: Status, reason: str = "") -> dict[str, Any]:
    """The values of a row that it has whether or not its case has a label."""
    return {
        "layout": layout.name,
        "scenario": scenario,
        "item_count": len(layout),
        "status": str(status),
        "reason": reason,
    }


def trace_row(scenario: str, layout: Layout) -> dict[str, Any]:
    """A row of :data:`TRACES`: a case's label, trace, and failing steps under other limits."""
    method = make_method(LABEL)
    assert isinstance(method, Simulation)
    trace = trace_loading(layout, method, t_max=T_MAX, samples=SAMPLES, ending=DECISIVE)
    row = case_row(scenario, layout, Status.DONE)
    try:
        answers = {spec: _failing_step(spec, trace, layout) for spec in (LABEL, PAPER, *LIMITS)}
    except UndecidedError:
        return row | {"status": str(trace.status), "reason": trace.reason}
    for what in ("corner", "centre", "angle"):
        values = getattr(trace, what)[:, :DECISIVE]
        row[f"{what}_last"] = _rounded(values[:, -1])
        row[f"{what}_most"] = _rounded(values.max(axis=1))
    known = margins(layout, centres=False)[: len(trace.corner)]
    return row | {
        "failing_step": answers[LABEL],
        "failing_step_paper": answers[PAPER],
        "moved": trace.moved[:, DECISIVE - 1].tolist(),
        "margin": _rounded([margin.patches for margin in known]),
        **{spec: answers[spec] for spec in LIMITS},
    }


def _failing_step(spec: str, trace: Trace, layout: Layout) -> int | None:
    """Failing step of a further method, from the trace, or simulated where that is too short."""
    method = make_method(spec)
    p = method.parameters
    try:
        return trace.failing_step(Criterion(p.criterion), p.eps_t, p.eps_r, p.samples)
    except UndecidedError:
        verdict = method.judge(layout)
        if verdict.status is not Status.DONE:
            raise
        return verdict.failing_step


def _rounded(values: Any) -> list[float]:
    return (np.round(np.asarray(values, dtype=float), _DIGITS) + 0.0).tolist()
