"""Named errors of measurements."""

from __future__ import annotations

from steadyload.errors import UserError


class MotionError(UserError):
    """Recorded motion that cannot be used; says which trial and frame, and what is allowed."""


class FieldTestError(UserError):
    """A field test that cannot be used; says which one, and what is allowed."""
