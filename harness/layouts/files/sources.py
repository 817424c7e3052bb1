"""Content of a layout file, of a pipe or of standard input, up to a size."""

from __future__ import annotations

import io
import json
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any, BinaryIO, Self

from steadyload.errors import UserError, required
from steadyload.escaping import printable, sentence
from steadyload.layouts.files.limits import MAX_FILE_BYTES, MAX_STREAM_BYTES
from steadyload.layouts.files.record import FormatError
from steadyload.reading import naming, size_of

_CHUNK = 1024**2

STANDARD_INPUT = "-"
"""Stands for standard input where a file is named."""

_GIVEN, _GIVEN_MAPPING = "the given bytes", "the given mapping"
"""Names of contents without a file, in messages."""


class _NamingError(OSError, UserError):
    """A named file that is none, as an error of the system and of the user."""

    def __str__(self) -> str:
        return sentence(f"{self.filename}: {self.strerror}")


class MissingFileError(FileNotFoundError, _NamingError):
    """A file that there is not; it can also be caught as a ``FileNotFoundError``."""


class FolderError(IsADirectoryError, _NamingError):
    """A folder instead of a file; it can also be caught as an ``IsADirectoryError``."""


def distinct_names(files: Iterable[str]) -> dict[str, str]:
    """Names that tell some files apart, by file: without folders where that is enough."""
    names = {file: Path(file).name for file in files}
    return names if len(set(names.values())) == len(names) else {file: file for file in names}


@dataclass(frozen=True)
class Content:
    """All bytes of a file, which stay the same when the file changes or was a pipe.

    Layouts are read from it as from the path of a file.

    Args:
        path: of the file, or its name in messages; ``-`` for standard input.
        data: the bytes.
    """

    path: str
    data: bytes = field(repr=False)

    @classmethod
    def of(cls, path: str | Path) -> Self:
        """The content of a file, a pipe or standard input.

        Raises:
            FormatError: it has more than :data:`MAX_FILE_BYTES`.
            MissingFileError: as :func:`opened_source`, as all that follow.
            FolderError: likewise.
            OSError: likewise.
        """
        with opened_source(path) as file:
            large = size_of(file) > MAX_FILE_BYTES
            data = b"" if large else file.read(MAX_FILE_BYTES + 1)
        if large or len(data) > MAX_FILE_BYTES:
            raise FormatError(
                "is too large to be changed; allowed: up to "
                f"{MAX_FILE_BYTES // 1024**2} MiB, or another format for the changed plans"
            ).located(file=source_name(path))
        return cls(str(path), data)

    def __str__(self) -> str:
        return self.path


File = str | PathLike[str] | bytes | BinaryIO | Mapping[str, Any] | Content
"""What a caller may give to be read: a path, bytes, a file that is open to be read as bytes, or a
mapping with the content of a JSON file."""

Source = str | Path | Content
"""What layouts are read from: the path of a file, ``-`` for standard input, or bytes."""


def source_of(given: File) -> Source:
    """The path or the content that a caller gave to be read, which can be read more than once.

    Args:
        given: a path, ``-`` for standard input, the bytes themselves, or a file that is open to be
            read as bytes, of which the rest is read; or the parsed content of a JSON file.

    Raises:
        WrongTypeError: it is nothing of these.
        FormatError: a file that is open has more bytes than are read.
    """
    if isinstance(given, str | Content):
        return given
    if isinstance(given, PathLike):
        return Path(given)
    if isinstance(given, bytes | bytearray | memoryview):
        return Content(_GIVEN, bytes(given))
    if isinstance(given, Mapping):
        return Content(_GIVEN_MAPPING, _as_json(given))
    content = given.read(MAX_FILE_BYTES + 1) if hasattr(given, "read") else given
    allowed = "a path, bytes, a file opened to be read as bytes, or a mapping as in a JSON file"
    found = required("the file to read", content, bytes, allowed)
    if len(found) > MAX_FILE_BYTES:
        raise _too_large(MAX_FILE_BYTES)
    return Content(_GIVEN, found)


def _as_json(given: Mapping[str, Any]) -> bytes:
    """A mapping as the JSON file that has it.

    Raises:
        FormatError: it has what JSON has not, or more than is read.
    """
    try:
        text = json.dumps(given, default=dict).encode()
    except (TypeError, ValueError, RecursionError) as error:
        raise FormatError(
            f"has what JSON has not ({printable(str(error))}); allowed: mappings, lists, texts, "
            "numbers, True, False and None"
        ).located(file=_GIVEN_MAPPING) from None
    if len(text) > MAX_FILE_BYTES:
        raise _too_large(MAX_FILE_BYTES)
    return text


def source_name(source: Source) -> str:
    """The name of a file for a message."""
    return "standard input" if str(source) == STANDARD_INPUT else str(source)


@contextmanager
def opened_source(path: Source) -> Iterator[BinaryIO]:
    """A file, or standard input for ``-``, or bytes, as bytes.

    Raises:
        MissingFileError: there is no such file.
        FolderError: it is a folder.
        OSError: it cannot be read.
    """
    if isinstance(path, Content):
        yield io.BytesIO(path.data)
        return
    if str(path) == STANDARD_INPUT:
        yield sys.stdin.buffer
        return
    with naming(path), ExitStack() as open_files:
        try:
            file = open_files.enter_context(Path(path).open("rb"))
        except FileNotFoundError as error:
            raise MissingFileError(*error.args, str(path)) from None
        except IsADirectoryError as error:
            told = "is a folder; allowed: a file of layouts"
            raise FolderError(error.errno, told, str(path)) from None
        yield file


def read_rest(file: BinaryIO, head: bytes, cap: int) -> bytearray:
    """All of a file of which the head has been read.

    A pipe does not know its size, so that no more is read than is allowed.

    Raises:
        FormatError: it has more bytes than the cap, or a zero byte, as files with holes have.
    """
    content = bytearray(head)
    size = size_of(file)
    while size <= cap and (chunk := file.read(_CHUNK)):
        if b"\0" in chunk:
            place = len(content) + chunk.index(b"\0")
            raise FormatError(f"is no text (byte {place} is 0); save it as UTF-8")
        content += chunk
        size = max(size, len(content))
    if size > cap:
        raise _too_large(cap)
    return content


def seekable(file: BinaryIO, head: bytes) -> BinaryIO:
    """A file of which the head has been read, as one that can be read at any place.

    A pipe is read into memory, up to :data:`MAX_FILE_BYTES`.

    Raises:
        FormatError: it has more bytes than are read.
    """
    if file.seekable():
        if size_of(file) > MAX_STREAM_BYTES:
            raise _too_large(MAX_STREAM_BYTES)
        return file
    content = head + file.read(MAX_FILE_BYTES + 1 - len(head))
    if len(content) > MAX_FILE_BYTES:
        raise _too_large(MAX_FILE_BYTES)
    return io.BytesIO(content)


def _too_large(cap: int) -> FormatError:
    return FormatError(f"is too large; allowed for this format: {cap // 1024**2} MiB")


def decoded(content: bytes | bytearray, before: int = 0) -> str:
    """A text of UTF-8.

    Args:
        content: the bytes.
        before: how many of the file lie before them.

    Raises:
        FormatError: it is none; the message says at which byte of the file.
    """
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise FormatError(
            f"is not UTF-8 text (byte {before + error.start}); save it as UTF-8"
        ) from None
