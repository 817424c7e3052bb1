"""The page of the paper's experiment: its figures beside ours, on three splits."""

from __future__ import annotations

from steadyload.labelling.paper_labels import Labelling
from steadyload.reports.pages.page import Page, Picture, Section
from steadyload.reports.table import Column, Table, names, percent, plain_percent, words
from steadyload.runs.evaluation import ALL
from steadyload.statistics.estimate import Estimate
from steadyload.studies.replication.figures import plot_steps
from steadyload.studies.replication.methods import OURS, PRINTED, PS_OPT, READINGS, STATIC
from steadyload.studies.replication.sections import (
    KINDS,
    costs_section,
    counts_section,
    depends_section,
    method_table,
    splits_section,
    trainings_section,
)
from steadyload.studies.replication.splits import SplitKind
from steadyload.studies.replication.study import LSTM_1, LSTM_E, MEMORISER
from steadyload.studies.replication.summary import (
    GROUPS,
    Change,
    LearnedRow,
    ReplicationSummary,
    paper_of,
)

_TITLE = "The paper's experiment, as it was run"


def replication_page(found: ReplicationSummary | Labelling) -> Page:
    """Compose the page; of labels alone one that says how many there are."""
    if isinstance(found, Labelling):
        return _labels_page(found)
    return Page(
        _TITLE,
        _summary(found),
        [
            _learned(found),
            _readings(found),
            _steps(found),
            _others(found),
            splits_section(found),
            counts_section(found),
            trainings_section(found),
            costs_section(found),
            depends_section(found),
        ],
        found.made_with,
    )


def _labels_page(found: Labelling) -> Page:
    lost = names(f"{count} {status}" for status, count in found.without.items())
    return Page(
        _TITLE,
        f"{len(found.labels)} labels are known; the files have {found.cases} distinct cases.",
        [Section("Cases without a label", f"{lost or 'None'}.")],
        {},
    )


def _summary(found: ReplicationSummary) -> str:
    parts = [_twins(found), _falls(found), _reading(found), _simulated(found)]
    quick = (
        f" Quick run: every third file, and networks of {found.epochs} epochs, which are "
        "under-trained."
        if found.quick
        else ""
    )
    first, *others = parts
    listed = "\n".join(f"- {part}" for part in others)
    return (
        f"{first}{quick}\n\n{listed}\n\nAll intervals are at 95 % and count item lists, of which "
        f"there are {found.lists}: they are rough."
    )


def _twins(found: ReplicationSummary) -> str:
    name = LSTM_E if found.learnt(LSTM_E, SplitKind.FILE) else LSTM_1
    kinds = (SplitKind.FILE, SplitKind.LIST)
    learnt = [_in_s1(found, name, kind) for kind in kinds]
    recalled = [_in_s1(found, MEMORISER, kind) for kind in kinds]
    trained = f", under-trained with {found.epochs} epochs instead of 700," if found.quick else ""
    return (
        "A memoriser, which only repeats the label of the training file that begins most alike, is "
        f"right on {recalled[0]} of S1's test files when files are split one by one, as the "
        f"paper's seem to be, and on {recalled[1]} when whole item lists are held out. The paper's "
        f"{name} is right on {plain_percent(paper_of(name)['S1'])} %; trained here{trained} {name} "
        f"is right on {learnt[0]} split by file and on {learnt[1]} split by item list."
    )


def _in_s1(found: ReplicationSummary, name: str, kind: SplitKind) -> str:
    row = found.learnt(name, kind)
    assert row is not None, "both are trained on every split"
    return _phrase(row.accuracy["S1"])


def _phrase(estimate: Estimate) -> str:
    return (
        f"{plain_percent(estimate.value)} % ({plain_percent(estimate.low)} to "
        f"{plain_percent(estimate.high)}, n = {estimate.n})"
    )


def _falls(found: ReplicationSummary) -> str:
    fell = {answer.about: answer for answer in found.answers if "fall" in answer.about}
    of = {
        (name, word): fell[f"{name}, fall from S1 to S2, split by {word}"]
        for name in (LSTM_1, MEMORISER)
        for word in ("file", "item list")
    }
    printed = of[LSTM_1, "file"].paper
    file, apart = (_points(of[LSTM_1, word].found) for word in ("file", "item list"))
    recalled = _points(of[MEMORISER, "file"].found)
    return (
        f"From S1 to S2a and S2b LSTM_1 falls by {file} points split by file (the paper: "
        f"{plain_percent(printed)}), the memoriser by {recalled}, and LSTM_1 by {apart} split by "
        "item list."
    )


def _points(estimate: Estimate) -> str:
    return (
        f"{plain_percent(estimate.value)} ({plain_percent(estimate.low)} to "
        f"{plain_percent(estimate.high)})"
    )


def _reading(found: ReplicationSummary) -> str:
    rows = [found.method(line.spec) for line in READINGS]
    shown = [row for row in rows if row is not None]
    if len(shown) < len(READINGS):
        return "Not all readings of PS_3 and PS_5 were judged."
    phrases = []
    for literal, converted in (shown[:2], shown[2:]):
        near = min(
            (literal, converted), key=lambda row: abs(row.accuracy[ALL].value - row.paper[ALL])
        )
        phrases.append(
            f"{literal.line.paper} has {plain_percent(literal.accuracy[ALL].value)} % read "
            f"literally and {plain_percent(converted.accuracy[ALL].value)} % converted, against "
            f"the paper's {plain_percent(literal.paper[ALL])}: nearer is "
            f"{'the literal reading' if near is literal else 'the converted one'}"
        )
    return f"{phrases[0]}; {phrases[1]}."


