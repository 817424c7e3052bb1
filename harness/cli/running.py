"""Run of the words of a command line; only the named command is imported."""

from __future__ import annotations

import io
import sys
from collections.abc import Sequence
from importlib import metadata
from typing import Any

from steadyload.cli.commands import OF_TOPICS, TOPICS, Command, Group, commands
from steadyload.cli.flags import HELP, UsageError, parsed, print_help
from steadyload.cli.terminal import say, say_warnings
from steadyload.engines.errors import EngineInputError
from steadyload.errors import FailedError, UserError, nearest
from steadyload.escaping import sentence

ABOUT = "How stable is this pallet while it is being loaded?"


def run(words: Sequence[str]) -> int:
    """Run the command of some words.

    Returns the exit status; the caller handles an interrupt and a closed pipe.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(
                errors="backslashreplace"
            )  # a name with characters that the terminal cannot show
    say_warnings()
    try:
        made = command_of(words)
        return (made.run() if made is not None else None) or 0
    except (UserError, EngineInputError, OSError) as error:
        if isinstance(error, BrokenPipeError):
            raise
        say(f"steadyload: {_sentence(error)}")
        return 2
    except FailedError as error:
        say(f"steadyload: {error}")
        return 1


def _sentence(error: Exception) -> str:
    if isinstance(error, OSError) and error.filename is not None:
        return sentence(f"{error.filename}: {error.strerror}")
    return sentence(" ".join([*str(error).split(), *getattr(error, "__notes__", [])]))


def command_of(words: Sequence[str]) -> Any:
    """The command of some words, ready to be run; None for a request for help or the version.

    Raises:
        UsageError: unknown command, or flags that are not allowed.
    """
    known = commands()
    if not words or words[0] in HELP:
        _help(known)
        return None
    if words[0] == "--version":
        print(metadata.version("steadyload"))
        return None
    first, *rest = words
    if first in OF_TOPICS and rest and rest[0].startswith("-") and rest[0] not in HELP:
        first, *rest = *OF_TOPICS[first].split(), *rest
    if first in TOPICS:
        actions = {name: c for name, c in known.items() if name.split()[0] == first}
        if not rest or rest[0] in HELP:
            _help(actions, first)
            return None
        if f"{first} {rest[0]}" not in actions:
            names = [name.split()[1] for name in actions]
            raise UsageError(f"unknown action {rest[0]!r} of {first}; {nearest(rest[0], names)}")
        first, rest = f"{first} {rest[0]}", rest[1:]
    if first not in known:
        names = list(dict.fromkeys(name.split()[0] for name in known))
        raise UsageError(f"unknown command {first!r}; {nearest(first, names)}")
    command = known[first]
    return parsed(first, command.load(), command.about, rest)


def _help(known: dict[str, Command], topic: str = "") -> None:
    """Print commands in groups, or the actions of a topic."""
    from cyclopts import App
    from cyclopts import Group as Panel

    app = App(
        name=f"steadyload {topic}".strip(),
        help=TOPICS[topic][0] if topic else ABOUT,
        help_flags=HELP,
        version_flags=() if topic else ("--version",),
        help_format="plaintext",
        group_commands=Panel("Actions" if topic else "Flags", sort_key=9),
    )
    panels = {group: Panel(str(group), sort_key=order) for order, group in enumerate(Group)}
    listed = [] if topic else [(name, *told) for name, told in TOPICS.items()]
    for place, (name, command) in enumerate(known.items()):
        if topic:
            app.command(App(name=name.split()[1], help=command.about, help_flags=(),
                            version_flags=(), sort_key=place))  # fmt: skip
        elif " " not in name:
            listed.append((name, command.about, command.group))
    order = list(dict.fromkeys(name.split()[0] for name in known))
    for name, about, group in listed:
        app.command(App(name=name, help=about, group=panels[group], help_flags=(),
                        version_flags=(), sort_key=order.index(name)))  # fmt: skip
    print_help(app)
    if not topic:
        print("\nsteadyload COMMAND --help tells the flags of a command.")
