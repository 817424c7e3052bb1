"""Content of files that a user names, or that may come from somebody else, up to a size.

The size of a file is looked at before it is read. A device or a pipe does not know its size, so
that no more is read of it than is allowed. Layout files are read by
:mod:`steadyload.layouts.files.sources`, which holds to the limits of their formats.
"""

from __future__ import annotations

import json
import lzma
import os
import re
import stat
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import resources
from io import BufferedReader
from pathlib import Path
from typing import Any, BinaryIO, TextIO

from steadyload.errors import UserError
from steadyload.escaping import printable

MAX_TOML_BYTES = 1024**2
"""Bytes of a TOML file: a study, a profile, a rule, a plan, a configuration."""

MAX_KEY_PARTS = 32
"""Parts of a dotted key of a TOML file: what its parser takes grows with their square."""

MAX_HISTORY_BYTES = 8 * 1024**2
"""Bytes of a history of accelerations, an hour at 100 Hz, and of a table of field tests."""

MAX_STORED_BYTES = 64 * 1024**2
"""Bytes of a stored file of JSON, of a search, packed or not, of a page that is replaced, and of
recorded motion."""

MAX_STORED_VALUES = 4_000_000
"""Values of a stored file of JSON."""

MAX_TABLE_BYTES = 256 * 1024**2
"""Bytes of a stored table or shard, of weights, and of a checkpoint of a training."""

MAX_COPY_BYTES = 32 * 1024**3
"""Bytes of the layouts that a run keeps, of which one at a time is held in memory."""

_MOST_MEMORY = 128 * 1024**2
"""Bytes that unpacking takes beside what it unpacks; the strongest packing needs half of them."""

_LONGEST = 200
"""Characters of what a parser says."""

_KEY = re.compile(r"[^,=\[\]{}\n]+")
"""What stands between two signs of TOML: a key, or a value."""


class TooLargeError(UserError):
    """A file with more bytes than are read."""

    def __init__(self, path: str | Path, most: int, found: int | None = None) -> None:
        size = "more than is read of a device or pipe" if found is None else in_words(found)
        super().__init__(f"{path}: is too large ({size}); allowed: {in_words(most)}")


def in_words(size: int) -> str:
    """A number of bytes for a message, rounded up."""
    unit, name = (1024**2, "MiB") if size >= 1024**2 else (1024, "KiB")
    return f"{-(-size // unit):,} {name}"


def _opened_up_to(path: Path, most: int) -> BufferedReader:
    """A file, opened to be read as bytes; of a device or pipe the reader has to count them.

    Raises:
        TooLargeError: it has more bytes.
        OSError: it cannot be read.
    """
    file = path.open("rb")
    if (found := size_of(file)) > most:
        file.close()
        raise TooLargeError(path, most, found)
    return file


def size_of(file: BinaryIO) -> int:
    """Bytes of a file that is open; 0 for what does not know: a device, a pipe, memory."""
    try:
        about = os.fstat(file.fileno())
    except OSError:
        return 0
    return about.st_size if stat.S_ISREG(about.st_mode) else 0


@contextmanager
def naming(path: str | Path) -> Iterator[None]:
    """Errors of the system that are raised while a file is read name it."""
    try:
        yield
    except OSError as error:
        if error.filename is None:
            raise type(error)(error.errno, error.strerror, str(path)) from None
        raise


def content_of(path: Path, most: int) -> bytes:
    """All bytes of a file.

    Raises:
        TooLargeError: it has more bytes.
        OSError: it cannot be read.
    """
    with naming(path), _opened_up_to(path, most) as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise TooLargeError(path, most)
    return content


def regular(path: Path, most: int) -> BufferedReader:
    """A stored file, opened to be read in parts: no device and no pipe.

    Raises:
        TooLargeError: it has more bytes, or is no regular file.
        OSError: it cannot be read.
    """
    if not stat.S_ISREG(path.stat().st_mode) and not path.is_dir():
        raise TooLargeError(path, most)
    return _opened_up_to(path, most)


def lines_of(file: TextIO, path: Path, most: int) -> Iterator[str]:
    """Lines of a file, in turn.

    Raises:
        TooLargeError: a line has more characters than allowed.
    """
    while line := file.readline(most + 1):
        if len(line) > most:
            raise TooLargeError(path, most, len(line))
        yield line


def json_of(content: bytes) -> Any:
    """The content of a stored file of JSON.

    Raises:
        ValueError: it is no JSON, or holds more than :data:`MAX_STORED_VALUES`.
        RecursionError: it is too deep.
    """
    if sum(map(content.count, (b",", b":", b"[", b"{"))) > MAX_STORED_VALUES:
        raise ValueError(f"more than {MAX_STORED_VALUES:,} values")
    return json.loads(content)


def own_file(package: str, name: str = "") -> Path:
    """A file or folder that comes with a package of ours, such as ``steadyload.methods``."""
    return Path(str(resources.files(package))) / name


def toml_of(path: Path, error: type[UserError]) -> dict[str, Any]:
    """The content of a TOML file, whose text may begin with a byte order mark.

    Args:
        path: the file.
        error: what is raised where it is no TOML in UTF-8, is too deep, or has a key of more than
            :data:`MAX_KEY_PARTS`.

    Raises:
        TooLargeError: it has more than :data:`MAX_TOML_BYTES`.
        OSError: it cannot be read.
    """
    content = content_of(path, MAX_TOML_BYTES)
    try:
        text = content.decode("utf-8-sig")
        if any(found.group().count(".") >= MAX_KEY_PARTS for found in _KEY.finditer(text)):
            raise ValueError(f"a key of more than {MAX_KEY_PARTS} parts")
        return tomllib.loads(text)
    except (ValueError, RecursionError) as found:
        raise error(f"{path}: not valid TOML ({printable(str(found), _LONGEST)})") from None


class UnpacksTooLargeError(ValueError):
    """A packed file that unpacks to more bytes than are allowed."""


def unpacked(content: bytes, most: int) -> bytes:
    """The content of an xz file.

    Raises:
        UnpacksTooLargeError: it unpacks to more bytes.
        ValueError: it is none, or is cut off.
    """
    packed = lzma.LZMADecompressor(lzma.FORMAT_XZ, _MOST_MEMORY)
    try:
        found = packed.decompress(content, max_length=most + 1)
    except lzma.LZMAError as error:
        raise ValueError(str(error)) from None
    if len(found) > most:
        raise UnpacksTooLargeError(f"more than {most} bytes")
    if not packed.eof:
        raise ValueError("cut off")
    return found
