"""Ctrl-C: one line and status 130, whenever it comes.

A library whose import is interrupted raises any exception, or none. Until a command begins its work
there is nothing to clean up, and an interrupt ends the process at once; from then on the first one
is a KeyboardInterrupt, and any further one, or one after the work, ends the process at once.

Nothing is imported here that takes time: until :func:`starting` an interrupt ends with Python's
traceback, and the interpreter's own start can by no means be covered.
"""

from __future__ import annotations

import atexit
import os
import signal
import sys

TYPE_CHECKING = False  # that of typing, which takes longer to import than all the rest
if TYPE_CHECKING:
    from typing import Any

INTERRUPTED = 130
SENTENCE = "steadyload: interrupted"

_status = 0
_told = False


def starting() -> None:
    """Let an interrupt end the process at once, unless interrupts are ignored."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _leave)
        # The first registered function is called last, after all other clean-up.
        atexit.register(_keep_status)
        sys.unraisablehook = _unraisable


def working() -> None:
    """Let the next interrupt raise KeyboardInterrupt, so that a command can clean up."""
    if signal.getsignal(signal.SIGINT) is _leave:
        signal.signal(signal.SIGINT, _raise)


def ended(status: int) -> int:
    """Remember the status, and let an interrupt end the process at once; returns the status.

    Python itself ends by the signal, whatever the status, where the interrupt came while a string
    was executed, as in the making of a dataclass.
    """
    global _status
    if signal.getsignal(signal.SIGINT) is _raise:
        signal.signal(signal.SIGINT, _leave)
    _status = status
    return status


def tell(error: BaseException) -> None:
    """Print the line of an interrupt, with the notes of the error that followed from it."""
    global _told
    print("; ".join([SENTENCE, *getattr(error, "__notes__", [])]), file=sys.stderr, flush=True)
    _told = True


def is_behind(error: BaseException) -> bool:
    """True if an error is an interrupt or follows from one, as in the import of a library."""
    causes = []
    cause: BaseException | None = error
    while cause is not None and cause not in causes:
        causes.append(cause)
        cause = cause.__cause__ or cause.__context__
    return any(isinstance(cause, KeyboardInterrupt) for cause in causes)


def _raise(*signalled: Any) -> None:
    signal.signal(signal.SIGINT, _leave)
    signal.default_int_handler(*signalled)


def _leave(*signalled: Any) -> None:  # noqa: ARG001 - a handler is given the signal and the frame
    if not _told:
        os.write(2, f"{SENTENCE}\n".encode())
    os._exit(INTERRUPTED)


def _unraisable(found: Any) -> None:
    """Hook for exceptions that Python cannot raise, as in a destructor: it goes on after them.

    An interrupt that came there comes again a moment later, so that the command still cleans up.
    """
    if not issubclass(found.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(found)
    elif hasattr(signal, "setitimer"):
        signal.signal(signal.SIGINT, _raise)
        signal.signal(signal.SIGALRM, lambda *_: signal.raise_signal(signal.SIGINT))
        signal.setitimer(signal.ITIMER_REAL, 0.01)
    else:
        _leave()


def _keep_status() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # all is done, and Python takes handlers away
    if _status == INTERRUPTED:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(INTERRUPTED)
