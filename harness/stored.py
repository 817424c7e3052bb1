"""Small JSON files that are stored and read again: whole, or refused by one sentence."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from steadyload.atomic import ChecksumError, manifest_text, verified_manifest, write_atomically
from steadyload.errors import UserError
from steadyload.escaping import printable
from steadyload.reading import MAX_STORED_BYTES, content_of, json_of

_LONGEST_KEY, _MOST_KEYS = 40, 8

REMEDY = "install steadyload again, or restore the file"
"""Advice on a damaged file of the package."""


class StoredFileError(UserError):
    """A stored file whose content is no longer what was written."""

    def __init__(self, path: Path, remedy: str) -> None:
        super().__init__(f"{path}: is damaged; {remedy}")


def stored_object(path: Path, remedy: str) -> dict[str, Any]:
    """The object of a JSON file, without its checksum.

    Args:
        path: the file.
        remedy: end of the sentence that refuses it: what mends it.

    Raises:
        StoredFileError: it holds no object, or has changed since it was written.
        TooLargeError: it has too many bytes.
        OSError: it cannot be read.
    """
    content = content_of(path, MAX_STORED_BYTES)
    try:
        return verified_manifest(_parsed(content, dict))
    except (ChecksumError, ValueError, RecursionError):
        raise StoredFileError(path, remedy) from None


def stored_list(path: Path, key: str, remedy: str) -> list[Any]:
    """The list of a JSON file that :func:`store_list` wrote.

    Args:
        path: the file; an empty list where there is none.
        key: under which it stands.
        remedy: see :func:`stored_object`, as for what is raised.
    """
    if not path.exists():
        return []
    content = content_of(path, MAX_STORED_BYTES)
    try:
        values = verified_manifest(_parsed(content, dict))[key]
        if not isinstance(values, list) or not all(isinstance(value, dict) for value in values):
            raise ValueError
    except (ChecksumError, LookupError, ValueError, RecursionError):
        raise StoredFileError(path, remedy) from None
    return values


def store_list(path: Path, key: str, values: list[Any]) -> None:
    """Write a list under a key, with a checksum."""
    write_atomically(path, manifest_text({key: values}))


def differing(one: Mapping[str, Any], other: Mapping[str, Any]) -> str:
    """Names of the keys of which two mappings have different values, for a message."""
    keys = sorted(key for key in {*one, *other} if one.get(key) != other.get(key))
    named = [printable(key, _LONGEST_KEY) for key in keys[:_MOST_KEYS]]
    return ", ".join([*named, "..."] if len(keys) > _MOST_KEYS else named)


def _parsed(content: bytes, kind: Any) -> Any:
    found = json_of(content)
    if not isinstance(found, kind):
        raise ValueError
    return found
