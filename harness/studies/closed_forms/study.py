"""Engines compared with mechanics: single bodies and small stacks whose motion is known."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, Study, option

if TYPE_CHECKING:
    from collections.abc import Iterable

    from steadyload.studies.closed_forms.comparing import Found


class ClosedForms(Study["Found"]):
    """Errors of all engines in tests whose answer is a formula."""

    answers = "How far is every engine from mechanics whose answer is known?"
    about = "compare engines with formulas: tipping, sliding, spinning, rocking, stacks"

    limit: int | None = option(
        None, "only the N lowest numbers of substeps a second (default: all)", least=1, metavar="N"
    )

    def run(self, lab: Lab) -> Found:
        """Errors of engines, test by test."""
        from steadyload.runs.provenance import provenance_lines
        from steadyload.studies.closed_forms.comparing import compare
        from steadyload.studies.closed_forms.measuring import (
            FREQUENCIES,
            measured,
            with_second_model,
        )

        made_with = provenance_lines()  # of the code that measures
        engines, left_out = with_second_model()
        return compare(measured(lab, engines, FREQUENCIES[: self.limit]), made_with, left_out)

    def remarks(self, found: Found) -> Iterable[str]:
        """Why an engine was left out."""
        return [f"left out: {why}" for why in found.left_out.values()]
