"""The page of learned methods: a section for each part of the record that is not empty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from steadyload.reports.pages.page import Page, Section
from steadyload.reports.table import (
    Column,
    Table,
    duration,
    milliseconds,
    names,
    percent,
    plain_percent,
    words,
)
from steadyload.runs.evaluation import ALL, MethodEvaluation
from steadyload.studies.learned.sections import leak, remedies, size, sources
from steadyload.studies.learned.summary import Learned, ProvenanceRow
from steadyload.studies.learned.table_section import judge_table
from steadyload.studies.learned.trust_sections import calibration, foreign

_RULE = "equilibrium:time=0.3"
"""A rule of the quantities that features of support hold, for comparison with what is learnt."""


def _numbers(values: Sequence[int]) -> str:
    return names(map(str, values))


def learned_page(learned: Learned, manifest: Mapping[str, str]) -> Page:
    """Compose the page."""
    sections = [
        judge_table(learned.table) if learned.table is not None else None,
        size(learned.size) if learned.size else None,
        sources(learned.sources, learned.agreement or {}) if learned.sources else None,
        remedies(learned.remedies) if learned.remedies else None,
        calibration(learned.calibration) if learned.calibration else None,
        leak(learned.leak) if learned.leak else None,
        foreign(learned.foreign) if learned.foreign is not None else None,
        _trainings(learned.trainings) if learned.trainings else None,
    ]
    return Page(
        "Learned judges",
        f"{_answer(learned)}Learned judges judge part `{learned.part}` of the labelled set: "
        f"{learned.cases} cases ({names(learned.scenarios)}), packed from "
        f"{learned.item_lists} item lists. {_kept_apart(learned)}"
        "*Accuracy* is the share of cases on which a judge names the label's failing step; "
        "*overestimated*: a later one, *underestimated*: an earlier one. Brackets hold 95 % "
        "intervals, which stand on item lists, since layouts packed from one list are alike. "
        "Differences are in percentage points, on the same cases.",
        [section for section in sections if section is not None],
        manifest,
    )


def _answer(learned: Learned) -> str:
    """Sentence on the judge that all are compared with, and on the best of the others."""
    if learned.table is None:
        return ""
    rows = learned.table.rows[ALL]
    held = next((row for row in rows if row.method == learned.table.held), None)
    others = [row for row in rows if row is not held]
    if held is None or not others:
        return ""
    best = max(others, key=lambda row: row.accuracy.value)
    ruled = next((row for row in others if row.method.spec == _RULE), None)
    of_rule = (
        f" Its features say how every item is supported, and how far a box would tip in 0.3 s; the "
        f"rule {_found(ruled)} without any learning, so that little of this figure is due to the "
        "network."
        if ruled is not None and ruled.accuracy.value >= held.accuracy.low
        else ""
    )
    return (
        f"{_found(held)} on item lists that it has not seen. The most accurate of the other "
        f"methods here is {_found(best, verb='with')}.{of_rule}\n\n"
    )


def _found(row: MethodEvaluation, verb: str = "is right on") -> str:
    cost = f" in {milliseconds(row.cpu)} ms of CPU time a layout" if row.cpu.n else ""
    return f"{row.method.title} {verb} {percent(row.accuracy)} % of {row.accuracy.n} cases{cost}"


def _kept_apart(learned: Learned) -> str:
    """Sentence on whether the cases shown were used while training."""
    if learned.part == "validation":
        return (
            "**Trainings are stopped by these very cases where they leave out no item lists, so "
            "that accuracies are too high.** "
        )
    leaky = " but the leaky way" if learned.leak else ""
    return f"Nothing of these item lists was learnt from{leaky}, nor looked at in a training. "


_TRAININGS = (
    words("training", "title"),
    words("seeds", "seeds", _numbers),
    words("commit"),
    words("weights", "digest"),
    Column("cases"),
    Column("item lists", "item_lists"),
    Column("epochs", "epochs", _numbers),
    Column("best epoch", "best_epochs", _numbers),
    Column("validation %", "validation", plain_percent),
    Column("time", "seconds", duration),
)


def _trainings(rows: Sequence[ProvenanceRow]) -> Section:
    first = {row.title: row for row in reversed(rows)}
    commands = "\n".join(f"- {title}: `{row.command}`" for title, row in reversed(first.items()))
    return Section(
        "Where the weights come from",
        "*Validation*: accuracy on the validation parts of all sets learnt from, of the mean of "
        "the members. *Time*: wall time of all epochs. These commands make the weights again; of "
        "several seeds it is the first one's, and the others differ in `--option seed`:\n\n"
        + commands,
        [Table(rows, _TRAININGS)],
    )
