"""Files that are either whole or not there."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable
from pathlib import Path


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
