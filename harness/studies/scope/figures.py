"""Figure of options: verdicts that change against CPU time, both beside the whole pile."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from steadyload.reports.charts.drawing import PLAIN_TICKS, reach
from steadyload.reports.style import marker
from steadyload.studies.scope.summary import ScopeTable

_TICKS = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)


def plot_changed_against_cost(tables: Sequence[ScopeTable]) -> Figure:
    """Share of changed verdicts against CPU time over that of the whole pile, a panel a question.

    Good options stand at the lower left; the dashed line is the cost of the whole pile.
    """
    titles = list(dict.fromkeys(row.title for table in tables for row in table.options))
    figure = Figure(figsize=(3.8 * len(tables) + 2.2, 4.2), layout="constrained")
    panels = figure.subplots(1, len(tables), sharey=True, squeeze=False)[0]
    costs = [row.cpu_total.value for table in tables for row in table.options]
    low, high = min([*costs, 0.5]) / 1.6, max([*costs, 1.0]) * 2.2
    for axes, table in zip(panels, tables, strict=True):
        for row in table.options:
            shade = f"C{titles.index(row.title) % 10}"
            axes.errorbar(
                row.cpu_total.value,
                100.0 * row.changed.value,
                xerr=reach(row.cpu_total),
                yerr=reach(row.changed, 100.0),
                fmt=marker(row.method),
                label=row.title.replace("`", ""),
                color=shade,
                markersize=6.0,
                elinewidth=0.8,
            )
        axes.axvline(1.0, linestyle="--", linewidth=0.8, color="#7f7f7f")
        axes.set(xscale="log", xlim=(low, high))
        axes.set_xticks([tick for tick in _TICKS if low <= tick <= high])
        axes.xaxis.set_major_formatter(PLAIN_TICKS)
        axes.set_xticks([], minor=True)
        axes.set_xlabel("CPU time of all cases over that of the whole pile")
        axes.set_title(f"question {table.question}", fontsize=9.0)
        axes.grid(visible=True, which="major", linewidth=0.4, alpha=0.6)
    shown = {
        label: handle
        for axes in panels
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    figure.legend(shown.values(), shown.keys(), loc="outside right upper", frameon=False)
    panels[0].set_ylabel("changed verdicts (% of cases)")
    panels[0].set_ylim(bottom=-0.5)
    return figure
