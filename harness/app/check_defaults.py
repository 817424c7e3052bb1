"""Defaults of ``check``, ``view`` and ``score``: a method by size, and a limit of gaps."""

from __future__ import annotations

import logging
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache

GAPS_CM = 2.0
"""How far a box that has nothing under it may drop [cm] before a load is said to hover: customers'
pallets have boxes up to 1.8 cm in the air, from the tolerances of their software."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Preference:
    """A default method, and the loads that it judges.

    Attributes:
        question: that it answers, a word of :class:`steadyload.layouts.model.question.Question`.
        method: its spec.
        engine: that it needs, where it is a cascade; None: it needs none.
        most: boxes of the largest load; None: loads of any size.
        without: what is worse without this engine, in words.
    """

    question: str
    method: str
    engine: str | None = None
    most: int | None = None
    without: str = ""


_LESS = "less often right on labelled loads of 25 to 61 boxes"

PREFERENCES = (
    Preference("stands", "cascade@rapier:question=stands", "rapier", without=_LESS),
    Preference("stands", "cascade@mujoco:question=stands", "mujoco", without="less accurate"),
    Preference("stands", "settling", most=20),
    Preference("stands", "lstm_e:question=stands"),
    Preference("within", "cascade@rapier", "rapier", without=_LESS),
    Preference("within", "cascade@mujoco", "mujoco", without="less accurate"),
    Preference("within", "equilibrium:time=0.3", most=100),
    Preference("within", "lstm_e"),
)
"""Methods, the best first. On layouts of real size cascades are the most accurate of those that
take milliseconds (page ``evaluation_real``); of methods without an engine those are named that are
the most accurate on layouts of their size (``steadyload recommend``)."""


def default_method(boxes: int, question: str = "stands") -> str:
    """Spec of the method that judges a load unless another is named.

    It is the first of :data:`PREFERENCES` whose engine is installed, and for whose engine the
    package has thresholds. A log says, once a process, what is worse where a better one's engine is
    not installed.

    Args:
        boxes: of the load.
        question: ``stands`` or ``within``.

    Raises:
        ThresholdsError: the package's file of thresholds is damaged.
        QuestionError: there is no such question.
    """
    from steadyload.engines.registry import missing_packages
    from steadyload.layouts.model.question import question_named

    question = question_named(question)
    lost: dict[str, str] = {}
    for one in _of_size(boxes, question):
        missing = missing_packages(one.engine) if one.engine else ()
        if not missing:
            if lost:
                _say_once(_fallback(one.method, lost))
            return one.method
        lost |= dict.fromkeys(missing, one.without)
    raise AssertionError("some method needs no engine and judges loads of any size")


def default_methods(sizes: Iterable[int]) -> tuple[str, ...]:
    """Specs of the methods that judge loads of these numbers of boxes, each once; never none."""
    return tuple(dict.fromkeys(map(default_method, sizes))) or (default_method(1),)


def default_help() -> str:
    """Words for help texts: which methods may be the default."""
    among = ", ".join(dict.fromkeys(one.method for one in PREFERENCES if one.question == "stands"))
    return f"default: the best for the number of boxes and the engines installed, of {among}"


def _of_size(boxes: int, question: str) -> Iterable[Preference]:
    """Preferences for a load, without cascades that the package has no thresholds of."""
    for one in PREFERENCES:
        fits = one.question == question and (one.most is None or boxes <= one.most)
        if fits and (one.engine is None or (one.engine, question) in _fitted()):
            yield one


@cache
def _fitted() -> frozenset[tuple[str, str]]:
    """Engines and questions that the package has thresholds for."""
    from steadyload.methods.cascade.thresholds import fitted_for

    return fitted_for()


def _fallback(method: str, lost: dict[str, str]) -> str:
    """Sentence on packages that are not installed; ``lost``: what is worse without each."""
    packages, *_, worse = " and ".join(lost), *lost.values()
    verb = "is" if len(lost) == 1 else "are"
    return (
        f"{packages} {verb} not installed, so loads are judged by {method}: {worse}; "
        f"pip install {' '.join(lost)}"
    )


@cache
def _say_once(sentence: str) -> None:
    _log.warning("%s", sentence)
