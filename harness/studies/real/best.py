"""Which methods do not differ significantly from the most accurate one."""

from __future__ import annotations

from dataclasses import dataclass

from steadyload.layouts.model.question import Question
from steadyload.methods.naming import MethodKey
from steadyload.runs.able import asked_question
from steadyload.runs.comparison import compared
from steadyload.runs.judged import JudgedCases


@dataclass(frozen=True, slots=True)
class BestMethod:
    """The most accurate method by the labels of one question, and those that may be as accurate.

    Attributes:
        method: of those that are asked the question, or have no such parameter, the most accurate.
        others: number of the others, each compared with it by a paired sign-flip test over item
            lists; refused cases count as wrong.
        alike: those of them whose p-value, corrected by Holm for their number, is at least
            :data:`steadyload.statistics.paired.LEVEL`.
    """

    method: MethodKey
    others: int
    alike: tuple[MethodKey, ...]


def best_method(judged: JudgedCases, question: Question) -> BestMethod | None:
    """The most accurate method of a run; None where no case has a label of the question."""
    part = judged.asked(question)
    specs = [spec for spec in part.keys if asked_question(spec) in (None, question)]
    if not len(part.said) or not specs:
        return None
    found = compared(part.of(specs))
    others = found.versus(found.best).tests
    alike = tuple(test.first for test in others if not test.significant)
    return BestMethod(found.best, len(others), alike)
