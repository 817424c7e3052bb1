"""Figures of calibration and abstention."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.figure import Figure

from steadyload.reports.charts.curves import curves
from steadyload.statistics.reliability import Abstention, Reliability


def plot_reliability(kinds: Mapping[str, Mapping[str, Reliability]]) -> Figure:
    """Reliability diagram: observed frequency against predicted probability.

    Args:
        kinds: a panel a kind of probability, in it a curve a method.
    """
    rows = [
        {"kind": kind, "judge": judge, "bins": found.bins}
        for kind, judges in kinds.items()
        for judge, found in judges.items()
    ]
    return curves(
        rows, "mean", "happened", title="judge", within="bins", panel="kind", percent="xy",
        diagonal=True, x_label="probability given (%)", y_label="happened (%)", size=(9.0, 4.2),
        markersize=5.0, linewidth=1.0, elinewidth=1.0,
    ).figure  # fmt: skip


def plot_risk(judges: Mapping[str, Abstention]) -> Figure:
    """Share of wrong scores against the share of cases that are judged."""
    rows = [
        {"judge": judge, "covered": covered, "wrong": wrong}
        for judge, found in judges.items()
        for covered, wrong in found.curve
    ]
    return curves(
        rows, "covered", "wrong", title="judge", percent="xy", y_from=0.0,
        x_label="cases judged, the surest first (%)", y_label="of these wrong (%)",
        size=(6.4, 3.6), markersize=3.5, linewidth=1.0,
    ).figure  # fmt: skip
