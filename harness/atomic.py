"""Files that are either whole or not there, and checksums by which a later change is noticed."""

from __future__ import annotations

import hashlib
import json
import os
import re
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from steadyload.errors import UserError

CHECKSUM_DIGITS = 16
"""Number of digits of a checksum."""

_CHECKSUM = "checksum"
"""Key of a manifest's own checksum."""

_UNFINISHED = ".unfinished"
_OURS = re.compile(rf"\.[a-z0-9_]{{8}}\{_UNFINISHED}$")
"""End of the name of a file that is being written: what :mod:`tempfile` drew, and our ending."""


def checksum(content: bytes) -> str:
    """The checksum of a file's content: the first digits of its SHA-256."""
    return hashlib.sha256(content).hexdigest()[:CHECKSUM_DIGITS]


class ChecksumError(ValueError):
    """A manifest's content is not what was written."""


def manifest_text(manifest: Mapping[str, Any]) -> str:
    """A manifest as JSON, with the checksum of the rest as its last entry."""
    own = {_CHECKSUM: checksum(json.dumps(manifest).encode())}
    return json.dumps({**manifest, **own}, indent=1) + "\n"


def verified_manifest(found: Mapping[str, Any]) -> dict[str, Any]:
    """A manifest that was read, without its checksum.

    Raises:
        ChecksumError: it is not what was written, or has no checksum.
    """
    manifest = dict(found)
    if manifest.pop(_CHECKSUM, None) != checksum(json.dumps(manifest).encode()):
        raise ChecksumError
    return manifest


class LinkError(UserError):
    """A link where the program writes below a folder that a user names: it would lead elsewhere."""

    def __init__(self, path: Path) -> None:
        super().__init__(f"{path}: is a link, which nothing that is written here may be; remove it")


def not_a_link(path: Path) -> Path:
    """A file or folder that the program writes below a folder of results; there may be none yet.

    Raises:
        LinkError: it is a link.
    """
    if path.is_symlink():
        raise LinkError(path)
    return path


def without_link(path: Path) -> Path:
    """A file that is about to be replaced; a link in its place goes, what it points to stays."""
    if path.is_symlink():
        path.unlink()
    return path


def write_atomically(
    path: Path, content: str | bytes | Iterable[str] | Iterable[bytes], *, follow: bool = False
) -> None:
    """Write ``content`` to ``path`` under another name first, then rename it into place.

    Args:
        path: the file. A link gives way to the file; what it points to stays as it is.
        content: what is to stand in it; parts that follow each other are asked for in turn.
        follow: for a file that a user names: a link is followed, and what is not a regular file
            (a device, a pipe) is written to as it is.

    Raises:
        OSError: names ``path``; the folder does not exist or cannot be written to.
    """
    whole = content.encode() if isinstance(content, str) else content
    parts = [whole] if isinstance(whole, bytes) else map(_encoded, whole)
    try:
        target = path.resolve() if follow else path
        if follow and target.exists() and not target.is_file():
            with target.open("wb") as file:
                file.writelines(parts)
            return
        _replace(target, parts)
    except OSError as error:
        raise type(error)(error.errno, error.strerror, str(path)) from None


def _encoded(part: str | bytes) -> bytes:
    return part.encode() if isinstance(part, str) else part


def clear_unfinished(folder: Path, name: str) -> None:
    """Remove what :func:`write_atomically` left when its process was killed, and nothing else.

    Args:
        folder: where it wrote; there may be none.
        name: of the file it wrote, or a pattern of names.
    """
    for found in folder.glob(f".{name}.*"):
        if _OURS.search(found.name):
            found.unlink(missing_ok=True)


def is_unfinished(found: Path, name: str) -> bool:
    """True if a path has a name under which :func:`write_atomically` writes the file ``name``."""
    return found.name.startswith(f".{name}.") and _OURS.search(found.name) is not None


def _replace(target: Path, parts: Iterable[bytes]) -> None:
    handle, name = tempfile.mkstemp(_UNFINISHED, f".{target.name}.", target.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.writelines(parts)
        umask = os.umask(0)
        os.umask(umask)
        Path(name).chmod(0o666 & ~umask)
        Path(name).replace(target)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
