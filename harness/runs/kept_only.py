"""Pages made of kept results alone: whatever would judge, measure or time is refused instead."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from steadyload.errors import UserError

_REMEDY: ContextVar[str | None] = ContextVar("remedy", default=None)


class NotKeptError(UserError):
    """Something would have to be judged where kept results are wanted alone."""


@contextmanager
def kept_only(remedy: str) -> Iterator[None]:
    """Let nothing be judged, measured or timed inside.

    Args:
        remedy: end of the sentence that refuses it: what a user can do.
    """
    before = _REMEDY.set(remedy)
    try:
        yield
    finally:
        _REMEDY.reset(before)


def refuse_unless_kept(where: object, missing: int, total: int) -> None:
    """Refuse to go on with missing results inside of :func:`kept_only`; anywhere else do nothing.

    Args:
        where: the folder of the results, or what would be judged.
        missing: number of results that are not kept.
        total: number of all.

    Raises:
        NotKeptError: some are missing.
    """
    remedy = _REMEDY.get()
    if missing and remedy is not None:
        raise NotKeptError(
            f"{where}: {missing} of {total} results are not kept for these methods, this code and "
            f"these packages; {remedy}"
        )
