"""Named errors of what is asked about transport."""

from __future__ import annotations

from steadyload.errors import UnsolvedError as UnsolvedError
from steadyload.errors import UserError


class TransportError(UserError):
    """A rule, a history of acceleration or a method that cannot be used; says what is allowed."""
