"""Tables of probabilities: how far off, by bins, and what not judging gives."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from steadyload.reports.table import (
    Column,
    Table,
    compact,
    general,
    percent,
    plain_percent,
    significant,
    words,
)
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.reliability import Abstention, Reliability

Kinds = Mapping[str, Mapping[str, Reliability]]
"""By kind of probability, and by method."""


def errors_table(kinds: Kinds) -> Table:
    """Brier score and calibration error, a row a method and kind."""
    return Table(
        _rows(kinds),
        [
            words("judge", 0),
            words("probability that", 1),
            Column("n", lambda row: row[2].brier.n),
            Column("Brier", lambda row: row[2].brier, _number),
            Column("expected calibration error", lambda row: row[2].error, _number),
        ],
    )


def bins_table(kinds: Kinds) -> Table:
    """Table of the bins: predicted probability and observed frequency."""
    return Table(
        [(judge, kind, each) for judge, kind, found in _rows(kinds) for each in found.bins],
        [
            words("judge", 0),
            words("probability that", 1),
            Column("from", lambda row: row[2].low, general),
            Column("to", lambda row: row[2].high, general),
            Column("n", lambda row: row[2].happened.n),
            Column("mean probability %", lambda row: row[2].mean, plain_percent),
            Column("happened %", lambda row: row[2].happened, percent),
        ],
    )


def abstention_table(judges: Mapping[str, Abstention], caption: str = "") -> Table:
    """Accuracy with and without the tenth that a method is least sure of."""
    columns = [
        words("judge", 0),
        Column("judges when as sure as", lambda row: row[1].least, significant),
        *_with_n("all %", lambda found: found.every),
        *_with_n("the surer nine tenths %", lambda found: found.sure),
        *_with_n("the unsure tenth %", lambda found: found.unsure),
    ]
    return Table(tuple(judges.items()), columns, caption)


def _with_n(title: str, part: Callable[[Abstention], Estimate]) -> list[Column]:
    return [
        Column("n", lambda row: part(row[1]).n),
        Column(title, lambda row: part(row[1]), percent),
    ]


def _rows(kinds: Kinds) -> list[tuple[str, str, Reliability]]:
    """Rows, method by method."""
    judges = dict.fromkeys(judge for each in kinds.values() for judge in each)
    return [(j, kind, each[j]) for j in judges for kind, each in kinds.items() if j in each]


def _number(estimate: Estimate) -> str:
    return f"{compact(estimate.value)} [{compact(estimate.low)}, {compact(estimate.high)}]"
