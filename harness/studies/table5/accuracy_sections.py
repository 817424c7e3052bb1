"""Sections of the page of Table 5 on every method's accuracy and cost, and on labels."""

from __future__ import annotations

from steadyload.methods.naming import MethodKey
from steadyload.reports.page import Picture, Section
from steadyload.reports.table import (
    MISSING,
    compact,
    factor,
    markdown_table,
    milliseconds,
    names,
    percent,
    significant,
)
from steadyload.runs.costs import load_explained
from steadyload.runs.evaluation import ALL, MethodEvaluation
from steadyload.studies.table5.figures import plot_fronts, rows_of
from steadyload.studies.table5.records import JudgedSet, Table5

_NETWORKS = frozenset({"lstm_1", "lstm_e"})
_CONVERTED = frozenset({"ps3", "ps5"})

_OWN_NETWORKS = (
    "The rows LSTM_1 and LSTM_e are networks of our own, which are told how every item is "
    "supported. The paper's own network, told no more than the paper's, is not in this table: "
    "after 200 epochs it is right on 60.4 [53.7, 66.8] % of the 3,000 cases of part `test` "
    "(`reports/published/learned`)."
)
_READING = (
    "The rows PS_3 and PS_5 are the authors' numbers converted to SI (0.4 s at 600 Hz). The "
    "paper's own figures are probably of the literal reading (4 s at 60 Hz): on the first 100 test "
    "cases of every scenario `ps3-literal@bullet` is right on 82.3 [77.1, 86.6] % and "
    "`ps5-literal@bullet` on 80.0 [74.6, 84.5] % (n = 300), where the paper has 82.33 and 79.22 % "
    "on its own 900 cases; the converted `ps3@bullet` is right on 88.3 [83.9, 91.6] % of those 300."
)


def accuracy_and_cost(found: Table5) -> Section:
    """All methods, by group, with Fig. 3 of the paper."""
    own = found.spatial
    tables = []
    for group in own.groups:
        table = _table(found, own, group)
        tables.append(table if group == ALL else f"**Scenario {group}**\n\n{table}")
    yard = own.timing.yardstick
    natural = ", ".join(f"{s} {100 * share:.1f} %" for s, share in own.about.natural_stable.items())
    return Section(
        "Accuracy and cost",
        "All scenarios first, then each by itself. *Paper*: what the paper's Table 5 has. "
        "*Letters*: two methods share one just where their accuracies are not told apart (next "
        "section). *Overestimated*: the method lets the loading fail later than the label does, "
        "or not at all; *underestimated*: earlier; the paper does not part the two. A label is "
        "*robust* when every judge of its ensemble names the same step, and *fragile* when one "
        "does not. *Natural prevalence*: as accurate as if stable layouts were as frequent as in "
        f"the whole set ({natural}). {own.evaluation.cost_source.explained()}"
        + ("" if yard is None else f" *Share*: of the CPU time of {yard.title} on the same cases.")
        + what_rows_are(own),
        tables,
        [
            Picture(
                "accuracy",
                plot_fronts(own, found.ceiling),
                "Fig. 3 of the paper: accuracy against CPU time, for all cases and by scenario; "
                "good methods stand at the upper left, and accuracies near 100 % are spread out. "
                "The dashed line is the front: above it and to its left there is none. Hollow "
                "markers have parameters of their own, bars are 95 % intervals.",
            )
        ],
    )


def what_rows_are(own: JudgedSet) -> str:
    """In what rows differ from the paper's methods of the same name, where there are such rows."""
    families = {row.method.family for row in own.evaluation.methods}
    told = [
        said
        for rows, said in ((_NETWORKS, _OWN_NETWORKS), (_CONVERTED, _READING))
        if rows & families
    ]
    return "".join(f"\n\n{said}" for said in told)


