"""How sure verdicts are on loads that deviate from their plans."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, PublishedPage, Study, option

if TYPE_CHECKING:
    from steadyload.studies.uncertain.comparing import Found


class Uncertain(Study["Found"]):
    """Verdicts on many samples of labelled cases, compared with the labels of a question."""

    answers = "How reliable is a verdict when a load deviates from its plan?"
    about = "reliability of verdicts on labelled cases: accuracy, probability, cost"
    pages = (
        PublishedPage("uncertain"),
        PublishedPage(
            "uncertain_stands", "--question stands",
            answers="How reliable is a verdict on whether a load stands until it rests, when it "
            "deviates from its plan?",
        ),
    )  # fmt: skip

    asked: str = option(
        "within", "whose labels verdicts are compared with: within or stands (default: within)",
        metavar="QUESTION", names=("--question",), choices=("within", "stands"),
    )  # fmt: skip
    limit: int | None = option(
        None, "only the first N cases a scenario (default: all)", least=10, metavar="N"
    )

    def run(self, lab: Lab) -> Found:
        """Reliability of verdicts on sampled cases, compared with the labels."""
        from steadyload.runs.provenance import provenance_lines
        from steadyload.studies.uncertain.comparing import summarise
        from steadyload.studies.uncertain.sampling import sampled_cases

        made_with = provenance_lines()  # of the code at the time of sampling
        return summarise(sampled_cases(lab, self.asked, self.limit), made_with, self.asked)
