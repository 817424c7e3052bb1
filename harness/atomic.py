"""Files that are either whole or not there, and checksums by which a later change is noticed."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

CHECKSUM_DIGITS = 16
"""Number of digits of a checksum."""

_CHECKSUM = "checksum"
"""Key of a manifest's own checksum."""


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
    """A manifest that was read, without its checksum; those of earlier versions have none.

    Raises:
        ChecksumError: it is not what was written.
    """
    manifest = dict(found)
    if manifest.pop(_CHECKSUM, None) not in (None, checksum(json.dumps(manifest).encode())):
        raise ChecksumError
    return manifest


def write_atomically(path: Path, content: str | bytes | Iterable[str]) -> None:
    """Write ``content`` to ``path`` under another name first, then rename it into place.

    A link is followed; what is not a regular file (a device, a pipe) is written to as it is.

    Args:
        path: the file.
        content: what is to stand in it; texts that follow each other are asked for in turn.

    Raises:
        OSError: names ``path``; the folder does not exist or cannot be written to.
    """
    whole = content.encode() if isinstance(content, str) else content
    parts = [whole] if isinstance(whole, bytes) else (text.encode() for text in whole)
    try:
        target = path.resolve()
        if target.exists() and not target.is_file():
            with target.open("wb") as file:
                file.writelines(parts)
            return
        _replace(target, parts)
    except OSError as error:
        raise type(error)(error.errno, error.strerror, str(path)) from None


def clear_unfinished(folder: Path, name: str) -> None:
    """Remove what :func:`write_atomically` left when its process was killed.

    Args:
        folder: where it wrote; there may be none.
        name: of the file it wrote, or a pattern of names.
    """
    for unfinished in folder.glob(f".{name}.*"):
        unfinished.unlink(missing_ok=True)


def _replace(target: Path, parts: Iterable[bytes]) -> None:
    handle, name = tempfile.mkstemp(prefix=f".{target.name}.", dir=target.parent)
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
