"""Sections of the page of Table 5 on every method's accuracy and cost, and on labels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from steadyload.learners.weights import load_weights
from steadyload.methods.contract.declared import Trait
from steadyload.methods.naming import MethodKey
from steadyload.methods.registry import make_method
from steadyload.reports.pages.page import Picture, Section
from steadyload.reports.table import (
    MISSING,
    Column,
    Table,
    columns_for,
    compact,
    counts,
    estimates_table,
    factor,
    names,
    percent,
    plain_percent,
    significant,
    words,
)
from steadyload.runs.costs import load_explained
from steadyload.runs.evaluation import ALL, MethodEvaluation
from steadyload.runs.paper import Paper, paper
from steadyload.studies import method_sections as column
from steadyload.studies.method_sections import by_group, cost_chart, terms_explained
from steadyload.studies.table5.figures import plot_fronts
from steadyload.studies.table5.label_ceiling import Ceiling
from steadyload.studies.table5.summary import JudgedSet, Table5

_CONVERTED = frozenset({"ps3", "ps5"})

_OWN_NETWORKS = (
    "The rows *the paper's* are networks of the shapes of its Table 4 that are told no more than "
    "its networks: sizes, positions, weights, centres of mass. They learnt from the item lists "
    "of part `train` of the labelled set, the paper's from files of the lists that it tests on. "
    "A time limit stopped the training of those of LSTM_e after {least} to {most} of {all} epochs. "
    "The rows LSTM_1 and LSTM_e without these words are networks of our own, which are told how "
    "every item is supported: their features say how far a box would tip in 0.3 s, and a rule "
    "of such features without any network is the row Equilibrium (time=0.3). So their figures are "
    "no measure of what a network learns from sequences (docs/learners.md)."
)
_READING = (
    "PS_3 and PS_5 stand in two readings. *Literal*: 4 s at 60 Hz in SI, which is what the paper "
    "prints, and what its figures look like (`ps3-literal@bullet` beside 82.33 %); these rows are "
    "compared with the paper's order. Without that word: the authors' numbers converted to SI "
    "from their scale, one centimetre as one metre (0.4 s at 600 Hz)."
)


def accuracy_and_cost(found: Table5) -> Section:
    """All methods, by group, with Fig. 3 of the paper."""
    own, yard = found.spatial, found.spatial.timing.yardstick
    share = "" if yard is None else f" *Share*: of the CPU time of {yard.title} on the same cases."
    paper = (
        "*Paper*: what the paper's Table 5 has; it does not part over- and underestimation. "
        if found.paper is not None
        else ""
    )
    return Section(
        "Accuracy and cost",
        f"All scenarios first, then each by itself. {paper}*Letters*: two methods share one just "
        "where their accuracies are not told apart among all pairs (see below). "
        f"{terms_explained(own.about)}"
        f"{column.stands_explained(own.about)} "
        f"{own.evaluation.cost_source.explained()}{share}"
        f"{what_rows_are(own) if found.paper is not None else ''}",
        by_group(own.groups, partial(_methods, found)),
        [
            Picture(
                "accuracy",
                plot_fronts(own, found.ceiling),
                "Fig. 3 of the paper: accuracy against CPU time, for all cases and by scenario; "
                "good methods stand at the upper left, and accuracies near 100 % are spread out. "
                "The dashed line is the front: above it and to its left there is none. Hollow "
                "markers have parameters of their own, bars are 95 % intervals.",
                cost_chart(own.evaluation),
            )
        ],
    )


def what_rows_are(own: JudgedSet) -> str:
    """Differences between rows and the paper's methods of the same name; empty if none."""
    methods = [row.method for row in own.evaluation.methods if paper().row_of(row.method)]
    told = []
    if any(Trait.LEARNED in make_method(method.spec).traits for method in methods):
        members = load_weights("lstm_e-paper").manifest["members"]
        epochs = [member["epochs"] for member in members]
        told.append(
            _OWN_NETWORKS.format(
                least=min(epochs), most=max(epochs), all=members[0]["options"]["epochs"]
            )
        )
    if not _CONVERTED.isdisjoint(method.family for method in methods):
        told.append(_READING)
    return "".join(f"\n\n{said}" for said in told)


