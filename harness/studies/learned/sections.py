"""The parts of the page of learned methods that compare trainings with one another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from steadyload.reports.charts.curves import curves
from steadyload.reports.charts.forest import forest
from steadyload.reports.pages.page import Picture, Section
from steadyload.reports.table import (
    MISSING,
    Column,
    Table,
    columns_for,
    estimates_table,
    names,
    percent,
    words,
)
from steadyload.runs.evaluation import ALL
from steadyload.statistics.estimate import Estimate
from steadyload.studies.learned.summary import LeakRow, SizeCurve, TrainedRow

_SHIFTED = "S2b"
"""The scenario whose centres of mass are shifted the most."""

_GAIN = 0.08
"""Gain of accuracy that is the target of remedies there."""


def size(trainings: Sequence[SizeCurve]) -> Section:
    """Accuracy against the size of the training set."""
    return Section(
        "Size of the training set",
        "\n".join(_growth(curve) for curve in trainings)
        + "\n\nA training set grows by *cases* that are drawn from the same item lists, or by "
        "*item lists*: the two are not the same, since layouts packed from one list are alike. "
        f"{_SEEDS_EXPLAINED}",
        [_rows(curve.rows, caption=f"**{curve.title}**") for curve in trainings],
        [
            Picture(
                "learned-size",
                curves(
                    trainings,
                    ("cases", "item_lists"),
                    f"accuracy.{ALL}",
                    within="rows",
                    percent="y",
                    log="x",
                    ticks="apart",
                    x_label=("cases learnt from", "item lists learnt from"),
                    y_label="accuracy (%)",
                    size=(9.0, 3.8),
                    markersize=5.0,
                    linewidth=1.0,
                    elinewidth=1.0,
                ).figure,
                "Accuracy over all scenarios against the number of cases and of item lists that "
                "were learnt from, with 95 % intervals.",
            )
        ],
    )


_SEEDS_EXPLAINED = (
    "Accuracies are means over the seeds of a training, and their intervals show how far other "
    "item lists to be judged would move them; *seeds* are the least and the greatest accuracy of "
    "a seed, and how many there are."
)


def _growth(curve: SizeCurve) -> str:
    first, last = (f(curve.rows, key=lambda r: r.cases) for f in (min, max))
    return (
        f"- {curve.title}: from {_set(first)} to {_set(last)}, accuracy goes from "
        f"{100 * first.accuracy[ALL].value:.1f} to {100 * last.accuracy[ALL].value:.1f} %."
    )


def _set(row: TrainedRow) -> str:
    return f"{row.cases} cases of {row.item_lists} item lists"


def sources(rows: Sequence[TrainedRow], agreement: Mapping[str, Estimate]) -> Section:
    """Section of accuracy by the source of the training labels."""
    tables = [_rows(rows), _differences(rows)]
    if agreement:
        caption = (
            "How often a source gives the label that the first one gives, on the layouts that were "
            "learnt from:"
        )
        tables.append(estimates_table("label source", agreement, "same label %", caption=caption))
    return Section(
        "Label source",
        "\n".join(_held(row, ALL) for row in rows if row.difference is not None)
        + f"\n\nAll are compared with {rows[0].title}. *Then*: training went on from the weights "
        f"that the labels before it had made. {_SEEDS_EXPLAINED}",
        tables,
    )


def remedies(rows: Sequence[TrainedRow]) -> Section:
    """Section of the accuracy lost by shifted centres of mass, and the gain of each remedy."""
    plain = rows[0]
    said = []
    if _SHIFTED in plain.accuracy and "S1" in plain.accuracy:
        drops = [
            f"{row.title} {100 * (row.accuracy['S1'].value - row.accuracy[_SHIFTED].value):.1f}"
            for row in rows
        ]
        said.append(f"From S1 to {_SHIFTED} accuracy drops by these points: {'; '.join(drops)}.")
        reached = [
            row.title for row in rows if row.difference and row.difference[_SHIFTED].value >= _GAIN
        ]
        said.append(
            f"At least {100 * _GAIN:g} points above {plain.title} on {_SHIFTED}: {names(reached)}."
        )
        said.append("\n".join(_held(row, _SHIFTED) for row in rows if row.difference is not None))
    said.append(
        "*Symmetry*: a training draws one of the pallet's 8 turns and mirrors for every layout. "
        "*Attention*: at every step the network looks back at the items placed by then. *Support "
        "features*: they say how an item, and all that carries it, stands on what is below. "
        f"{_SEEDS_EXPLAINED}"
    )
    return Section(
        "Shifted centres of mass",
        "\n\n".join(said),
        [_rows(rows, means=True), _differences(rows)],
        [
            Picture(
                "learned-remedies",
                forest(
                    [
                        {
                            "scenario": group,
                            "title": row.title,
                            "accuracy": found,
                            "seeds": row.seeds[group],
                        }
                        for row in rows
                        for group, found in row.accuracy.items()
                        if group != ALL
                    ],
                    "accuracy",
                    panel="scenario",
                    dots="seeds",
                    x_label="accuracy (%)",
                ).figure,
                "Accuracy by scenario; bars are 95 % intervals, dots are single seeds.",
            )
        ],
    )


def leak(rows: Sequence[LeakRow]) -> Section:
    """Section of the gain of training on layouts of held-out item lists."""
    said = [
        f"- {row.leaky.title} beside {row.honest.title}: {percent(row.leaky.difference[ALL])} "
        f"points over {row.leaky.accuracy[ALL].n} cases, learnt from {row.leaky.cases} cases and "
        f"{row.honest.cases}."
        for row in rows
        if row.leaky.difference is not None
    ]
    tables = [shown((row.honest, row.leaky)) for row in rows for shown in (_rows, _differences)]
    return Section(
        "What a leak is worth",
        "\n".join(said)
        + "\n\nA leaky training learns from the sisters of the cases that are judged, too: layouts "
        "packed from the same item lists, and the same geometries with other centres of mass; not "
        "from these cases themselves.",
        tables,
    )


def _held(row: TrainedRow, part: str) -> str:
    """Difference of a training to the one that it is compared with, as a line."""
    assert row.difference is not None
    found = row.difference[part]
    told = "" if found.low > 0.0 or found.high < 0.0 else ", not significantly different"
    where = "" if part == ALL else f" on {part}"
    return f"- {row.title}: {percent(found)} points{where}{told}."


def _rows(rows: Sequence[TrainedRow], *, means: bool = False, caption: str = "") -> Table:
    """Table of trainings; ``means`` adds columns of the settings by which they differ."""
    about = ("features", "network", "symmetries") if means else ("labels",)
    groups = rows[0].accuracy
    columns = [
        words("training", "title"),
        *map(words, about),
        *([] if means else [_N]),
        *columns_for(groups, "{} %", "accuracy", percent),
        Column("all seeds", lambda row: row.seeds[ALL], _spread, notable=True),
        *columns_for([g for g in groups if g != ALL], "{} seeds", "seeds", _spread),
        *([_N] if means else []),
        Column("cases"),
        Column("item lists", "item_lists"),
    ]
    return Table(rows, columns, caption)


_N = Column("n", lambda row: row.accuracy[ALL].n)


def _differences(rows: Sequence[TrainedRow]) -> Table:
    return Table(
        [row for row in rows if row.difference is not None],
        [
            words(f"minus {rows[0].title}", "title"),
            _N,
            *columns_for(rows[0].accuracy, "{}", "difference", percent),
        ],
    )


def _spread(seeds: Sequence[float]) -> str:
    if len(seeds) < 2:
        return MISSING
    return f"{100 * min(seeds):.1f} to {100 * max(seeds):.1f} ({len(seeds)})"
