"""Exceptions of engines."""

from __future__ import annotations


class EngineError(Exception):
    """An engine cannot do what was requested of it."""


class EngineNotInstalledError(EngineError):
    """The library behind an engine is missing; the message says how to install it."""


class WorldClosedError(EngineError):
    """A world was used after :meth:`steadyload.engines.world.World.close`."""


class BadNumberError(EngineError, ValueError):
    """A number outside its limits: says which, of which box, and what is allowed.

    What engines themselves do with such numbers ranges from silence to ending the process.
    """
