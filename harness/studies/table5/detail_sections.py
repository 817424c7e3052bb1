"""Sections of the page of Table 5 on the errors of methods, and on the paper's own numbers."""

from __future__ import annotations

import shlex
from collections.abc import Sequence

from steadyload.escaping import markdown, printable
from steadyload.reports.pages.page import Picture, Section
from steadyload.reports.table import Column, Table, columns_for, compact, percent, words
from steadyload.runs.evaluation import ALL, MethodEvaluation
from steadyload.runs.paper import Paper
from steadyload.statistics.estimate import Estimate
from steadyload.studies import method_sections as column
from steadyload.studies.table5.accuracy_sections import share_of_time
from steadyload.studies.table5.error_places import MarginBin
from steadyload.studies.table5.figures import (
    plot_beside_paper,
    plot_errors,
    plot_margins,
    plot_sizes,
)
from steadyload.studies.table5.summary import JudgedSet
from steadyload.studies.table5.watched import Watch

_LINKED = "A linked layout opens in the browser, both loadings side by side. "

_ROUNDED = 0.0101
"""Largest difference [ms] of a mean of printed numbers to a printed mean, rounded to 0.01 ms."""


def beside_the_paper(own: JudgedSet, paper: Paper) -> Section:
    """Accuracy and relative cost of the paper's methods, there and here."""
    yard = own.timing.yardstick
    columns_of = {m.method.spec: paper.row_of(m.method) for m in own.evaluation.methods}
    printed = {spec: row for spec, row in columns_of.items() if row is not None}
    rows = [m for m in own.evaluation.methods if m.method.spec in printed]
    if not rows:
        return Section("Beside the paper", "None of the paper's methods was judged.")

    def both(row: MethodEvaluation, group: str) -> str:
        ours = own.evaluation.row(row.method.spec, group).accuracy
        return f"{100 * printed[row.method.spec].accuracy[group]:.1f} / {100 * ours.value:.1f}"

    wall = {spec: row.runtime[ALL] for spec, row in printed.items()}
    base = None if yard is None else paper.row_of(yard)
    shares = {} if base is None else {s: time / base.runtime[ALL] for s, time in wall.items()}
    columns = [
        column.METHOD,
        column.N,
        *columns_for(paper.among(own.groups), "{} %, paper / ours", both),
        column.by_spec("paper, wall ms", wall, compact),
        column.titled(column.WALL, "ours, wall ms"),
        column.by_spec("paper, of its PS_3", shares, compact),
        share_of_time(
            own,
            ALL,
            f"ours, of {yard.title}" if yard else "ours, share",
            lambda e: compact(e.value),
        ),
    ]
    return Section(
        "Beside the paper",
        f"{paper.source}: {paper.cases} cases a scenario, without intervals and without over- and "
        f"underestimation; times on an {paper.machine}. It had other layouts of the same kind, "
        "labels of another simulator, weights by another law, and one engine. So accuracies "
        "differ for reasons that are not the methods'; the order of methods, and how scenarios "
        "differ, is what compares. Times compare as shares of PS_3, each in its own house. "
        f"{_paper_averages(paper)}",
        [Table(rows, columns)],
        [
            Picture(
                "beside_paper",
                plot_beside_paper(own, paper),
                "Accuracy of the paper's methods, in the paper (black bars) and here, by engine; "
                "lines are our 95 % intervals. PS_3, PS_5 and PS_opt stand twice: as the paper "
                "prints them, and converted to SI or with values of our own searches.",
            )
        ],
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
    columns = columns_for(
        own.sizes,
        lambda b: f"{b.fewest} to {b.most} (n {b.cases})",
        lambda row, b: b.accuracy[row.method.spec],
        percent,
    )
    return Section(
        "By number of items",
        "Accuracy in per cent, by items in the layout, all scenarios. A layout of more items has "
        "more steps at which a method can part from the label. Layouts of 20 items are cut off at "
        "that number, and come from the item classes with many small items.",
        [Table(own.evaluation.methods, [column.METHOD, *columns])],
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
    """Over- and underestimation, and the balance of steps at which methods differ from labels."""
    caption = "Underestimated cases to the left, overestimated ones to the right, all scenarios."
    pictures = [Picture("errors", plot_errors(own), caption)]
    text = "An error is too careful or too bold: the method's step is too early or too late."
    if not own.margins:
        return Section("Where methods err", text, [], pictures)
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
    return Section("Where methods err", text, [_margins(own)], pictures)


def _margins(own: JudgedSet) -> Table:
    """False alarms on steps that hold although they are out of balance."""

    def title(found: MarginBin) -> str:
        below = found.low == float("-inf")
        span = f"below {found.high:g}" if below else f"{found.low:g} to {found.high:g}"
        return f"{span} (n {found.holding})"

    def alarms(row: MethodEvaluation, found: MarginBin) -> Estimate:
        return found.false_alarms[row.method.spec]

    slow = [b for b in own.margins if b.high <= 0.0 and b.holding]
    return Table(
        own.evaluation.methods,
        [column.METHOD, *columns_for(slow, title, alarms, lambda e: f"{percent(e)}, n {e.n}")],
        "False alarms on steps that do not balance, and hold for the label because they move too "
        "slowly; per cent by margin in cm:",
    )


def _linked(watched: Watch) -> str:
    name = markdown(watched.layout)
    return f"[{name}]({watched.view})" if watched.view else name


def to_watch(own: JudgedSet) -> Section:
    """Section of cases on which methods differ, with the commands that play them."""
    columns = [
        words("layout", _linked),
        words("scenario"),
        Column("items", "item_count"),
        Column("label"),
        Column("right", "right.title"),
        Column("wrong", lambda w: f"{w.wrong.title}: {w.said}"),
        Column("wrong methods", lambda w: f"{w.wrong_methods} of {w.methods}"),
    ]
    return Section(
        "Cases to watch",
        f"Of {own.about.cases} cases, those with a robust label that divide the methods most "
        "evenly, one an item list. *Right* and *wrong*: the most accurate methods on either side, "
        "and the failing step that the wrong one names. "
        f"{_LINKED if any(w.view for w in own.watched) else ''}"
        "These commands write the cases as layout "
        "files, and pages that play both loadings side by side:\n\n"
        f"```\n{_commands(own.watched)}\n```",
        [Table(own.watched, columns)],
    )


def _quoted(name: str) -> str:
    """A name as a word of a command line, without what ends a block of code."""
    return shlex.quote(printable(name).replace("`", "'"))


def _commands(watched: Sequence[Watch]) -> str:
    """Command lines that export the cases, a file a scenario, and then play them."""
    files = {_file(w): w for w in watched}
    exports = (
        f"steadyload benchmark export {w.directory + ' ' if w.directory else ''}--part {w.part} "
        f"--scenario {w.scenario} -o {file}"
        for file, w in files.items()
    )
    views = (
        f"steadyload view {_file(w)} --layout {_quoted(w.name)} -m {w.wrong.spec} "
        f"--beside {w.right.spec} -o {_quoted(w.name.replace('/', '_') + '.html')}"
        for w in watched
    )
    return "\n".join([*exports, *views])


def _file(watch: Watch) -> str:
    return "-".join(filter(None, (watch.directory, watch.part, watch.scenario))) + ".json"
