"""One loading algorithm, equal values, every engine: agreement, options and speed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, Study, option

if TYPE_CHECKING:
    from steadyload.studies.engines.showing import Found


class EngineStudy(Study["Found"]):
    """All parts of the comparison; what is timed is in one process."""

    name = "engines"
    answers = "Do engines agree, what does each option change, and what does a simulation cost?"
    about = "compare engines: agreement, options, speed"
    verdicts = True

    limit: int | None = option(
        None, "only the first N layouts, and cases a scenario (default: 300, 100; 20 of real size)",
        least=2,
    )  # fmt: skip

    def run(self, lab: Lab) -> Found:
        """Parts that are missing are judged, and all are compared."""
        from steadyload.studies.engines.showing import compare

        return compare(lab, self.limit)
