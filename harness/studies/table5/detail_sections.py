"""Sections of the page of Table 5 on where methods err, and on the paper's own numbers."""

from __future__ import annotations

from collections.abc import Sequence

from steadyload.reports.page import Picture, Section
from steadyload.reports.table import (
    MISSING,
    compact,
    markdown_table,
    milliseconds,
    percent,
)
from steadyload.runs.evaluation import ALL
from steadyload.studies.table5.figures import (
    plot_beside_paper,
    plot_errors,
    plot_margins,
    plot_sizes,
    rows_of,
)
from steadyload.studies.table5.paper import Paper
from steadyload.studies.table5.records import JudgedSet, Table5, Watch

_LINKED = "A linked layout opens in the browser, both loadings side by side. "

_ROUNDED = 0.0101
"""So far a mean of printed numbers may be from a printed mean, both rounded to 0.01 ms."""


def beside_the_paper(found: Table5) -> Section:
    """Accuracy and relative cost of the paper's methods, there and here."""
    own, paper = found.spatial, found.paper
    groups = [g for g in own.groups if g in paper.rows[0].accuracy]
    rows = []
    for row in own.evaluation.methods:
        printed = paper.row_of(row.method)
        if printed is None:
            continue
        rows.append(
            (
                row.method.title,
                str(row.accuracy.n),
                *(
                    f"{100 * printed.accuracy[group]:.1f} / {100 * at.accuracy.value:.1f}"
                    for group in groups
                    for at in rows_of(own, group)
                    if at.method == row.method
                ),
                compact(printed.runtime[ALL]),
                milliseconds(row.wall),
                *_shares(found, row.method.spec, printed.runtime[ALL]),
            )
        )
    header = (
        "method",
        "n",
        *(f"{group} %, paper / ours" for group in groups),
        "paper, wall ms",
        "ours, wall ms",
        "paper, of its PS_3",
        f"ours, of {own.timing.yardstick.title}" if own.timing.yardstick else "ours, share",
    )
    if not rows:
        return Section("Beside the paper", "None of the paper's methods was judged.")
    return Section(
        "Beside the paper",
        f"{paper.source}: {paper.cases} cases a scenario, without intervals and without over- and "
        f"underestimation; times on an {paper.machine}. It had other layouts of the same kind, "
        "labels of another simulator, weights of another density, and one engine. So accuracies "
        "differ for reasons that are not the methods'; the order of methods, and how scenarios "
        "differ, is what compares. Times compare as shares of PS_3, each in its own house. "
        f"{_paper_averages(paper)}",
        [markdown_table(header, rows)],
        [
            Picture(
                "beside_paper",
                plot_beside_paper(own, paper),
                "Accuracy of the paper's methods, in the paper (black bars) and here, by engine; "
                "lines are our 95 % intervals. PS_opt stands there twice here: the paper's values, "
                "and those of our own searches.",
            )
        ],
    )


def _shares(found: Table5, spec: str, runtime: float) -> tuple[str, str]:
    """Runtime over that of PS_3, in the paper and here."""
    timing, paper = found.spatial.timing, found.paper
    base = None if timing.yardstick is None else paper.row_of(timing.yardstick)
    ours = timing.shares[ALL].get(spec)
    own = timing.yardstick is not None and timing.yardstick.spec == spec
    return (
        MISSING if base is None else compact(runtime / base.runtime[ALL]),
        "1" if own else MISSING if ours is None else compact(ours.value),
    )


def _paper_averages(paper: Paper) -> str:
    off = [
        f"{row.title} {row.runtime[ALL]:.2f} (mean {row.runtime_mean:.2f})"
        for row in paper.rows
        if abs(row.runtime_mean - row.runtime[ALL]) > _ROUNDED
    ]
    if not off:
        return ""
    return (
        "Its averages of times stand here as printed; these are not the means of its scenarios: "
        f"{', '.join(off)}."
    )


