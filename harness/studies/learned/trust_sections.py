"""The parts of the page of learned methods on calibration and on foreign layouts."""

from __future__ import annotations

from collections.abc import Sequence

from steadyload.reports.page import Picture, Section
from steadyload.reports.reliability_figures import plot_reliability, plot_risk
from steadyload.reports.reliability_tables import (
    abstention_table,
    bins_table,
    errors_table,
)
from steadyload.reports.table import markdown_table, percent
from steadyload.studies.learned.records import Foreign, ForeignRow, MethodCalibration


def calibration(judges: Sequence[MethodCalibration]) -> Section:
    """Section of the calibration of probabilities, and of accuracy with abstention."""
    kinds = {
        "a step is unstable": {judge.title: judge.steps for judge in judges},
        "a score is right": {judge.title: judge.layouts for judge in judges},
    }
    abstaining = {judge.title: judge.abstention for judge in judges}
    return Section(
        "Calibration, and not judging the unsure",
        "\n".join(_won(judge) for judge in judges)
        + "\n\nThe probability of a *step* is that it is unstable, all steps before it being "
        "stable: labels end with the first unstable step, and steps after it are not counted. So "
        "a judge gives a *score* of k the probability of step k times those of all steps before "
        "it being stable, and a stable layout the product over all its steps. That of the score "
        "that it names, at a threshold of 0.5, is how *sure* it is. *Brier*: mean square of the "
        "probability minus what happened, 0 or 1. *Expected calibration error*: the distance "
        "between mean probability and share that happened, over ten bins of equal width, weighted "
        "by the number of predictions; noise alone makes it larger than 0, and its interval leans "
        "upward.",
        [
            errors_table(kinds),
            f"Accuracy without the tenth of the cases that a judge is least sure of:\n\n"
            f"{abstention_table(abstaining)}",
            bins_table(kinds),
        ],
        [
            Picture(
                "learned-reliability",
                plot_reliability(kinds),
                "How often it happened against the probability that was given, of steps and of "
                "scores, with 95 % intervals; the diagonal keeps what it says.",
            ),
            Picture(
                "learned-risk",
                plot_risk(abstaining),
                "Share of wrong scores against the share of cases that are judged, the surest "
                "first.",
            ),
        ],
    )


def _won(judge: MethodCalibration) -> str:
    found = judge.abstention
    return (
        f"- {judge.title}: {100 * found.every.value:.1f} % accurate on all, "
        f"{100 * found.sure.value:.1f} % without the tenth that it is least sure of, "
        f"{100 * found.unsure.value:.1f} % on that tenth."
    )


def foreign(found: Foreign) -> Section:
    """Section of layouts of another kind."""
    titles = list(found.others)
    header = ("judge", "n", "refused %", *(f"as {t} %" for t in titles), "says stable %")
    inside = [row for row in found.rows if any(e.n for e in row.inside.values())]
    tables = [
        "Share of equal failing steps where all are judged (`outside=accept`):\n\n"
        + markdown_table(
            header,
            [
                (
                    row.method.title,
                    str(row.refused.n),
                    percent(row.refused),
                    *(percent(row.agreement[t]) for t in titles),
                    percent(row.stable),
                )
                for row in found.rows
            ],
        ),
        _reasons(found.rows),
        "The other methods:\n\n"
        + markdown_table(
            ("method", "n", "says stable %"),
            [(title, str(e.n), percent(e)) for title, e in found.others.items()],
        ),
    ]
    if found.among:
        tables.append(
            markdown_table(
                ("two other methods", "n", "same failing step %"),
                [(f"{a} and {b}", str(e.n), percent(e)) for (a, b), e in found.among.items()],
            )
        )
    if inside:
        tables.append(
            "On what is not refused:\n\n"
            + markdown_table(
                ("judge", "n", *(f"as {t} %" for t in titles)),
                [
                    (
                        row.method.title,
                        str(next(iter(row.inside.values())).n),
                        *(percent(row.inside[t]) for t in titles),
                    )
                    for row in inside
                ],
            )
        )
    return Section(
        "Layouts of another kind",
        "\n".join(_refusal(row) for row in found.rows)
        + f"\n\n{found.layouts} layouts of {found.files} files, of each the first "
        f"{found.max_items} items. A layout is refused where a quantity lies more than a tenth "
        "outside of what was trained on: a network gives a number there, too, and nothing says "
        "what it is worth. It is not scaled to the trained sizes, since a label's threshold is "
        "10 cm on a pallet of any size. These layouts have no label; how often other methods that "
        "learnt nothing agree with one another tells what agreement to expect.",
        tables,
    )


def _refusal(row: ForeignRow) -> str:
    told = ", ".join(f"{name} ({count})" for name, count, *_ in row.reasons)
    why = f", because of: {told}" if told else ""
    return f"- {row.method.title} refuses {percent(row.refused)} % of {row.refused.n}{why}."


def _reasons(rows: Sequence[ForeignRow]) -> str:
    return markdown_table(
        ("judge", "outside", "layouts", "trained on", "here"),
        [
            (row.method.title, name, str(count), _ends(trained), _ends(here))
            for row in rows
            for name, count, trained, here in row.reasons
        ],
        left=2,
    )


def _ends(ends: tuple[float, float]) -> str:
    return f"{ends[0]:g} to {ends[1]:g}"
