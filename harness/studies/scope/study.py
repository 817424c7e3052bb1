"""Simulations of only what a step changes, compared with those of the whole pile."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, Study, option

if TYPE_CHECKING:
    from steadyload.studies.scope.comparing import Found


class Scope(Study["Found"]):
    """Verdicts that change, and cost that is saved, when a part of a pile is simulated."""

    answers = "Which bodies can a simulation leave out, and what does it save?"
    about = "simulations of only what a step changes, beside those of the whole pile"
    verdicts = True

    limit: int | None = option(
        None, "only N cases of each question (default: 300)", least=1, metavar="N"
    )

    def run(self, lab: Lab) -> Found:
        """Cases of real size, judged with the whole pile and with parts of it left out."""
        from steadyload.studies.scope.comparing import compare_options

        return compare_options(lab, self.limit)