def _simulated(found: ReplicationSummary) -> str:
    steps = {step.title: step.accuracy for step in found.simulations}
    wanted = [line.title for line in PS_OPT]
    if not set(wanted) <= set(steps):
        return "Not all steps from PS_opt to ours were judged."
    printed, ran = steps[wanted[0]], steps[wanted[5]]
    label, last = steps[wanted[6]], steps[wanted[-1]]
    return (
        f"PS_opt has {_phrase(printed)} as printed and {_phrase(ran)} as their program ran it, "
        f"against the paper's {plain_percent(paper_of('PS_opt')[ALL])} %; with the parameters of "
        f"the label, on the same engine, {_phrase(label)}, and ours on MuJoCo {_phrase(last)}."
    )


def _learned(found: ReplicationSummary) -> Section:
    columns = [
        words("method", "name"),
        words("split by", lambda row: KINDS[row.kind]),
        *(
            Column(
                f"{'all' if group == ALL else group} %",
                lambda row, group=group: row.accuracy[group],  # type: ignore[misc]
                percent,
            )
            for group in GROUPS
        ),
    ]
    printed = Table(
        [name for name in (LSTM_1, LSTM_E) if any(row.name == name for row in found.learned)],
        [
            words("the paper", lambda name: name),
            *(
                Column(
                    f"{'all' if group == ALL else group} %",
                    lambda name, group=group: plain_percent(paper_of(name)[group]),  # type: ignore[misc]
                )
                for group in GROUPS
            ),
        ],
    )
    return Section(
        "What learns, by what it may learn from",
        "The same test files under every split; what differs is the training. *File*: twins of a "
        "test file stay in the training. *Fewer*: likewise, with as many training files as in the "
        "next. *Geometry*: nothing with the geometry of a held-out file. *Item list*: nothing of "
        f"its item list. n = {_each(found)} in every scenario.{_note(found)}",
        [printed, Table(_sorted(found.learned), columns), _differences(found)],
    )


def _each(found: ReplicationSummary) -> str:
    """The number of test files of a scenario, or the least and the greatest."""
    counts = sorted({row.test for row in found.counts})
    return " to ".join(map(str, dict.fromkeys((counts[0], counts[-1]))))


def _note(found: ReplicationSummary) -> str:
    return (
        f" Networks are **under-trained**: {found.epochs} epochs instead of 700."
        if found.quick
        else ""
    )


def _sorted(rows: tuple[LearnedRow, ...]) -> list[LearnedRow]:
    order = list(dict.fromkeys(row.name for row in rows))
    return sorted(rows, key=lambda row: (order.index(row.name), list(SplitKind).index(row.kind)))


def _differences(found: ReplicationSummary) -> Table:
    return Table(
        found.answers,
        [
            words("difference, in points", "about"),
            Column("n", "found.n"),
            Column("here", "found", percent),
            Column("the paper", "paper", plain_percent),
        ],
        "Differences between these, on the same files; a fall is not paired:",
    )


def _readings(found: ReplicationSummary) -> Section:
    rows = [row for line in (*READINGS, *PS_OPT[:6]) if (row := found.method(line.spec))]
    return Section(
        "Which reading the paper used",
        "*Literal*: the authors' numbers as metres and seconds, 4 s at 60 Hz; *converted*: one "
        "centimetre simulated as one metre, so 0.4 s at 600 Hz. The lines from PS_opt as printed "
        "down each change one thing more, to what the authors' program does: items put back "
        "before every placement, one look at its end, the product of both frictions and of both "
        "restitutions, 10 iterations. Their program measures displacement at the centre of mass "
        "and keeps angular velocities when it puts items back; neither can be asked for here.",
        [method_table(rows)],
    )


def _steps(found: ReplicationSummary) -> Section:
    panels = [
        ("LSTM_1: from the paper's set-up to ours", found.networks, paper_of(LSTM_1)[ALL]),
        ("PS_opt: from the paper's set-up to ours", found.simulations, paper_of("PS_opt")[ALL]),
    ]
    shown = [(title, steps, value) for title, steps, value in panels if steps]
    return Section(
        "From the paper's set-up to ours, one factor at a time",
        f"Each line changes one thing more than the one before it.{_note(found)}",
        [_changes(title, steps) for title, steps, _ in shown],
        [
            Picture(
                "steps",
                plot_steps(shown),
                "Accuracy over all three scenarios after every step. A bar reaches from the "
                "accuracy before a step to that after it; whiskers are 95 % intervals.",
            )
        ],
    )


def _changes(title: str, steps: tuple[Change, ...]) -> Table:
    return Table(
        steps,
        [
            words(title, "title"),
            Column("n", "accuracy.n"),
            Column("accuracy %", "accuracy", percent),
            Column("change, points", "change", percent),
        ],
    )


def _others(found: ReplicationSummary) -> Section:
    usual = {line.spec for line in (*READINGS, *PS_OPT[:6])}
    rows = [row for row in found.methods if row.line.spec not in usual]
    own = {line.spec for line in (*STATIC, *OURS)}
    more = "" if any(row.line.spec in own for row in rows) else " None was judged."
    return Section(
        "Rules, and ours",
        "None of them learnt from these item lists, so that a split changes nothing for them. "
        f"`{PRINTED}` and its variants stand above.{more}",
        [method_table(rows)] if rows else [],
    )
