"""The part of the page of tuning that compares searches with each other."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from statistics import fmean

from steadyload.reports.pages.page import Picture, Section
from steadyload.reports.table import (
    Column,
    Table,
    columns_for,
    duration,
    milliseconds,
    names,
    percent,
    plain_percent,
    significant,
    words,
)
from steadyload.studies.tuning.search_figures import plot_algorithms, plot_histories
from steadyload.studies.tuning.summary import SearchRow, SeedRow

Groups = Mapping[str, Mapping[str, list[SearchRow]]]
"""Searches that can be compared: by title of the group, by algorithm."""


def _from_start(what: int, form: Callable[[float], str]) -> Callable[[SearchRow], str]:
    """A number of the genotype a search begins with, and of the best one found."""
    return lambda row: f"{form(row.start[what])} → {form(row.found[what])}"


_SEARCHES = (
    words("engine"),
    words("algorithm"),
    Column("genotypes"),
    Column("fitness", _from_start(0, "{:.4f}".format)),
    Column("accuracy %", _from_start(1, plain_percent)),
    Column("cost ms", _from_start(2, significant)),
    Column("hypervolume", "hypervolume", "{:.3f}".format),
    Column("CPU", "cpu", duration),
    Column("wall", "wall", duration),
    words("space"),
    Column("seed"),
    Column("population", lambda r: f"{r.population} x {r.generations}"),
    Column("judged whole", "whole"),
    Column("given up", lambda r: r.genotypes - r.whole),
    Column("repeats"),
)


def searches(rows: Sequence[SearchRow]) -> Section:
    """Section of the effort and result of each search."""
    judged, whole = sum(r.genotypes for r in rows), sum(r.whole for r in rows)
    said = [
        f"{len(rows)} {'search' if len(rows) == 1 else 'searches'} judged {judged:,} genotypes in "
        f"{duration(sum(r.cpu for r in rows))} of CPU time, {whole:,} of them on all cases"
        + (f"; the other {judged - whole:,} were given up before." if judged > whole else ".")
    ]
    engines = dict.fromkeys(r.engine for r in rows)
    said.append("\n".join(_best_of(engine, rows) for engine in engines))
    begun = [f"{r.engine}, {r.algorithm}, seed {r.seed} with {r.known}" for r in rows if r.known]
    if begun:
        said.append(
            "Some searches had parameter sets in their first generation that an earlier search had "
            f"found, beside the start and random ones: {names(begun)}. What the earlier one spent "
            "is not counted here."
        )
    said.append(
        "*Population*: its size by the number of generations. *Repeats* came up again and were not "
        "judged again. Arrows go from the genotype that a search begins with to the best one "
        "found. *Hypervolume*: area below the front over the logarithm of the cost; 1 is all of it."
    )
    return Section(
        "The searches",
        "\n\n".join(said),
        [Table(rows, _SEARCHES)],
        [
            Picture(
                "searches",
                plot_histories(rows),
                "Fitness over genotypes judged, a line a search: the best so far (thick) and the "
                "median of a generation (thin). Medians far below are cut off.",
            )
        ],
    )


def _best_of(engine: str, rows: Sequence[SearchRow]) -> str:
    best = max((r for r in rows if r.engine == engine), key=lambda r: r.found[0])
    (_, accuracy, cost), (_, better, new) = best.start, best.found
    return (
        f"- {engine}: from {100 * accuracy:.1f} % at {significant(cost)} ms to {100 * better:.1f} "
        f"% at {significant(new)} ms ({best.algorithm}, {best.space}, seed {best.seed})."
    )


def algorithms(rows: Sequence[SearchRow]) -> list[Section]:
    """Sections of algorithms on the same engine and space; empty without two algorithms on one."""
    groups = _groups(rows)
    if not groups:
        return []
    lines = [(title, name, own) for title, group in groups.items() for name, own in group.items()]
    table = Table(
        lines,
        [
            words("searched", 0),
            words("algorithm", 1),
            Column("searches", 2, lambda own: str(len(own))),
            Column("genotypes", 2, lambda own: f"{fmean(r.genotypes for r in own):.0f}"),
            Column("hypervolume", 2, lambda own: _mean_and_range(_volumes(own), 3)),
            Column("best fitness", 2, lambda own: _mean_and_range(_fitness(own), 4)),
        ],
    )
    whole = {title: [r for own in g.values() for r in own] for title, g in groups.items()}
    picture = Picture(
        "algorithms",
        plot_algorithms(whole),
        "Left: hypervolume of the front so far over genotypes judged. Right: the "
        "fronts at the end, accuracy where the searches judged against modelled cost. "
        "A line a search.",
    )
    said = [
        f"- {title}: {_order(group, _volumes, 'hypervolume', 3)}; "
        f"{_order(group, _fitness, 'fitness', 4)}."
        for title, group in groups.items()
    ]
    return [
        Section(
            "Genetic against multi-objective",
            "\n".join(said) + "\n\nMeans over searches, with their range where there are several.",
            [table],
            [picture],
        )
    ]


def _groups(rows: Sequence[SearchRow]) -> Groups:
    """The searches of one engine in one space that more than one algorithm made."""
    found: dict[tuple[str, str], dict[str, list[SearchRow]]] = {}
    for row in rows:
        group = found.setdefault((row.engine, row.space), {})
        group.setdefault(row.algorithm, []).append(row)
    groups = {key: group for key, group in found.items() if len(group) > 1}
    alone = len({space for _, space in groups}) == 1
    return {engine if alone else f"{engine}, {space}": g for (engine, space), g in groups.items()}


def _volumes(rows: Sequence[SearchRow]) -> list[float]:
    return [r.hypervolume for r in rows]


def _fitness(rows: Sequence[SearchRow]) -> list[float]:
    return [r.found[0] for r in rows]


def _order(
    group: Mapping[str, Sequence[SearchRow]],
    value: Callable[[Sequence[SearchRow]], list[float]],
    what: str,
    digits: int,
) -> str:
    """Words on the algorithm with the largest mean of a value."""
    values = {algorithm: value(rows) for algorithm, rows in group.items()}
    ranked = sorted(values, key=lambda a: -fmean(values[a]))
    numbers = [f"{fmean(values[a]):.{digits}f}" for a in ranked]
    if numbers[0] == numbers[-1]:
        return f"the same {what} ({numbers[0]})"
    others = ", ".join(f"{n} ({a})" for n, a in zip(numbers[1:], ranked[1:], strict=True))
    said = f"the larger {what} is that of {ranked[0]}, {numbers[0]} against {others}"
    if min(values[ranked[0]]) <= max(values[ranked[1]]):
        said += ", not with every seed"
    return said


def _mean_and_range(values: Sequence[float], digits: int) -> str:
    mean = f"{fmean(values):.{digits}f}"
    if len(values) == 1:
        return mean
    return f"{mean} ({min(values):.{digits}f} to {max(values):.{digits}f})"


def luck(rows: Sequence[SeedRow]) -> Section:
    """Section of the results of the same search with other seeds."""
    said, tables = [], []
    for engine in dict.fromkeys(r.engine for r in rows):
        mine = [r for r in rows if r.engine == engine]
        genes = list(dict.fromkeys(g for r in mine for g in r.values))
        differing = [g for g in genes if len({r.values.get(g) for r in mine}) > 1]
        accuracies = [100 * r.test.accuracy.value for r in mine]
        costs = [r.test.cpu.value for r in mine]
        said.append(
            f"- {engine}, {len(mine)} seeds: test accuracy {fmean(accuracies):.1f} % on average, "
            f"from {min(accuracies):.1f} to {max(accuracies):.1f} %; CPU time "
            f"{significant(fmean(costs))} ms, from {significant(min(costs))} to "
            f"{significant(max(costs))} ms. "
            + (
                f"Seeds differ in {len(differing)} of {len(genes)} parameters: {names(differing)}."
                if differing
                else "All seeds found the same parameters."
            )
        )
        columns = [
            words("seed"),
            Column("fitness", "fitness", "{:.4f}".format),
            Column("validation %", "validation", plain_percent),
            Column("n", "test.accuracy.n"),
            Column("test %", "test.accuracy", percent),
            Column("CPU ms", "test.cpu", milliseconds),
            *columns_for(differing, "{}", "values"),
        ]
        tables.append(Table(mine, columns, f"**{engine}**"))
    return Section(
        "How much luck",
        "\n".join(said) + "\n\nEach seed's best genotype was tested once. The tables have those "
        "parameters that are not the same for all seeds.",
        tables,
    )
