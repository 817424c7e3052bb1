"""The parts of the page of learned methods on calibration and on foreign layouts."""

from __future__ import annotations

from collections.abc import Sequence

from steadyload.reports.pages.page import Picture, Section
from steadyload.reports.pages.reliability_figures import plot_reliability, plot_risk
from steadyload.reports.pages.reliability_tables import (
    abstention_table,
    bins_table,
    errors_table,
)
from steadyload.reports.table import Column, Table, columns_for, estimates_table, percent, words
from steadyload.studies.learned.calibration import MethodCalibration
from steadyload.studies.learned.foreign import Foreign, ForeignRow


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
        + "\n\nAll cases are judged here, also those outside of what a network was trained on, "
        "which it refuses elsewhere. The probability of a *step* is that it is unstable, all "
        "steps before it being stable: labels end with the first unstable step, and steps after "
        "it are not counted. So a judge gives a *score* of k the probability of step k times those "
        "of all steps before it being stable, and a stable layout the product over all its steps. "
        "That of the score that it names, at a threshold of 0.5, is how *sure* it is. *Brier*: "
        "mean square of the probability minus what happened, 0 or 1. *Expected calibration error*: "
        "the distance between mean probability and share that happened, over ten bins of equal "
        "width, weighted by the number of predictions; noise alone makes it larger than 0, and its "
        "interval leans upward.",
        [
            errors_table(kinds),
            abstention_table(
                abstaining, "Accuracy without the tenth of the cases that a judge is least sure of:"
            ),
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


_METHOD = words("judge", "method.title")


def foreign(found: Foreign) -> Section:
    """Section of layouts of another kind."""
    refused = [
        _METHOD,
        Column("n", "refused.n"),
        Column("refused %", "refused", percent),
        *columns_for(found.others, "as {} %", "agreement", percent),
        Column("says stable %", "stable", percent),
    ]
    inside = [
        _METHOD,
        Column("n", lambda row: next(iter(row.inside.values())).n),
        *columns_for(found.others, "as {} %", "inside", percent),
    ]
    accepted = "Share of equal failing steps where all are judged (`outside=accept`):"
    kept = [row for row in found.rows if any(e.n for e in row.inside.values())]
    among = {f"{a} and {b}": share for (a, b), share in found.among.items()}
    others = "The other methods:"
    tables = [
        Table(found.rows, refused, accepted),
        _reasons(found.rows),
        estimates_table("method", found.others, "says stable %", caption=others),
        *([estimates_table("two other methods", among, "same failing step %")] if among else []),
        *([Table(kept, inside, "On what is not refused:")] if kept else []),
    ]
    return Section(
        "Layouts of another kind",
        "\n".join(_refusal(row) for row in found.rows)
        + f"\n\n{found.layouts} layouts of {found.files} files, of each the first "
        f"{found.max_items} items. A layout is refused where a quantity lies more than a tenth "
        "outside of what was trained on: a network gives a number there, too, and nothing says "
        "what it is worth. It is not scaled to the trained sizes, since a label's threshold is "
        "10 cm on a pallet of any size. These layouts have no label; how often other methods that "
        "learnt nothing agree with one another shows what agreement to expect.",
        tables,
    )


def _refusal(row: ForeignRow) -> str:
    told = ", ".join(f"{name} ({count})" for name, count, *_ in row.reasons)
    why = f", because of: {told}" if told else ""
    return f"- {row.method.title} refuses {percent(row.refused)} % of {row.refused.n}{why}."


def _reasons(rows: Sequence[ForeignRow]) -> Table:
    columns = [
        words("judge", 0),
        words("outside", 1),
        Column("layouts", 2),
        Column("trained on", 3, _ends),
        Column("here", 4, _ends),
    ]
    return Table([(row.method.title, *why) for row in rows for why in row.reasons], columns)


def _ends(ends: tuple[float, float]) -> str:
    return f"{ends[0]:g} to {ends[1]:g}"
