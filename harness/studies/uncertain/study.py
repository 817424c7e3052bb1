"""How sure verdicts are on loads that deviate from their plans."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, PublishedPage, Study, methods_option, option

if TYPE_CHECKING:
    from steadyload.studies.uncertain.comparing import Found


class Uncertain(Study["Found"]):
    """Deviations, methods and numbers of cases."""

    question = "How reliable is a verdict when a load deviates from its plan?"
    about = "reliability of verdicts on labelled cases: accuracy, probability, cost"
    pages = (
        PublishedPage("uncertain"),
        PublishedPage(
            "uncertain_stands", "--question stands",
            question="How reliable is a verdict on whether a load stands until it rests, when it "
            "deviates from its plan?",
        ),
    )  # fmt: skip

    uncertain: str = option(
        "com=5mm,position=3mm", "what deviates (default: com=5mm,position=3mm)", metavar="WHAT"
    )
    methods: tuple[str, ...] = methods_option(
        "may be repeated (default: a rule, the equilibrium, a network, an engine)"
    )
    asked: str = option(
        "within", "whose labels verdicts are compared with: within or stands (default: within)",
        metavar="QUESTION", names=("--question",), choices=("within", "stands"),
    )  # fmt: skip
    cases: int = option(100, "a scenario, for methods without an engine (default: 100)", least=1)
    engine_cases: int = option(20, "a scenario, for methods with one (default: 20)", least=1)
    checked: int = option(
        50, "layouts that are compared with many random samples (default: 50)", least=0
    )

    def run(self, lab: Lab) -> Found:
        """Reliability of verdicts on sampled cases, compared with the labels."""
        from steadyload.runs.provenance import provenance_lines
        from steadyload.studies.uncertain.comparing import summarise
        from steadyload.studies.uncertain.sampling import sampled_cases

        made_with = provenance_lines()  # of the code at the time of sampling
        return summarise(self.uncertain, sampled_cases(lab, **vars(self)), made_with, self.asked)
