"""Tables of probabilities: how far off, by bins, and what not judging gives."""

from __future__ import annotations

from collections.abc import Mapping

from steadyload.reports.table import compact, markdown_table, percent, significant
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.reliability import Abstention, Reliability

Kinds = Mapping[str, Mapping[str, Reliability]]
"""By kind of probability, and by method."""


def errors_table(kinds: Kinds) -> str:
    """Brier score and calibration error, a row a method and kind."""
    return markdown_table(
        ("judge", "probability that", "n", "Brier", "expected calibration error"),
        [
            (judge, kind, str(found.brier.n), _number(found.brier), _number(found.error))
            for judge, kind, found in _rows(kinds)
        ],
        left=2,
    )


def bins_table(kinds: Kinds) -> str:
    """Table of the bins: predicted probability and observed frequency."""
    return markdown_table(
        ("judge", "probability that", "from", "to", "n", "mean probability %", "happened %"),
        [
            (
                judge,
                kind,
                f"{each.low:g}",
                f"{each.high:g}",
                str(each.happened.n),
                f"{100 * each.mean:.1f}",
                percent(each.happened),
            )
            for judge, kind, found in _rows(kinds)
            for each in found.bins
        ],
        left=2,
    )


def abstention_table(judges: Mapping[str, Abstention]) -> str:
    """Accuracy with and without the tenth that a method is least sure of."""
    header = (
        "judge", "judges when as sure as", "n", "all %", "n", "the surer nine tenths %", "n",
        "the unsure tenth %",
    )  # fmt: skip
    return markdown_table(
        header,
        [
            (
                title,
                significant(found.least),
                *(
                    text
                    for share in (found.every, found.sure, found.unsure)
                    for text in (str(share.n), percent(share))
                ),
            )
            for title, found in judges.items()
        ],
    )


def _rows(kinds: Kinds) -> list[tuple[str, str, Reliability]]:
    """Rows, method by method."""
    judges = dict.fromkeys(judge for each in kinds.values() for judge in each)
    return [(j, kind, each[j]) for j in judges for kind, each in kinds.items() if j in each]


def _number(estimate: Estimate) -> str:
    return f"{compact(estimate.value)} [{compact(estimate.low)}, {compact(estimate.high)}]"
