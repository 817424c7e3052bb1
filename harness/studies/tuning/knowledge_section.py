"""The part of the page of tuning on what a protocol brings, and what a search brings."""

from __future__ import annotations

from collections.abc import Sequence

from steadyload.reports.pages.page import Section
from steadyload.reports.table import Column, Table, milliseconds, names, percent, words
from steadyload.studies.tuning.summary import KnowledgeTable

_COLUMNS = (
    words("parameters", "title"),
    Column("n", "found.accuracy.n"),
    Column("accuracy %", "found.accuracy", percent),
    Column("more than the row above, points", "gain", percent),
    Column("CPU ms", "found.cpu", milliseconds),
)


def knowledge(tables: Sequence[KnowledgeTable]) -> Section:
    """Section of the gain from protocol to protocol, and of the searches within them."""
    return Section(
        "What the protocol brings, and what the search brings",
        "Between the paper's values and tuned ones lie two changes of a different kind. One is "
        "knowledge: to load as the labels were made (every item is put back to its place before "
        "the next step, corners are followed, and the label's thresholds and time hold). The "
        "other is search, as far as the number of parameter sets that were searched allows: the "
        "paper's genetic search has 1000 sets a generation, for 50 generations, so what fewer find "
        "is no bound on what its protocol can bring. Differences are paired, case by case.\n\n"
        + "\n".join(_sentence(table) for table in tables),
        [
            Table(table.steps, list(_COLUMNS), f"**{table.engine}**, part {table.part}")
            for table in tables
        ],
    )


def _sentence(table: KnowledgeTable) -> str:
    first, *others = table.steps
    gains = [f"{percent(step.gain)} points ({step.title})" for step in others]
    return (
        f"- {table.engine}: {percent(first.found.accuracy)} % ({first.title}); each on top of the "
        f"one before, {names(gains)}."
    )
