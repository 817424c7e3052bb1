"""The page of learned methods: a section for each part of the record that is not empty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from steadyload.reports.page import Page, Section
from steadyload.reports.table import MISSING, duration, markdown_table, names
from steadyload.studies.learned.records import Learned, ProvenanceRow
from steadyload.studies.learned.sections import leak, remedies, size, sources
from steadyload.studies.learned.table_section import judge_table
from steadyload.studies.learned.trust_sections import calibration, foreign


def learned_page(learned: Learned, manifest: Mapping[str, str]) -> Page:
    """Compose the page."""
    sections: list[Section] = []
    if learned.table is not None:
        sections.append(judge_table(learned.table, learned.scenarios))
    if learned.size:
        sections.append(size(learned.size, learned.scenarios))
    if learned.sources:
        sections.append(sources(learned.sources, learned.agreement or {}, learned.scenarios))
    if learned.remedies:
        sections.append(remedies(learned.remedies, learned.scenarios))
    if learned.calibration:
        sections.append(calibration(learned.calibration))
    if learned.leak:
        sections.append(leak(learned.leak, learned.scenarios))
    if learned.foreign is not None:
        sections.append(foreign(learned.foreign))
    if learned.trainings:
        sections.append(_trainings(learned.trainings))
    return Page(
        "Learned judges",
        f"Learned judges are asked part `{learned.part}` of the labelled set: {learned.cases} "
        f"cases ({names(learned.scenarios)}), packed from {learned.item_lists} item lists. "
        f"{_kept_apart(learned)}"
        "*Accuracy* is the share of cases on which a judge names the label's failing step; "
        "*overestimated*: a later one, *underestimated*: an earlier one. Brackets hold 95 % "
        "intervals, which stand on item lists, since layouts packed from one list are alike. "
        "Differences are in percentage points, on the same cases.",
        sections,
        manifest,
    )


def _kept_apart(learned: Learned) -> str:
    """Sentence on whether the cases shown were used while training."""
    if learned.part == "validation":
        return (
            "**Trainings are stopped by these very cases where they leave out no item lists, so "
            "that accuracies are too high.** "
        )
    leaky = " but the leaky way" if learned.leak else ""
    return f"Nothing of these item lists was learnt from{leaky}, nor looked at in a training. "


def _trainings(rows: Sequence[ProvenanceRow]) -> Section:
    table = markdown_table(
        (
            "training", "seeds", "commit", "weights", "cases", "item lists", "epochs",
            "best epoch", "validation %", "time",
        ),
        [
            (
                row.title,
                names(map(str, row.seeds)),
                row.commit,
                row.digest,
                str(row.cases),
                MISSING if row.item_lists is None else str(row.item_lists),
                names(map(str, row.epochs)),
                names(map(str, row.best_epochs)),
                f"{100 * row.validation:.1f}",
                duration(row.seconds),
            )
            for row in rows
        ],
        left=4,
    )  # fmt: skip
    first = {row.title: row for row in reversed(rows)}
    commands = "\n".join(f"- {title}: `{row.command}`" for title, row in reversed(first.items()))
    return Section(
        "Where the weights come from",
        "*Validation*: accuracy on the validation part, of the mean of the members. *Time*: wall "
        "time of all epochs. These commands make the weights again; of several seeds it is the "
        "first one's, and the others differ in `--option seed`:\n\n" + commands,
        [table],
    )
