"""Pages made of kept results alone: whatever would judge, measure or time is refused instead."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from steadyload.errors import UserError

_REMEDY: ContextVar[str | None] = ContextVar("remedy", default=None)


_MADE = [0]

_SHOWN = 5
"""Names of what is missing in a message."""


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


def results_made() -> int:
    """How many results this process has set out to make; kept ones do not count."""
    return _MADE[0]


def refuse_unless_kept(
    where: object, missing: int, total: int, names: Callable[[], Iterable[str]] = tuple
) -> None:
    """Refuse to go on with missing results inside of :func:`kept_only`; anywhere else do nothing.

    Args:
        where: the folder of the results, or what would be judged.
        missing: number of results that are not kept.
        total: number of all.
        names: gives the names of what is missing, such as methods; each may come several times.

    Raises:
        NotKeptError: some are missing.
    """
    remedy = _REMEDY.get()
    if missing and remedy is not None:
        each = list(dict.fromkeys(names()))
        shown = ", ".join(each[:_SHOWN]) + (
            f" and {len(each) - _SHOWN} more" * (len(each) > _SHOWN)
        )
        raise NotKeptError(
            f"{where}: {missing} of {total} results are not kept for these methods, this code and "
            f"these packages{shown and f' ({shown})'}; {remedy}"
        )
    _MADE[0] += missing
