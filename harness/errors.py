"""Bases of all named errors, and the nearest of some names.

Engines know nothing of this package: what a user can mend of theirs derives from
:class:`steadyload.engines.errors.EngineInputError`.
"""

from __future__ import annotations

import difflib
from collections.abc import Collection

from steadyload.escaping import sentence

_COMPARED = 200
"""Characters of an unknown name that are compared with the known ones."""


class UserError(ValueError):
    """Input that a user can correct: one sentence says what is wrong and what is allowed.

    The sentence is one printable line of limited length, whatever its values are.
    """

    def __str__(self) -> str:
        return sentence(super().__str__())


class FailedError(RuntimeError):
    """Work that failed although its input is right: its message is one sentence, likewise."""

    def __str__(self) -> str:
        return sentence(super().__str__())


class UnsolvedError(FailedError):
    """A programme for which the solver found no answer."""


def nearest(name: str, known: Collection[str]) -> str:
    """Hint for an unknown name: the nearest known one, and all of them."""
    names = sorted(str(k) for k in known)
    listing = f"allowed: {', '.join(names)}" if names else "none is allowed here"
    close = difflib.get_close_matches(name[:_COMPARED], names, n=1)
    return f"did you mean {close[0]!r}? {listing}" if close else listing
