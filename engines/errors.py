"""Exceptions of engines."""

from __future__ import annotations


class EngineError(Exception):
    """An engine cannot do what was requested of it."""


class EngineInputError(EngineError):
    """Input that a user can correct: one sentence says what is wrong and what is allowed."""


class EngineNotInstalledError(EngineInputError):
    """The library behind an engine is missing; the message says how to install it."""


class WorldClosedError(EngineError):
    """A world was used after :meth:`steadyload.engines.world.World.close`."""


class BadNumberError(EngineInputError, ValueError):
    """A number outside its limits: says which, of which box, and what is allowed.

    What engines themselves do with such numbers ranges from silence to ending the process.
    """
