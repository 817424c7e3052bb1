"""Flags of a command: made from a configuration's fields, and parsed into one.

Names, meanings, ranges and defaults are declared once, with the fields (see
:mod:`steadyload.config`); cyclopts splits the words of a command line and prints the help.
"""

from __future__ import annotations

import dataclasses
import inspect
import math
import types
import typing
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, TypeVar

from cyclopts import (
    App,
    CycloptsError,
    Group,
    MissingArgumentError,
    Parameter,
    UnknownOptionError,
    UnusedCliTokensError,
)

from steadyload.config import (
    BARE,
    FEWEST,
    METAVAR,
    NAMES,
    OPERAND,
    READ,
    ConfigError,
    choices_of,
    number_of,
    numbers_allowed,
    values_of,
)
from steadyload.errors import UserError, nearest
from steadyload.reading import toml_of

T = TypeVar("T")

HELP = ("--help", "-h")

CONFIG = "config"
"""The field of a command that names a TOML file of its other fields; flags override its keys."""


class UsageError(UserError):
    """Words of a command line that are not allowed."""


@dataclasses.dataclass(frozen=True)
class _Flag:
    """A field of a configuration as a flag, or as an operand."""

    field: dataclasses.Field[Any]
    kind: type
    several: bool

    @property
    def names(self) -> tuple[str, ...]:
        if self.said(OPERAND):
            return (self.said(METAVAR),)
        return self.said(NAMES) or ("--" + self.field.name.replace("_", "-"),)

    @property
    def required(self) -> bool:
        return (
            self.field.default is dataclasses.MISSING
            and self.field.default_factory is dataclasses.MISSING
        )

    def said(self, key: str) -> Any:
        """Entry of the field's metadata; None where a plain quantity has none."""
        return self.field.metadata.get(key)

    @property
    def metavar(self) -> str:
        words = {int: "N", float: "X", Path: "FILE"}
        return self.said(METAVAR) or words.get(self.kind, "NAME")

    def read(self, text: str) -> Any:
        """The value of a text.

        Raises:
            UsageError: not a value; the message names the flag, the text, and what is allowed.
        """
        try:
            if (read := self.said(READ)) is not None:
                return read(text)
            if self.kind in (int, float):
                return self._number(text)
            return self.kind(self._chosen(text))
        except UserError:
            raise
        except ValueError as error:
            raise UsageError(f"{self.names[0]}: {error}") from None

    def _number(self, text: str) -> float:
        least, most = self.said("least"), self.said("most")
        if self.kind is int:
            least = max(least, 0)
            number = int(text) if text.isascii() and text.isdigit() else math.nan
        else:
            number = number_of(text)
        if not least <= number <= most:
            raise ValueError(f"{text!r}; allowed: {numbers_allowed(self.kind, least, most)}")
        return number

    def _chosen(self, text: str) -> str:
        known = choices_of(self.field.metadata)
        if known and text not in known:
            raise ValueError(f"{text!r}; {nearest(text, known)}")
        return text

    def about(self) -> str:
        """Meaning of the flag, with the allowed words."""
        about: str = self.said("about")
        if self.said("choices") and not self.said(METAVAR):
            about += f"; one of {', '.join(choices_of(self.field.metadata))}"
        return about

    def parameter(self, *, helping: bool) -> inspect.Parameter:
        """The flag as a parameter for cyclopts, which converts no texts."""
        hint: Any = bool if self.kind is bool else str
        fewest: Any = self.said(FEWEST)
        if self.said(BARE) is not None:
            fewest = (0, 1)
        if self.several or self.said(BARE) is not None:
            hint = tuple[str, ...]
        made = Parameter(
            name=None if self.said(OPERAND) else self.names,
            negative=(),
            help=self.about() if helping else "",
            metavar=None if self.kind is bool else self.metavar,
            show_default=False,
            show_choices=False,
            consume_multiple=fewest,
            allow_repeating=True,
            required=self.required,
        )
        return inspect.Parameter(
            self.field.name,
            inspect.Parameter.POSITIONAL_ONLY if self.said(OPERAND) else
            inspect.Parameter.KEYWORD_ONLY,
            default=inspect.Parameter.empty if self.required else None,
            annotation=Annotated[hint, made],
        )  # fmt: skip

    def value(self, given: Any) -> Any:
        """The field's value from the texts that cyclopts found."""
        if self.kind is bool:
            return given
        if self.said(BARE) is not None:
            return self.read(given[-1]) if given else self.said(BARE)
        return tuple(map(self.read, given)) if self.several else self.read(given)


def _flags(config: type) -> list[_Flag]:
    hints = typing.get_type_hints(config)
    flags = [
        _Flag(field, *_kind(hints[field.name]))
        for field in dataclasses.fields(config)
        if field.init
    ]
    return sorted(flags, key=lambda flag: not flag.said(OPERAND))


