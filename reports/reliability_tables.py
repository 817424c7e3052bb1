"""Tables of probabilities: how far off, by bins, and what not judging gives."""

from __future__ import annotations

from collections.abc import Mapping
from operator import attrgetter

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
    ]
    parts = {"every": "all %", "sure": "the surer nine tenths %", "unsure": "the unsure tenth %"}
    for part, title in parts.items():
        found = attrgetter(part)
        columns += [
            Column("n", lambda row, found=found: found(row[1]).n),
            Column(title, lambda row, found=found: found(row[1]), percent),
        ]
    return Table(tuple(judges.items()), columns, caption)


def _rows(kinds: Kinds) -> list[tuple[str, str, Reliability]]:
    """Rows, method by method."""
    judges = dict.fromkeys(judge for each in kinds.values() for judge in each)
    return [(j, kind, each[j]) for j in judges for kind, each in kinds.items() if j in each]


def _number(estimate: Estimate) -> str:
    return f"{compact(estimate.value)} [{compact(estimate.low)}, {compact(estimate.high)}]"
