"""Progress of long work: what a caller gives to be told of it."""

from __future__ import annotations

from typing import Protocol


class Progress(Protocol):
    """Callback for the amount of work that is done.

    It is called in the process of the caller: first with what was kept by an interrupted run, where
    anything is kept, then as parts are finished, in any number at once, the last time with all
    done. ``done`` is 0 to ``total`` and never falls. What is counted (layouts, rows, epochs)
    stands at the function that is given the callback. An error that it raises, and Ctrl-C, end the
    work.
    """

    def __call__(self, done: int, total: int, /) -> None:
        """Take note of the amount done and the amount of all."""


class NamedProgress(Protocol):
    """:class:`Progress` of work in several stages: the name of a stage comes first.

    A stage whose amount is not known, or that is one piece, is named alone.
    """

    def __call__(self, what: str, done: int = 0, total: int = 0, /) -> None:
        """Take note of the stage at work, the amount done of it and the amount of all of it."""


def silent(*of: object) -> None:
    """Progress of either kind that is not shown."""