def _table(found: Table5, own: JudgedSet, group: str) -> str:
    rows = rows_of(own, group)
    header = (
        "method",
        "n",
        "paper %",
        "accuracy %",
        "letters",
        "overestimated %",
        "underestimated %",
        "stable or not %",
        f"robust % (n {rows[0].robust.n})",
        f"fragile % (n {rows[0].fragile.n})",
        "natural prevalence %",
        "CPU ms",
        "share",
        "no verdict, and why",
    )
    lines = [_line(found, own, group, row) for row in rows]
    blank = len(header) - 3
    if own is found.spatial:
        for method in found.planar_methods:
            why = "judges planar layouts alone, see there"
            if group == ALL:
                why += f" ({found.flat} of these cases are planar)"
            lines.append((method.title, "0", *[MISSING] * blank, why))
        for spec, why in found.left_out.items():
            lines.append((spec, "0", *[MISSING] * blank, why))
    return markdown_table(header, lines)


def _line(found: Table5, own: JudgedSet, group: str, row: MethodEvaluation) -> tuple[str, ...]:
    printed = found.paper.row_of(row.method) if own is found.spatial else None
    return (
        row.method.title,
        str(row.accuracy.n),
        MISSING if printed is None else f"{100 * printed.accuracy[group]:.2f}",
        percent(row.accuracy),
        own.tests[group].letters[row.method.spec],
        percent(row.over),
        percent(row.under),
        percent(row.stable_or_not),
        percent(row.robust),
        percent(row.fragile),
        percent(row.natural),
        milliseconds(row.cpu),
        _share(own, group, row),
        names(f"{count} {status}" for status, count in row.without_verdict.items()),
    )


def _share(own: JudgedSet, group: str, row: MethodEvaluation) -> str:
    """CPU time over that of the yardstick."""
    if row.method == own.timing.yardstick:
        return "1"
    return factor(own.timing.shares[group].get(row.method.spec))


def noise_of_labels(found: Table5) -> Section:
    """How often answers to a label's question agree, and on which labels methods err."""
    assert found.ceiling is not None
    own, ceiling = found.spatial, found.ceiling
    n = str(own.about.cases)
    rows = [
        (
            row.name,
            str(row.judges),
            str(row.label.n),
            *(
                cell
                for group in own.groups
                for at in (ceiling.by_group[group][place],)
                for cell in (percent(at.twin), percent(at.plurality))
            ),
        )
        for place, row in enumerate(ceiling.by_group[ALL])
    ]
    header = ("what changes", "further answers", "n", *(
        f"{what}, {group} %" for group in own.groups for what in ("two answers", "best guess")
    ))  # fmt: skip
    others = [(row.name, str(row.label.n), percent(row.label)) for row in ceiling.engines]
    fragile = own.about.fragile
    errors = [
        (
            m.method.title,
            str(m.accuracy.n),
            percent(m.robust),
            percent(m.fragile),
            _share_of_errors(m),
        )
        for m in own.evaluation.methods
    ]
    return Section(
        "What the labels leave to be reached",
        "A label is one answer of the reference, and the reference was asked again with small "
        "changes: other numerics, other contacts, thresholds and time 10 % off. *Two answers*: how "
        "often two of all its answers, drawn at random for every case, name the same step. That is "
        "what a method may expect which is as good as the reference, and no copy of it: one more "
        "draw. *Best guess*: how often one answer is the most frequent of the others; so much "
        "reaches who knows all other draws and names the likeliest. Neither is a bound for a copy "
        "of the reference, which reaches 100 %, nor for a method that has learnt the reference's "
        "habits; and both hang on how large the changes are, which we chose. Read them so: above "
        "*two answers*, who is more accurate agrees better with this reference, and that need not "
        "mean with mechanics.",
        [
            markdown_table(header, rows),
            *(
                [
                    "Other simulators, asked the label's own question (small steps, the same "
                    "thresholds and time):\n\n"
                    + markdown_table(("judge", "n", "accuracy %"), others)
                ]
                if others
                else []
            ),
            f"Errors by label, n = {n}, of which {fragile} ({100 * fragile / int(n):.1f} %) are "
            "fragile:\n\n"
            + markdown_table(
                ("method", "n", "robust %", "fragile %", "errors on fragile labels %"), errors
            ),
        ],
    )


def _share_of_errors(row: MethodEvaluation) -> str:
    """How much of a method's errors lies on fragile labels."""
    if row.fragile.n == 0 or row.accuracy.value == 1.0:
        return MISSING
    wrong = (1.0 - row.accuracy.value) * row.accuracy.n
    return f"{100 * (1.0 - row.fragile.value) * row.fragile.n / wrong:.0f} (of {wrong:.0f})"


