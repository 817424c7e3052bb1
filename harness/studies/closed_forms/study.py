"""Engines compared with mechanics: single bodies and small stacks whose motion is known."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, Study, option

if TYPE_CHECKING:
    from steadyload.studies.closed_forms.comparing import Found


class ClosedForms(Study["Found"]):
    """Which engines are compared with formulas."""

    question = "How far is every engine from mechanics whose answer is known?"
    about = "compare engines with formulas: tipping, sliding, spinning, stacks"

    engines: tuple[str, ...] = option(
        (), "only this; may be repeated", names=("--engine",), metavar="NAME"
    )
    rocking: bool = option(
        False, "with a block that rocks: its period, its impacts, and pulses that overturn it"
    )

    def run(self, lab: Lab) -> Found:
        """Errors of engines, test by test."""
        from steadyload.properties.closed_form_tests import closed_form_tests, rocking_tests
        from steadyload.runs.provenance import provenance_lines
        from steadyload.studies.closed_forms.comparing import compare
        from steadyload.studies.closed_forms.measuring import measured

        made_with = provenance_lines()  # of the code that measures
        left_out = () if self.rocking else rocking_tests()
        tests = [test for test in closed_form_tests() if test not in left_out]
        return compare(measured(lab, self.engines, tests=tests), made_with)