def _methods(found: Table5, group: str) -> Table:
    """A row a method on a group of cases; those that judged none of them say why, below."""
    own, rows = found.spatial, found.spatial.evaluation.rows[group]
    paper = None if found.paper is None else _printed(found.paper, rows, group)
    planar = "judges planar layouts alone, see there"
    if group == ALL:
        planar += f" ({found.flat} of these cases are planar)"
    why = {method.spec: planar for method in found.planar_methods} | dict(found.left_out)
    without = [*found.planar_methods, *(MethodKey(spec, spec, "") for spec in found.left_out)]
    return Table(
        [*rows, *map(MethodEvaluation, without)],
        [
            column.METHOD,
            column.N,
            *([] if paper is None else [paper]),
            column.ACCURACY,
            column.CPU,
            column.by_spec("letters", {m.spec: s for m, s in own.tests[group].letters.items()}),
            column.OVER,
            column.UNDER,
            column.STABLE_OR_NOT,
            *column.of_stands(own.about),
            *column.robust_and_fragile(rows),
            *column.natural_prevalence(own.about),
            share_of_time(own, group),
            Column(
                "no verdict, and why",
                lambda row: why.get(row.method.spec) or counts(row.without_verdict),
                notable=any(row.without_verdict for row in rows),
            ),
        ],
    )


def _printed(paper: Paper, rows: Sequence[MethodEvaluation], group: str) -> Column:
    """The paper's accuracies of those methods that it has."""
    found = {m.method.spec: paper.like(m.method) for m in rows}
    printed = {spec: row.accuracy[group] for spec, row in found.items() if row is not None}
    return column.by_spec("paper %", printed, partial(plain_percent, digits=2))


def by_class(own: JudgedSet) -> Section:
    """Accuracy by class of items."""
    columns = columns_for(
        own.classes,
        lambda b: f"class {b.name} (n {b.cases})",
        lambda row, b: b.accuracy[row.method.spec],
        percent,
    )
    about = "; ".join(
        f"Class {b.name}: {b.cases} cases of {b.item_lists} lists, {b.items:.1f} items in the mean"
        for b in own.classes
    )
    return Section(
        "By class of items",
        f"{about}. Every accuracy over all classes is a mean weighted with these numbers: a set "
        "of another mix gives other figures for the same methods.",
        [Table(own.evaluation.methods, [column.METHOD, column.ACCURACY, *columns])],
    )


def share_of_time(
    own: JudgedSet, group: str = ALL, title: str = "share", form: Callable[[Any], str] = factor
) -> Column:
    """A column of CPU times over that of the yardstick."""
    shares, yard = own.timing.shares[group], own.timing.yardstick
    shown = {spec: form(share) for spec, share in shares.items()}
    return column.by_spec(title, shown if yard is None else {**shown, yard.spec: "1"})


def noise_of_labels(own: JudgedSet, ceiling: Ceiling) -> Section:
    """Section on the agreement of the ensemble, and on the labels on which methods err."""
    about = own.about
    tables = [_answers(own, ceiling)]
    if ceiling.engines:
        others = {row.name: row.label for row in ceiling.engines}
        caption = (
            "Other simulators, asked the label's own question (small steps, the same thresholds "
            "and time):"
        )
        tables.append(estimates_table("judge", others, "accuracy %", caption=caption))
    columns = [
        column.METHOD,
        column.N,
        *(Column(f"{kind} %", kind, percent) for kind in ("robust", "fragile")),
        Column("errors on fragile labels %", _share_of_errors),
    ]
    share = plain_percent(about.fragile / about.cases)
    caption = (
        f"Errors by label, n = {about.cases}, of which {about.fragile} ({share} %) are fragile:"
    )
    tables.append(Table(own.evaluation.methods, columns, caption))
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
        tables,
    )


