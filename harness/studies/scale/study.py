"""Time and memory of a study by its number of rows."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, Study, option

if TYPE_CHECKING:
    from steadyload.studies.scale.measuring import Found

MOST, _FEWEST = 1_000_000, 10_000
"""Rows, and layouts in blocks, of the largest study and of the smallest one at least."""


class Scale(Study["Found"]):
    """Time and memory of studies, by their number of rows."""

    about = "measure what studies of many rows need"
    answers = "What does a study need by its number of rows: time, memory, disk?"
    workers = 2

    limit: int | None = option(
        None, "rows, and layouts in blocks, of the largest study; the others have a tenth, a "
        "hundredth, ... (default: 1000000)", least=10 * _FEWEST, metavar="N",
    )  # fmt: skip

    def run(self, lab: Lab) -> Found:
        """Needs of studies of ever more rows."""
        from steadyload.studies.scale.measuring import measured

        return measured(_rising(self.limit or MOST), lab)


def _rising(most: int) -> list[int]:
    """A number, a tenth of it, a hundredth, ..., from small to large, in thousands."""
    return [n for k in range(7, -1, -1) if (n := most // 10**k // 1000 * 1000) >= _FEWEST]