def by_size(own: JudgedSet) -> Section:
    """Accuracy against the number of items."""
    header = ("method", *(f"{b.fewest} to {b.most} (n {b.cases})" for b in own.sizes))
    rows = [
        (
            m.method.title,
            *(percent(bin_.accuracy[m.method.spec]) for bin_ in own.sizes),
        )
        for m in own.evaluation.methods
    ]
    return Section(
        "By number of items",
        "Accuracy in per cent, by items in the layout, all scenarios. A layout of more items has "
        "more steps at which a method can part from the label. Layouts of 20 items are cut off at "
        "that number, and come from the item classes with many small items.",
        [markdown_table(header, rows)],
        [
            Picture(
                "sizes",
                plot_sizes(own),
                "Accuracy against the number of items, with 95 % intervals over item lists; those "
                "of 100 % are left to the table. Values near 100 % are spread out.",
            )
        ],
    )


def where_methods_err(own: JudgedSet) -> Section:
    """Over- and underestimation, and the balance of the steps at which methods part from labels."""
    pictures = [
        Picture(
            "errors",
            plot_errors(own),
            "Underestimated cases to the left, overestimated ones to the right, all scenarios.",
        )
    ]
    tables = []
    text = "An error is too careful or too bold: the method's step is too early or too late."
    if own.margins:
        text += (
            " The *margin* of a step says how far all contact patches may shrink until nothing "
            "balances any more; below 0 nothing does, and only time and friction decide whether "
            "the loading fails. Cases are followed to the step where method and label part."
        )
        pictures.append(
            Picture(
                "margins",
                plot_margins(own),
                "Of steps that hold by the label, those that a method calls failing (left), and of "
                "failing steps those that it calls holding (right), in per cent, by the margin of "
                "balance. n: steps of the labels; a method comes to fewer, once it has erred.",
            )
        )
        tables.append(_margins(own))
    return Section("Where methods err", text, tables, pictures)


def _margins(own: JudgedSet) -> str:
    """The two sides of balance: what does not balance and holds in time, and what balances."""
    slow = [bin_ for bin_ in own.margins if bin_.high <= 0.0 and bin_.holding]
    header = ("method", *(f"{_span(b.low, b.high)} (n {b.holding})" for b in slow))
    rows = [
        (
            m.method.title,
            *(
                f"{percent(bin_.false_alarms[m.method.spec])}, "
                f"n {bin_.false_alarms[m.method.spec].n}"
                for bin_ in slow
            ),
        )
        for m in own.evaluation.methods
    ]
    return (
        "False alarms on steps that do not balance, and hold for the label because they move too "
        f"slowly; per cent by margin in cm:\n\n{markdown_table(header, rows)}"
    )


def _span(low: float, high: float) -> str:
    return f"below {high:g}" if low == float("-inf") else f"{low:g} to {high:g}"


def to_watch(own: JudgedSet) -> Section:
    """Cases that divide the methods, with the commands that play them."""
    rows = [
        (
            f"[{w.layout}]({w.view})" if w.view else w.layout,
            w.scenario,
            str(w.item_count),
            w.label,
            w.right.title,
            f"{w.wrong.title}: {w.said}",
            f"{w.wrong_methods} of {w.methods}",
        )
        for w in own.watched
    ]
    header = ("layout", "scenario", "items", "label", "right", "wrong", "wrong methods")
    return Section(
        "Cases to watch",
        f"Of {own.about.cases} cases, those with a robust label that divide the methods most "
        "evenly, one an item list. *Right* and *wrong*: the most accurate methods on either side, "
        "and the failing step that the wrong one names. "
        f"{_LINKED if any(w.view for w in own.watched) else ''}"
        "These commands write the cases as layout "
        "files, and pages that play both loadings side by side:\n\n"
        f"```\n{_exports(own.watched)}\n{_views(own.watched)}\n```",
        [markdown_table(header, rows, left=2)],
    )


def _exports(watched: Sequence[Watch]) -> str:
    files = {(w.directory, w.part, w.scenario): w for w in watched}
    return "\n".join(
        " ".join(
            filter(
                None,
                (
                    "steadyload benchmark export",
                    directory,
                    f"--part {part} --scenario {scenario} -o {_file(w)}",
                ),
            )
        )
        for (directory, part, scenario), w in files.items()
    )


def _views(watched: Sequence[Watch]) -> str:
    return "\n".join(
        f"steadyload view {_file(w)} --layout {w.name} -m {w.wrong.spec} "
        f"--beside {w.right.spec} -o {w.name}.html"
        for w in watched
    )


def _file(watch: Watch) -> str:
    return "-".join(filter(None, (watch.directory, watch.part, watch.scenario))) + ".json"
