"""Repair of packers' plans that fail: the part that has to change, beside simpler ways."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, Study, option

if TYPE_CHECKING:
    from steadyload.studies.repair.counting import Found

FILE = "plans.csv"
"""File beside the page: a line a plan and way."""


class RepairStudy(Study["Found"]):
    """Failing plans of a set, repaired in several ways, and judged by others than the judge."""

    answers = "How much of a packer's failing plan has to change until it stands?"
    about = "repair packers' failing plans in several ways, and judge what comes of it"

    reference: bool = option(
        False,
        "have the reference judge what it has not come to: seconds a plan up to 60 boxes, minutes "
        "above",
    )
    limit: int | None = option(
        None, "repair only so many plans, the smallest (default: all)", least=1, metavar="N"
    )

    def run(self, lab: Lab) -> Found:
        """Missing plans are changed and judged, and all are counted."""
        from steadyload.layouts.benchmark import load_benchmark
        from steadyload.layouts.benchmark.parts import REAL
        from steadyload.studies.repair.counting import summarise
        from steadyload.studies.repair.plans import try_all

        benchmark = load_benchmark(REAL)
        tried = try_all(lab, benchmark, limit=self.limit, reference=self.reference)
        return summarise(benchmark, tried)

    def beside(self, found: Found, folder: Path) -> None:
        """All plans in all ways, as a CSV file."""
        from steadyload.atomic import write_atomically
        from steadyload.studies.repair.counting import as_csv

        folder.mkdir(parents=True, exist_ok=True)
        write_atomically(folder / FILE, as_csv(found.tried).encode())
