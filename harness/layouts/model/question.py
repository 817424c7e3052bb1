"""Questions that labels and methods answer about a loading."""

from __future__ import annotations

from enum import StrEnum

from steadyload.errors import UserError
from steadyload.escaping import shown


class Question(StrEnum):
    """Question about a placement.

    ``within``: has anything moved too far within the time of the label, 0.3 s? It is the question
    of the paper. ``stands``: does anything move too far until everything rests? Displacement and
    angle are measured as in the label, at every look; what still moves after 3 s is unsettled, and
    neither stands nor falls. (What is fast, and after 0.3 s where it was, only rattles.)
    """

    WITHIN = "within"
    STANDS = "stands"


class QuestionError(UserError):
    """There is no such question."""


def question_named(word: str) -> Question:
    """The question that a word, or a question itself, names.

    Raises:
        QuestionError: there is none of this name.
    """
    if word not in list(Question):
        raise QuestionError(f"question is {shown(word)}; allowed: {', '.join(Question)}")
    return Question(word)


def with_question(name: str, question: str) -> str:
    """A name or spec without parameters, and the question where it is not that of the label."""
    known = question_named(question)
    return name if known == Question.WITHIN else f"{name}:question={known}"
