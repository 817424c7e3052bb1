"""Questions that labels and methods answer about a loading."""

from __future__ import annotations

from enum import StrEnum


class Question(StrEnum):
    """Question about a placement.

    ``within``: has anything moved too far within the time of the label, 0.3 s? It is the question
    of the paper. ``stands``: does anything move too far until everything rests? Displacement and
    angle are measured as in the label, at every look; what still moves after 3 s is unsettled, and
    neither stands nor falls. (What is fast, and after 0.3 s where it was, only rattles.)
    """

    WITHIN = "within"
    STANDS = "stands"


def with_question(name: str, question: str) -> str:
    """A name or spec without parameters, and the question where it is not that of the label."""
    return name if question == Question.WITHIN else f"{name}:question={question}"
