"""The methods and engines of a study: those that can judge here, and what each is asked."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cache

from steadyload.engines.errors import EngineNotInstalledError
from steadyload.engines.registry import capabilities, engines_here
from steadyload.errors import nearest
from steadyload.layouts.model.question import Question
from steadyload.methods.contract.method import Method
from steadyload.methods.contract.spec import parse_spec
from steadyload.methods.registry import each_question, make_method, method_of, presets
from steadyload.runs.definition import StudyError

_DECIDING = frozenset(("question", "weights", "thresholds"))
"""Parameters that decide which question a method answers."""


def able_methods(
    named: tuple[str, ...], usual: Callable[[], Iterable[str]]
) -> tuple[tuple[str, ...], dict[str, str]]:
    """Canonical specs of methods that can judge; reasons why others of the usual ones cannot.

    Args:
        named: required specs; empty for the usual ones.
        usual: gives those of which some may be missing.

    Raises:
        SpecError, EngineNotInstalledError: a named method cannot judge.
        LearnerError: its weights cannot be read.
    """
    able: dict[str, None] = {}
    left_out = {}
    for text in named or usual():
        try:
            method = make_method(text)
            method.made_of()
            method.prepare()
        except (ValueError, EngineNotInstalledError) as error:  # also what is wrong with weights
            if named:
                raise
            left_out[text] = str(error)
            continue
        able[str(method.spec)] = None
    return tuple(able), left_out


def asked_question(method: str | Method) -> Question | None:
    """The question that a method is asked; None where it has no such parameter.

    Args:
        method: itself, or its spec.

    Raises:
        SpecError: no such method.
    """
    asked = method_of(method)
    question: Question | None = getattr(asked.parameters, "question", None)
    return question


def asked_to_stand(method: str | Method) -> Method:
    """The method that answers whether a load stands, for commands that ask this of every load.

    Args:
        method: itself, or its spec, which gets the question ``stands`` where the method knows it
            and the spec states no question, nor files, which were made for one.

    Raises:
        SpecError: no such method.
    """
    if not isinstance(method, str):
        return method_of(method)
    spec = parse_spec(method)
    if not _DECIDING.intersection(dict(spec.values)) and Question.STANDS in each_question(
        spec.name
    ):
        spec = spec.stating("question", Question.STANDS)
    return make_method(str(spec))


@cache
def spec_with_question(method: str) -> str:
    """The spec of a method as people read it: with its question, where it has one.

    Args:
        method: its canonical spec, which leaves out the question of the paper.
    """
    name = parse_spec(method).name
    if name not in presets() and not each_question(name):
        return method  # without a parameter for it, whatever is stated
    question = asked_question(method)
    return method if question is None else str(parse_spec(method).stating("question", question))


def chosen(names: Sequence[str], known: Iterable[str], what: str) -> tuple[str, ...]:
    """Those of the known names that are asked for, in the order of the known ones.

    Raises:
        StudyError: one is none of these; it says ``what`` they are.
    """
    every = tuple(known)
    for name in names:
        if name not in every:
            raise StudyError(f"unknown {what} {name!r}; {nearest(name, every)}")
    return tuple(name for name in every if name in names)


def fixed_step_engines(only: Sequence[str] = ()) -> tuple[str, ...]:
    """Names of the engines of three dimensions that are here and take fixed steps.

    Optional ones are among them where they are installed.

    Args:
        only: those that are wanted; empty for all.

    Raises:
        StudyError: a wanted one is none of these.
    """
    found = tuple(name for name in spatial_engines() if not capabilities(name).error_controlled)
    for name in only:
        if name not in found:
            raise StudyError(f"engine {name!r}: {nearest(name, found)}")
    return tuple(name for name in found if not only or name in only)


def spatial_engines() -> tuple[str, ...]:
    """Names of the engines of three dimensions that are here."""
    return tuple(name for name in engines_here() if capabilities(name).dimensions == 3)