def time_a_layout(own: JudgedSet) -> Section:
    """The timing pass."""
    timing = own.timing
    yard = timing.yardstick
    rows = [
        (
            row.method.title,
            str(row.cpu.n),
            milliseconds(row.cpu),
            milliseconds(row.wall),
            _share(own, ALL, row),
            *(_cpu(own, group, row.method) for group in own.groups[1:]),
            f"{100 * timing.spread[row.method.spec]:.0f}" if timing.repeats > 1 else MISSING,
        )
        for row in own.evaluation.methods
        if row.cpu.n
    ]
    header = (
        "method",
        "n",
        "CPU ms",
        "wall ms",
        "share" if yard is None else f"of {yard.title}",
        *(f"{group} CPU ms" for group in own.groups[1:]),
        "spread of repeats %",
    )
    busy = load_explained(own.evaluation.cost_source.load)
    untimed = "".join(f" {spec} was not timed: {why}." for spec, why in timing.untimed.items())
    refused = names(f"{spec} {count}" for spec, count in timing.refused.items())
    without = f", without those that a method refuses ({refused})" if timing.refused else ""
    return Section(
        "Time a layout",
        f"A pass of its own: one process, one thread, {timing.layouts} cases of "
        f"{timing.item_lists} item lists, those of the first ranks{without}. Every method judges "
        f"{timing.block} cases, one at a time, then it is the next one's turn; all is done "
        f"{timing.repeats} times. A case counts with the median of its repeats, a method with the "
        "mean over cases. *Spread*: the slowest repeat minus the fastest, over the mean. Making "
        f"ready (imports, compilation, weights) is not in it.{busy}{untimed}",
        [markdown_table(header, rows)],
    )


def _cpu(own: JudgedSet, group: str, method: MethodKey) -> str:
    cpu = own.evaluation.row(method.spec, group).cpu
    return significant(cpu.value) if cpu.n else MISSING


def planar_layouts(planar: JudgedSet) -> Section:
    """All methods on layouts that an engine of two dimensions can judge."""
    about, tests = planar.about, planar.tests[ALL]
    against = tests.against
    assert against is not None, "there are too few item lists for all pairs"
    rows = [
        (
            row.method.title,
            str(row.accuracy.n),
            percent(row.accuracy),
            *_held(planar, row.method),
            percent(row.over),
            percent(row.under),
            *(
                percent(planar.evaluation.row(row.method.spec, group).accuracy)
                for group in planar.groups[1:]
            ),
            milliseconds(row.cpu),
            _share(planar, ALL, row),
            names(f"{count} {status}" for status, count in row.without_verdict.items()),
        )
        for row in planar.evaluation.methods
    ]
    header = (
        "method", "n", "accuracy %", f"minus {against.title}", "corrected p", "overestimated %",
        "underestimated %",
        *(f"{group} %" for group in planar.groups[1:]), "CPU ms", "share", "no verdict",
    )  # fmt: skip
    each, load = planar.timing.layouts, planar.evaluation.cost_source.load
    return Section(
        "Planar layouts, and engines of two dimensions",
        f"Part `{about.part}`: {about.cases} cases, {planar.layouts} layouts of "
        f"{about.item_lists} item lists whose items all span the pallet's depth. They have other "
        "items than the cases above, so compare methods here with one another alone. Every method "
        f"is held against {against.title}, in percentage points, by the test of above, corrected "
        f"over these {len(tests.pairs)} pairs: {len(tests.sizes)} lists are too few for all. Times "
        f"are of {each} cases, in a pass of the same kind"
        + (f", with a load of {load:.1f}." if load is not None else "."),
        [markdown_table(header, rows)],
        [
            Picture(
                "planar",
                plot_fronts(planar, None),
                "Accuracy against CPU time on planar layouts, as above.",
            )
        ],
    )


def _held(planar: JudgedSet, method: MethodKey) -> tuple[str, str]:
    """A method against the one that all are held against: difference, corrected p."""
    tests = planar.tests[ALL]
    if tests.against is None or method == tests.against:
        return MISSING, MISSING
    test = tests.of(method, tests.against)
    return percent(test.difference), compact(test.corrected)
