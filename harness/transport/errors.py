"""Named errors of questions about transport."""

from __future__ import annotations

from steadyload.errors import FailedError, UserError


class TransportError(UserError):
    """A rule, a history of acceleration or a method that cannot be used; says what is allowed."""


class UnsolvedError(FailedError):
    """A programme for which the solver found no answer."""
