"""The part of the page of tuning that compares searches with each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from steadyload.reports.page import Picture, Section
from steadyload.reports.table import (
    duration,
    markdown_table,
    milliseconds,
    names,
    percent,
    significant,
)
from steadyload.studies.tuning.records import SearchRow, SeedRow
from steadyload.studies.tuning.search_figures import plot_algorithms, plot_histories


def searches(rows: Sequence[SearchRow]) -> Section:
    """Section of the effort and result of each search."""
    judged, whole = sum(r.genotypes for r in rows), sum(r.whole for r in rows)
    said = [
        f"{len(rows)} {'search' if len(rows) == 1 else 'searches'} judged {judged:,} genotypes in "
        f"{duration(sum(r.cpu for r in rows))} of CPU time, {whole:,} of them on all cases"
        + (f"; the other {judged - whole:,} were given up before." if judged > whole else ".")
    ]
    said.append("\n".join(_best_of(engine, rows) for engine in _engines(rows)))
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
        [_table(rows)],
        [
            Picture(
                "searches",
                plot_histories(rows),
                "Fitness over genotypes judged, a line a search: the best so far (thick) and the "
                "median of a generation (thin). Medians far below are cut off.",
            )
        ],
    )


def _engines(rows: Sequence[SearchRow]) -> list[str]:
    return list(dict.fromkeys(r.engine for r in rows))


def _best_of(engine: str, rows: Sequence[SearchRow]) -> str:
    best = max((r for r in rows if r.engine == engine), key=lambda r: r.found[0])
    (_, accuracy, cost), (_, better, new) = best.start, best.found
    return (
        f"- {engine}: from {100 * accuracy:.1f} % at {significant(cost)} ms to {100 * better:.1f} "
        f"% at {significant(new)} ms ({best.algorithm}, {best.space}, seed {best.seed})."
    )


def _table(rows: Sequence[SearchRow]) -> str:
    header = (
        "engine", "algorithm", "space", "seed", "population", "genotypes", "judged whole",
        "given up", "repeats", "CPU", "wall", "fitness", "accuracy %", "cost ms", "hypervolume",
    )  # fmt: skip
    return markdown_table(
        header,
        [
            (
                r.engine,
                r.algorithm,
                r.space,
                str(r.seed),
                f"{r.population} x {r.generations}",
                str(r.genotypes),
                str(r.whole),
                str(r.genotypes - r.whole),
                str(r.repeats),
                duration(r.cpu),
                duration(r.wall),
                f"{r.start[0]:.4f} → {r.found[0]:.4f}",
                f"{100 * r.start[1]:.1f} → {100 * r.found[1]:.1f}",
                f"{significant(r.start[2])} → {significant(r.found[2])}",
                f"{r.hypervolume:.3f}",
            )
            for r in rows
        ],
        left=3,
    )


def algorithms(rows: Sequence[SearchRow]) -> list[Section]:
    """Sections of algorithms on the same engine and space; empty without two algorithms on one."""
    groups = _groups(rows)
    if not groups:
        return []
    table = markdown_table(
        ("searched", "algorithm", "searches", "genotypes", "hypervolume", "best fitness"),
        [
            (
                title,
                algorithm,
                str(len(mine)),
                f"{_mean([r.genotypes for r in mine]):.0f}",
                _mean_and_range([r.hypervolume for r in mine], 3),
                _mean_and_range([r.found[0] for r in mine], 4),
            )
            for title, group in groups.items()
            for algorithm, mine in _by_algorithm(group).items()
        ],
        left=2,
    )
    return [
        Section(
            "Genetic against multi-objective",
            "\n".join(_larger(title, group) for title, group in groups.items())
            + "\n\nMeans over searches, with their range where there are several.",
            [table],
            [
                Picture(
                    "algorithms",
                    plot_algorithms(groups),
                    "Left: hypervolume of the front so far over genotypes judged. Right: the "
                    "fronts at the end, accuracy where the searches judged against modelled cost. "
                    "A line a search.",
                )
            ],
        )
    ]


def _groups(rows: Sequence[SearchRow]) -> dict[str, list[SearchRow]]:
    """By title, the searches of one engine in one space that more than one algorithm made."""
    found: dict[tuple[str, str], list[SearchRow]] = {}
    for row in rows:
        found.setdefault((row.engine, row.space), []).append(row)
    groups = {key: mine for key, mine in found.items() if len(_by_algorithm(mine)) > 1}
    alone = len({space for _, space in groups}) == 1
    return {engine if alone else f"{engine}, {space}": g for (engine, space), g in groups.items()}


def _by_algorithm(rows: Sequence[SearchRow]) -> dict[str, list[SearchRow]]:
    found: dict[str, list[SearchRow]] = {}
    for row in rows:
        found.setdefault(row.algorithm, []).append(row)
    return found


def _larger(title: str, rows: Sequence[SearchRow]) -> str:
    """Sentence on the algorithms with the largest mean hypervolume and the best mean fitness."""
    mine = _by_algorithm(rows)
    volume = {a: [r.hypervolume for r in group] for a, group in mine.items()}
    fitness = {a: [r.found[0] for r in group] for a, group in mine.items()}
    return f"- {title}: {_order(volume, 'hypervolume', 3)}; {_order(fitness, 'fitness', 4)}."


def _order(values: Mapping[str, Sequence[float]], what: str, digits: int) -> str:
    ranked = sorted(values, key=lambda a: -_mean(values[a]))
    numbers = [f"{_mean(values[a]):.{digits}f}" for a in ranked]
    if numbers[0] == numbers[-1]:
        return f"the same {what} ({numbers[0]})"
    others = ", ".join(f"{n} ({a})" for n, a in zip(numbers[1:], ranked[1:], strict=True))
    said = f"the larger {what} is that of {ranked[0]}, {numbers[0]} against {others}"
    if min(values[ranked[0]]) <= max(values[ranked[1]]):
        said += ", not with every seed"
    return said


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)


def _mean_and_range(values: Sequence[float], digits: int) -> str:
    mean = f"{_mean(values):.{digits}f}"
    if len(values) == 1:
        return mean
    return f"{mean} ({min(values):.{digits}f} to {max(values):.{digits}f})"


def luck(rows: Sequence[SeedRow]) -> Section:
    """Section of the results of the same search with other seeds."""
    engines = list(dict.fromkeys(r.engine for r in rows))
    said, tables = [], []
    for engine in engines:
        mine = [r for r in rows if r.engine == engine]
        genes = list(dict.fromkeys(g for r in mine for g in r.values))
        differing = [g for g in genes if len({r.values.get(g) for r in mine}) > 1]
        accuracies = [100 * r.test.accuracy.value for r in mine]
        costs = [r.test.cpu.value for r in mine]
        said.append(
            f"- {engine}, {len(mine)} seeds: test accuracy {_mean(accuracies):.1f} % on average, "
            f"from {min(accuracies):.1f} to {max(accuracies):.1f} %; CPU time "
            f"{significant(_mean(costs))} ms, from {significant(min(costs))} to "
            f"{significant(max(costs))} ms. "
            + (
                f"Seeds differ in {len(differing)} of {len(genes)} parameters: {names(differing)}."
                if differing
                else "All seeds found the same parameters."
            )
        )
        tables.append(f"**{engine}**\n\n{_seed_table(mine, differing)}")
    return Section(
        "How much luck",
        "\n".join(said) + "\n\nEach seed's best genotype was tested once. The tables have those "
        "parameters that are not the same for all seeds.",
        tables,
    )


def _seed_table(rows: Sequence[SeedRow], differing: Sequence[str]) -> str:
    return markdown_table(
        ("seed", "fitness", "validation %", "n", "test %", "CPU ms", *differing),
        [
            (
                str(r.seed),
                f"{r.fitness:.4f}",
                f"{100 * r.validation:.1f}",
                str(r.test.accuracy.n),
                percent(r.test.accuracy),
                milliseconds(r.test.cpu),
                *(r.values.get(g, "-") for g in differing),
            )
            for r in rows
        ],
    )
