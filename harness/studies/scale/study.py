"""Time and memory of a study by its number of rows."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, PublishedPage, Study, option

if TYPE_CHECKING:
    from steadyload.studies.scale.measuring import Found

_FEWEST = 10_000


class Scale(Study["Found"]):
    """Time and memory of studies, by their number of rows."""

    about = "measure what studies of many rows need"
    question = "What does a study need by its number of rows: time, memory, disk?"
    workers = 2
    pages = (PublishedPage("scale", "--rows 1000000 --layouts 1000000"),)

    rows: int = option(
        100_000,
        "of the largest study; the others have a tenth, a hundredth, ... (default: 100000)",
        least=_FEWEST,
    )

    layouts: int = option(
        100_000,
        "of the largest study in blocks, likewise (default: 100000)",
        least=_FEWEST,
    )

    def run(self, lab: Lab) -> Found:
        """Needs of studies of ever more rows."""
        from steadyload.studies.scale.measuring import measured

        return measured(_rising(self.rows), _rising(self.layouts), lab)


def _rising(most: int) -> list[int]:
    """A number, a tenth of it, a hundredth, ..., from small to large."""
    largest = most - most % _FEWEST
    return [n for k in range(7, -1, -1) if (n := largest // 10**k) >= _FEWEST]