def _answers(own: JudgedSet, ceiling: Ceiling) -> Table:
    """A row a set of changes: how often answers agree, in all groups."""
    kinds = {"twin": "two answers", "plurality": "best guess"}
    columns = columns_for(
        [(group, kind) for group in own.groups for kind in kinds],
        lambda key: f"{kinds[key[1]]}, {key[0]} %",
        lambda row, key: getattr(row[key[0]], key[1]),
        percent,
    )
    changes = zip(*(ceiling.by_group[group] for group in own.groups), strict=True)
    return Table(
        [dict(zip(own.groups, rows, strict=True)) for rows in changes],
        [
            words("what changes", lambda row: row[ALL].name),
            Column("further answers", lambda row: row[ALL].judges),
            Column("n", lambda row: row[ALL].label.n),
            *columns,
        ],
    )


def _share_of_errors(row: MethodEvaluation) -> str:
    """Share of a method's errors that are on fragile labels."""
    if row.fragile.n == 0 or row.accuracy.value == 1.0:
        return MISSING
    wrong = (1.0 - row.accuracy.value) * row.accuracy.n
    return f"{100 * (1.0 - row.fragile.value) * row.fragile.n / wrong:.0f} (of {wrong:.0f})"


def time_a_layout(own: JudgedSet) -> Section:
    """Section of the timing pass."""
    timing, yard = own.timing, own.timing.yardstick

    def cpu(row: MethodEvaluation, group: str) -> float | None:
        found = own.evaluation.row(row.method.spec, group).cpu
        return found.value if found.n else None

    columns = [
        column.METHOD,
        column.N_TIMED,
        column.CPU,
        column.WALL,
        share_of_time(own, title="share" if yard is None else f"of {yard.title}"),
        *columns_for(own.groups[1:], "{} CPU ms", cpu, significant),
        column.by_spec(
            "spread of repeats %",
            timing.spread if timing.repeats > 1 else {},
            partial(plain_percent, digits=0),
        ),
    ]
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
        [Table([row for row in own.evaluation.methods if row.cpu.n], columns)],
    )


def planar_layouts(planar: JudgedSet) -> Section:
    """All methods on layouts that an engine of two dimensions can judge."""
    about, tests, evaluation = planar.about, planar.tests[ALL], planar.evaluation
    held = tests.against
    assert held is not None, "there are too few item lists for all pairs"
    against = {test.first.spec: test for test in tests.tests}
    columns = [
        column.METHOD,
        column.N,
        column.ACCURACY,
        column.CPU,
        column.by_spec(
            f"minus {held.title}", {s: t.difference for s, t in against.items()}, percent
        ),
        column.by_spec("corrected p", {s: t.corrected for s, t in against.items()}, compact),
        column.OVER,
        column.UNDER,
        *columns_for(
            planar.groups[1:],
            "{} %",
            lambda row, group: evaluation.row(row.method.spec, group).accuracy,
            percent,
        ),
        share_of_time(planar),
        column.NO_VERDICT,
    ]
    load = evaluation.cost_source.load
    return Section(
        "Planar layouts, and engines of two dimensions",
        f"Part `{about.part}`: {about.cases} cases, {planar.layouts} layouts of "
        f"{about.item_lists} item lists whose items all span the pallet's depth. They have other "
        "items than the cases above, so compare methods here with one another alone. Every method "
        f"is held against {held.title}, in percentage points, by the test of above, corrected "
        f"over these {len(tests.tests)} pairs: {len(tests.sizes)} lists are too few for all. Times "
        f"are of {planar.timing.layouts} cases, in a pass of the same kind"
        + (f", with a load of {load:.1f}." if load is not None else "."),
        [Table(evaluation.methods, columns)],
        [
            Picture(
                "planar",
                plot_fronts(planar, None),
                "Accuracy against CPU time on planar layouts, as above.",
                cost_chart(planar.evaluation),
            )
        ],
    )
