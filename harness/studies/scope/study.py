"""Simulations of only what a step changes, compared with those of the whole pile."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, Study, methods_option, option

if TYPE_CHECKING:
    from steadyload.studies.scope.comparing import Found


class Scope(Study["Found"]):
    """Verdicts that change, and cost that is saved, when a part of a pile is simulated."""

    question = "Which bodies can a simulation leave out, and what does it save?"
    about = "simulations of only what a step changes, beside those of the whole pile"

    benchmark: str = option(
        "real", "the labelled set: its name, or its folder (default: real)", metavar="SET"
    )
    most_items: int = option(45, "boxes that a case may have (default: 45)", least=1, metavar="J")
    cases: int = option(
        300, "that are drawn of train and validation, evenly over sources (default: 300)", least=1
    )
    standing_cases: int = option(
        300, "of them that are judged for the question stands (default: 300)", least=1
    )
    seconds: float = option(
        30.0, "CPU time that a verdict may take (default: 30)", unit="s", least=0.001
    )
    methods: tuple[str, ...] = methods_option(
        "compare only this option; may be repeated (default: those of the published page)"
    )

    def run(self, lab: Lab) -> Found:
        """Cases of real size, judged with the whole pile and with parts of it left out."""
        from steadyload.studies.scope.comparing import compare_options

        return compare_options(lab, **vars(self))
