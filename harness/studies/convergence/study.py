"""The reference under other numerics and other models, and compared with other methods."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, PublishedPage, Study, option

if TYPE_CHECKING:
    from steadyload.studies.convergence.comparing import Found


class Convergence(Study["Found"]):
    """Number of cases, and further methods to compare with."""

    question = "Are the reference's labels converged?"
    about = "change the reference one parameter at a time; compare it with other methods"
    workers = 0
    pages = (
        PublishedPage("convergence", "--second-model"),
        PublishedPage(
            "convergence_stands", "--question stands --cases 67",
            question="Are the labels of whether a load stands until it rests converged?",
        ),
    )  # fmt: skip

    cases: int = option(
        100, "cases a scenario of part test of the set of many lists (default: 100)", least=1
    )
    sample: int = option(
        17, "cases a scenario that slow methods judge; 0 for none (default: 17)", least=0
    )
    asked: str = option(
        "within", "whose labels: within or stands (default: within); for stands the reference "
        "alone is changed", metavar="QUESTION", names=("--question",), choices=("within", "stands"),
    )  # fmt: skip
    second_model: bool = option(False, "judge by Drake, too (needs the extra `drake`)")

    def run(self, lab: Lab) -> Found:
        """Labels that change, judged in runs of their own on the first of the same cases."""
        from steadyload.layouts.model.question import Question
        from steadyload.runs.definition import StudyError
        from steadyload.studies.convergence.comparing import compare
        from steadyload.studies.convergence.judging import (
            OPINIONS,
            SECOND_MODEL,
            convergence_studies,
            judged,
            made_with,
        )

        question = Question(self.asked)
        if self.second_model and question == Question.STANDS:
            raise StudyError("--second-model: not allowed with --question stands; allowed: within")
        opinions = (*OPINIONS, SECOND_MODEL) if self.second_model else OPINIONS
        asked = (self.cases, self.sample, opinions, question)
        found = judged(lab, *asked)
        return compare(
            made_with(lab.work / name for name in convergence_studies(*asked)), *found,
            asked=self.asked,
        )  # fmt: skip
