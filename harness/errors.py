"""Bases of all named errors, and the nearest of some names.

Engines know nothing of this package: what a user can mend of theirs derives from
:class:`steadyload.engines.errors.EngineInputError`.
"""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterable, Mapping
from typing import Any, TypeVar

from steadyload.escaping import sentence, shown

Kind = TypeVar("Kind")

_COMPARED = 200
"""Characters of an unknown name that are compared with the known ones."""


class SentenceError(Exception):
    """An error whose message is one printable line of limited length, whatever its values are.

    It is the same error after it was pickled or copied, also where a subclass makes the message
    from other arguments: the message is not made again.
    """

    def __str__(self) -> str:
        return sentence(super().__str__())

    def __reduce__(self) -> tuple[Any, ...]:
        made = super().__reduce__()
        assert isinstance(made, tuple), "an exception is pickled by a tuple"
        kind, args, *state = made
        return _restored, (kind, args), *state


def _restored(kind: type[SentenceError], args: tuple[Any, ...]) -> SentenceError:
    """An error that has these arguments as its ``args``; its constructor is not called."""
    return kind.__new__(kind, *args)


class UserError(SentenceError, ValueError):
    """Input that a user can correct: one sentence says what is wrong and what is allowed."""


class WrongTypeError(UserError, TypeError):
    """A value of another type than is allowed; it can also be caught as a ``TypeError``."""


class FailedError(SentenceError, RuntimeError):
    """Work that failed although its input is right."""


class UnsolvedError(FailedError):
    """A programme for which the solver found no answer."""


def required(
    name: str,
    value: Any,
    kind: type[Kind],
    allowed: str,
    error: type[UserError] = WrongTypeError,
) -> Kind:
    """A value that a caller gave, if it is of the type that is allowed.

    Args:
        name: of the value, for the message.
        value: as given.
        kind: the type that is allowed.
        allowed: that type in words.
        error: what is raised.

    Raises:
        UserError: of the class ``error``: the value is of another type.
    """
    if not isinstance(value, kind):
        raise error(f"{name} is {shown(value)}; allowed: {allowed}")
    return value


def required_list(name: str, value: Iterable[Kind], allowed: str) -> list[Kind]:
    """The elements of a list that a caller gave, which is no text.

    Raises:
        WrongTypeError: it is a text, or no list.
    """
    if isinstance(value, str | bytes | Mapping):
        raise WrongTypeError(f"{name} is {shown(value)}; allowed: {allowed}")
    return list(required(name, value, Iterable, allowed))  # type: ignore[type-abstract]


def nearest(name: str, known: Collection[str]) -> str:
    """Hint for an unknown name: the nearest known one, and all of them."""
    names = sorted(str(k) for k in known)
    listing = f"allowed: {', '.join(names)}" if names else "none is allowed here"
    close = difflib.get_close_matches(name[:_COMPARED], names, n=1)
    return f"did you mean {close[0]!r}? {listing}" if close else listing
