"""Figures of packers' plans: where in the loading they fail."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure

from steadyload.studies.packers.plans import PACKER_TITLES

_LINES = (
    ("#1f77b4", "-"),
    ("#d62728", "-"),
    ("#ff9896", "--"),
    ("#2ca02c", "-"),
    ("#7f7f7f", ":"),
)
_STYLES = dict(zip(PACKER_TITLES.values(), _LINES, strict=True))
"""Colour and line of a packer, the same whoever else is shown."""


def plot_failed_by(failed_by: Mapping[str, tuple[Sequence[float], int]]) -> Figure:
    """Share of plans that have failed [%] by the share of their boxes placed [%], a curve a packer.

    Args:
        failed_by: by packer the share of boxes placed at which each failing plan fails, ascending,
            and the number of plans.
    """
    figure = Figure(figsize=(6.4, 4.2))
    axes = figure.add_subplot()
    for packer, (shares, count) in failed_by.items():
        shade, line = _STYLES[packer]
        x = [0.0, *(100.0 * share for share in shares), 100.0]
        y = [100.0 * k / count for k in range(len(shares) + 1)]
        label = f"{packer} ({count})"
        axes.step(x, [*y, y[-1]], line, where="post", color=shade, linewidth=1.6, label=label)
    axes.set(xlim=(0.0, 100.0), ylim=(-1.0, 100.0))
    axes.set_xlabel("boxes placed safely (% of the plan's)")
    axes.set_ylabel("plans that have failed by then (%)")
    axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    axes.legend(loc="upper left", frameon=False)
    return figure
