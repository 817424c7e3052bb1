"""Ctrl-C: one line and status 130, whenever it comes.

A library whose import is interrupted raises what it likes, or nothing. Until a command begins its
work there is nothing to tidy up, and an interrupt ends the process at once; from then on it is the
usual KeyboardInterrupt.
"""

from __future__ import annotations

import atexit
import os
import signal
import sys
from typing import Any

INTERRUPTED = 130
SENTENCE = "steadyload: interrupted"

_status = 0


def starting() -> None:
    """From here an interrupt ends the process at once, unless interrupts are ignored."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _leave)
        # What is registered first is called last: all else is tidied up by then.
        atexit.register(_keep_status)


def working() -> None:
    """From here an interrupt is a KeyboardInterrupt: there is something to tidy up."""
    if signal.getsignal(signal.SIGINT) is _leave:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def ended(status: int) -> int:
    """Remember the status; returns it.

    Python itself ends by the signal, whatever it is told to, where the interrupt came while a
    string was executed, as in the making of a dataclass.
    """
    global _status
    _status = status
    return status


def is_behind(error: BaseException) -> bool:
    """Whether an error is what a library made of an interrupt of its import."""
    causes = []
    cause: BaseException | None = error
    while cause is not None and cause not in causes:
        causes.append(cause)
        cause = cause.__cause__ or cause.__context__
    return any(isinstance(cause, KeyboardInterrupt) for cause in causes)


def _leave(*signalled: Any) -> None:  # noqa: ARG001 - a handler is told the signal and the frame
    os.write(2, f"{SENTENCE}\n".encode())
    os._exit(INTERRUPTED)


def _keep_status() -> None:
    if _status == INTERRUPTED:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(INTERRUPTED)