def _kind(hint: Any) -> tuple[type, bool]:
    """Type of one value, and True if there may be several."""
    if isinstance(hint, types.UnionType):
        [hint] = [one for one in typing.get_args(hint) if one is not types.NoneType]
    if typing.get_origin(hint) is tuple:
        return typing.get_args(hint)[0], True
    return hint, False


def application(name: str, config: type, about: str, *, helping: bool = False) -> App:
    """Parser of a command's words, which prints its help; returns the texts by field."""

    def found(*operands: Any, **given: Any) -> dict[str, Any]:
        named = dict(zip((f.field.name for f in flags if f.said(OPERAND)), operands, strict=False))
        return {key: value for key, value in {**named, **given}.items() if value is not None}

    flags = _flags(config)
    parameters = [flag.parameter(helping=helping) for flag in flags]
    found.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    found.__annotations__ = {p.name: p.annotation for p in parameters}
    app = App(
        name=f"steadyload {name}",
        help=about,
        help_flags=HELP,
        version_flags=(),
        help_format="plaintext",
        group_commands=Group("Parameters"),
        result_action="return_value",
    )
    app.default(found)
    return app


def parsed(name: str, config: type[T], about: str, words: Sequence[str]) -> T | None:
    """The configuration of the words; None for a request for help, which is printed.

    Raises:
        UsageError: an unknown flag, or a value that is not allowed.
    """
    flags = {flag.field.name: flag for flag in _flags(config)}
    words = _whole_names(words, [n for f in flags.values() for n in f.names] + list(HELP))
    if any(word in HELP for word in _before_the_rest(words)):
        print_help(application(name, config, about, helping=True))
        return None
    app = application(name, config, about)
    try:
        found = app(words, exit_on_error=False, print_error=False)
    except UnknownOptionError as error:
        known = [n for f in flags.values() if not f.said(OPERAND) for n in f.names]
        word = (error.token.keyword or error.token.value or "").partition("=")[0]
        raise UsageError(f"{name}: unknown flag {word!r}; {_near(word, [*known, *HELP])}") from None
    except UnusedCliTokensError as error:
        left = ", ".join(map(repr, error.unused_tokens or ()))
        raise UsageError(
            f"{name}: nothing takes {left}; allowed: one word after a flag, which may hold commas; "
            "files stand side by side"
        ) from None
    except MissingArgumentError as error:
        raise UsageError(f"{name}: {_missing(error, flags)}") from None
    except CycloptsError as error:
        error.verbose = False
        raise UsageError(f"{name}: {error}") from None
    values = {key: flags[key].value(value) for key, value in found.items()}
    if CONFIG in values:
        values = read_config(values[CONFIG], config) | values
    try:
        return config(**values)
    except UserError:
        raise
    except ValueError as error:
        raise UsageError(f"{name}: {error}") from None


def read_config(path: Path, command: type) -> dict[str, Any]:
    """Values of a configuration file, by field of a command.

    Raises:
        ConfigError: the file is not valid TOML, or has a key or value that is not allowed.
        TooLargeError: it has too many bytes.
        OSError: the file cannot be read.
    """
    return values_of(command, toml_of(path, ConfigError), str(path), apart={CONFIG})


def _missing(error: MissingArgumentError, flags: Mapping[str, _Flag]) -> str:
    """Which flag or operand is needed, or which flag stands without its value."""
    assert error.argument is not None, "it says what is missing"
    flag = flags[error.argument.field_info.name]
    if error.keyword is not None:
        return f"{error.keyword} has no value; allowed: {error.keyword} {flag.metavar}"
    return f"{flag.metavar if flag.said(OPERAND) else f'{flag.names[-1]} {flag.metavar}'} is needed"


def _near(word: str, known: Sequence[str]) -> str:
    """Sentence with the most similar names, since there may be thirty."""
    close = nearest(word, known).partition("? ")
    return close[0] + "?" if close[1] else f"allowed: {', '.join(k for k in known if k[1] == '-')}"


def _before_the_rest(words: Sequence[str]) -> Sequence[str]:
    return words[: words.index("--")] if "--" in words else words


def _whole_names(words: Sequence[str], names: Collection[str]) -> list[str]:
    """Words with unambiguous prefixes of flags replaced by the whole flags."""
    made = []
    for word in _before_the_rest(words):
        flag, equals, value = word.partition("=")
        begun = [name for name in names if name.startswith(flag)] if flag[:2] == "--" else []
        if word == "-":  # standard input, which is no flag
            word = "./-"
        made.append(begun[0] + equals + value if len(begun) == 1 and len(flag) > 2 else word)
    return made + list(words[len(made) :])


def print_help(app: App) -> None:
    """Print an application's help on stdout; a closed pipe is no error."""
    from rich.console import Console

    console = Console(highlight=False, soft_wrap=False)
    with console.capture() as capture:
        app.help_print([], console=console)
    print(capture.get(), end="")
