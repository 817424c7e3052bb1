"""The reference under other numerics and other models, and compared with other methods."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, PublishedPage, Study, option

if TYPE_CHECKING:
    from steadyload.studies.convergence.comparing import Found


class Convergence(Study["Found"]):
    """Number of cases, and further methods to compare with."""

    answers = "Are the reference's labels converged?"
    about = "change the reference one parameter at a time; compare it with other methods"
    workers = 0
    verdicts = True
    pages = (
        PublishedPage("convergence", "--second-model"),
        PublishedPage(
            "convergence_stands", "--question stands",
            answers="Are the labels of whether a load stands until it rests converged?",
        ),
    )  # fmt: skip

    asked: str = option(
        "within", "whose labels: within or stands (default: within); for stands the reference "
        "alone is changed", metavar="QUESTION", names=("--question",), choices=("within", "stands"),
    )  # fmt: skip
    second_model: bool = option(False, "judge by Drake, too (needs the extra `drake`)")
    limit: int | None = option(
        None, "only the first N cases a scenario (default: 100, for stands 67)", least=1,
        metavar="N",
    )  # fmt: skip

    def run(self, lab: Lab) -> Found:
        """Labels that change, judged in runs of their own on the first of the same cases."""
        from steadyload.layouts.model.question import Question
        from steadyload.runs.definition import StudyError
        from steadyload.studies.convergence.comparing import compare
        from steadyload.studies.convergence.judging import (
            OPINIONS,
            SECOND_MODEL,
            judged,
            made_with,
        )

        question = Question(self.asked)
        if self.second_model and question == Question.STANDS:
            raise StudyError("--second-model: not allowed with --question stands; allowed: within")
        opinions = (*OPINIONS, SECOND_MODEL) if self.second_model else OPINIONS
        found = judged(lab, opinions, question, self.limit)
        folders = [lab.work / name for name in found]
        return compare(made_with(folders), *found.values(), asked=self.asked)
