"""Pictures of a cascade."""

from __future__ import annotations

from matplotlib.figure import Figure

from steadyload.reports.charts.front import front
from steadyload.studies.cascade.summary import CascadeStudy


def plot_sweep(study: CascadeStudy) -> Figure:
    """Accuracy over CPU time: methods as points, and a line through a cascade's budgets."""
    swept = study.swept
    others = [{"found": row, "line": ""} for row in study.methods if row not in swept]
    line = [
        {"found": row, "line": "Cascade, by budget", "budget": study.budgets[row.method.spec]}
        for row in swept
    ]
    return front(
        [*others, *line], "found.cpu", "found.accuracy", method="found.method", joined="line",
        note="budget", spread=True,
    ).figure  # fmt: skip
