"""The command ``steadyload``: parse, call one documented function, print.

Nothing is imported here but the code that reports an interrupt in one line.
"""

from __future__ import annotations

import os
import sys

from steadyload.cli.interrupts import INTERRUPTED, ended, is_behind, starting, tell

TYPE_CHECKING = False  # that of typing, see the interrupts
if TYPE_CHECKING:
    from collections.abc import Sequence


def command() -> int:
    """Run the command with the arguments of the process; returns its exit status."""
    open_streams()
    starting()
    # Nothing is rendered: with its renderer MuJoCo loads glfw, which asks a process of its own for
    # a version, and that one complains when this one is killed.
    os.environ.setdefault("MUJOCO_GL", "disable")
    return ended(main())


def open_streams() -> None:
    """Open the standard streams that the process was begun without, as by ``>&-``, on nothing.

    Else Python has None for them, and files of the command and of its workers get their numbers, so
    that what a library prints would be written into a file.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            stream = open(os.devnull, mode, encoding="utf-8")  # noqa: PTH123, SIM115
            os.set_inheritable(stream.fileno(), True)
            setattr(sys, name, stream)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command.

    Returns the exit status: 0 done, 1 failed, 2 wrong input, 3 done but some layouts were
        refused, 130 interrupted; ``check`` has its own, see :mod:`steadyload.cli.check`.
    """
    try:
        from steadyload.cli.running import run

        status = run(sys.argv[1:] if arguments is None else list(arguments))
        sys.stdout.flush()
    except BrokenPipeError:
        from steadyload.cli.terminal import drop_output

        drop_output()
        return 0
    except (KeyboardInterrupt, Exception) as error:
        if not is_behind(error):
            raise
        tell(error)
        return INTERRUPTED
    return status
