"""Engines compared with mechanics: single bodies and small stacks whose motion is known."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, PublishedPage, Study, option

if TYPE_CHECKING:
    from collections.abc import Iterable

    from steadyload.studies.closed_forms.comparing import Found


class ClosedForms(Study["Found"]):
    """Which engines are compared with formulas."""

    question = "How far is every engine from mechanics whose answer is known?"
    about = "compare engines with formulas: tipping, sliding, spinning, rocking, stacks"
    pages = (PublishedPage("closed_forms", "--second-model"),)

    engines: tuple[str, ...] = option(
        (), "only this; may be repeated", names=("--engine",), metavar="NAME"
    )
    second_model: bool = option(False, "measure Drake, too (needs the extra `drake`)")

    def run(self, lab: Lab) -> Found:
        """Errors of engines, test by test."""
        from steadyload.runs.provenance import provenance_lines
        from steadyload.studies.closed_forms.comparing import compare
        from steadyload.studies.closed_forms.measuring import measured, with_second_model

        made_with = provenance_lines()  # of the code that measures
        engines, left_out = self.engines, dict[str, str]()
        if self.second_model:
            engines, left_out = with_second_model(self.engines)
        return compare(measured(lab, engines), made_with, left_out)

    def remarks(self, found: Found) -> Iterable[str]:
        """Why an engine was left out."""
        return [f"left out: {why}" for why in found.left_out.values()]
