"""Methods compared on the cases of a run that was judged: the page of a study file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from steadyload.config import REQUIRED
from steadyload.studies.kit import Lab, Study, operand

if TYPE_CHECKING:
    from steadyload.studies.report.comparing import Found


class RunReport(Study["Found"]):
    """Which run is compared; the run itself is ``steadyload study run``."""

    answers = "How do methods compare on many layouts: accuracy, cost, and where they disagree?"
    about = "write report.md of a study's folder"
    workers = None
    pages = ()

    directory: Path = operand(REQUIRED, "folder of a study's run", metavar="DIR")

    def run(self, lab: Lab) -> Found:
        """Compared from the rows of the run; nothing is judged."""
        from steadyload.studies.report.comparing import compare

        return compare(self.directory)
