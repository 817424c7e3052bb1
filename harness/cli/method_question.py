"""Notes on the question that a method answers, for commands that ask whether loads stand."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.cli.terminal import say

if TYPE_CHECKING:
    from steadyload.methods.contract.method import Method


def say_question(named: str, method: Method) -> None:
    """Say that a method looks at the beginning of a placement alone, where it does.

    Args:
        named: the method as the user names it.
        method: itself.
    """
    from steadyload.layouts.model.question import Question
    from steadyload.runs.able import asked_question

    if asked_question(method) is Question.WITHIN:
        say(f"{named} looks at the first 0.3 s of a placement; question=stands at all of it")
