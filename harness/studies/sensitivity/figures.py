"""Figure of the ranks of methods over rules."""

from __future__ import annotations

from matplotlib.figure import Figure

from steadyload.reports.style import colour, face, marker
from steadyload.studies.sensitivity.rules import LIMITS, TIMES
from steadyload.studies.sensitivity.summary import Knowledge, Sensitivity


def plot_ranks(found: Sensitivity) -> Figure:
    """Rank against the rule, a line a method; rows by knowledge, columns by kind of rule."""
    figure = Figure(figsize=(9.2, 8.4))
    panels = figure.subplots(2, 2, sharey=True, width_ratios=(len(TIMES), len(LIMITS)))
    for knowledge, row in zip(Knowledge, panels, strict=True):
        rankings = {r.rule: r for r in found.by(knowledge)}
        for rules, axes in zip((TIMES, LIMITS), row, strict=True):
            for method in found.methods:
                ranks = [rankings[rule].of(method.spec).rank for rule in rules]
                axes.plot(
                    range(len(rules)),
                    ranks,
                    color=colour(method),
                    marker=marker(method),
                    markerfacecolor=face(method),
                    markersize=5,
                    linewidth=1.2,
                    # Neighbours in time stand in an order; other rules do not.
                    linestyle="-" if rules is TIMES else ":",
                )
            axes.set_xticks(range(len(rules)), [rule.short for rule in rules], rotation=30)
            axes.set_title(f"methods {knowledge}", fontsize=9)
            axes.grid(visible=True, axis="y", linewidth=0.4, alpha=0.6)
        last = rankings[LIMITS[-1]]
        for method in found.methods:
            row[1].annotate(
                method.title,
                (len(LIMITS) - 1, last.of(method.spec).rank),
                xytext=(8, _step(found, knowledge, method.spec)),
                textcoords="offset points",
                va="center",
                fontsize=8,
                color=colour(method),
                annotation_clip=False,
            )
        row[0].set_ylabel("rank by accuracy (1: the most accurate)")
    panels[0][0].set_ylim(len(found.methods) + 0.5, 0.5)
    panels[0][0].set_yticks(range(1, len(found.methods) + 1))
    figure.tight_layout()
    return figure


def _step(found: Sensitivity, knowledge: Knowledge, spec: str) -> float:
    """Points by which a name is lowered, where several methods share the last rank."""
    last = next(r for r in found.by(knowledge) if r.rule is LIMITS[-1])
    rank = last.of(spec).rank
    sharing = [place.method.spec for place in last.places if place.rank == rank]
    return -11.0 * sharing.index(spec)
