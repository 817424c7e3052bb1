"""Shards of a run folder: found, judged where they are missing, written whole, verified, locked.

A shard holds the results of one unit of work, under a key that is a hash of everything that they
depend on. Its file is ``KEY.CHECKSUM.SUFFIX`` and is renamed into place: it is complete or absent,
and a later change is noticed whenever it is read. :meth:`Store.complete` is the one loop that fills
run folders.
"""

from __future__ import annotations

import errno
import fcntl
import hashlib
import json
import logging
import os
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Generic, NoReturn, Protocol, Self, TypeVar

import pandas as pd
import pyarrow as pa

from steadyload.atomic import (
    CHECKSUM_DIGITS,
    checksum,
    clear_unfinished,
    not_a_link,
    write_atomically,
)
from steadyload.errors import UserError
from steadyload.layouts.benchmark.tables import as_parquet, from_parquet
from steadyload.layouts.files.parquet_table import TableTooLargeError
from steadyload.progress import Progress, silent
from steadyload.reading import MAX_COPY_BYTES, MAX_TABLE_BYTES, content_of, regular
from steadyload.runs.kept_only import refuse_unless_kept
from steadyload.runs.pool import IN_THIS_PROCESS, Executor, PartLimit, run_units

CHECKPOINTS, CHECKPOINT = "checkpoints", "checkpoint"
"""Folder in a work folder, and stem of a file, of what an interrupted run continues from."""


_log = logging.getLogger("steadyload")


class ResultsError(UserError):
    """A folder that holds no study, a damaged one, or one of another version."""


class DamagedError(ResultsError):
    """A file whose content is no longer what was written."""

    def __init__(self, path: Path) -> None:
        super().__init__(f"{path}: cannot be read, it is damaged; run the study again to mend it")


class KeyedUnit(Protocol):
    """A unit of work whose results are a shard."""

    @property
    def key(self) -> str:
        """The shard's key, see :func:`steadyload.runs.provenance.key_of`."""
        ...

    def __len__(self) -> int: ...

    def without(self, done: int) -> Self:
        """See :func:`steadyload.runs.pool.run_units`, as for the next."""
        ...

    def describe(self, part: int) -> str:
        """Description of a part for messages."""
        ...


Unit = TypeVar("Unit", bound=KeyedUnit)
Answer = TypeVar("Answer")
Stored = TypeVar("Stored")
Decoded = TypeVar("Decoded")


@dataclass(frozen=True, slots=True)
class Codec(Generic[Answer, Stored]):
    """Conversion of the results of a unit to the bytes of a file and back.

    Attributes:
        suffix: of the file, with its dot.
        encode: results to bytes; equal results give equal bytes.
        decode: the bytes of :attr:`encode` to what :meth:`Store.read` returns.
    """

    suffix: str
    encode: Callable[[Sequence[Answer]], bytes]
    decode: Callable[[bytes], Stored]


def _as_json(answers: Sequence[Any]) -> bytes:
    return (json.dumps(list(answers), indent=1) + "\n").encode()


JSON: Codec[Any, list[Any]] = Codec(".json", _as_json, json.loads)
"""Codec of results that JSON can hold."""


def parquet(schema: pa.Schema) -> Codec[dict[str, Any], pd.DataFrame]:
    """Codec of rows of a schema; keys that a row lacks are null."""

    def encode(rows: Sequence[dict[str, Any]]) -> bytes:
        return as_parquet(pd.DataFrame(list(rows)).reindex(columns=schema.names), schema)

    return Codec(".parquet", encode, partial(from_parquet, schema=schema))


def checksum_of(path: Path) -> str:
    """The checksum of a file of any size; empty where there is none."""
    try:
        with regular(path, MAX_COPY_BYTES) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()[:CHECKSUM_DIGITS]
    except FileNotFoundError:
        return ""


def is_whole(path: Path, expected: str) -> bool:
    """True if a file exists as it was written; a warning names one that is damaged."""
    found = checksum_of(path)
    if found and found != expected:
        _log.warning("%s: is damaged; it is thrown away and made again", path)
    return found == expected


@contextmanager
def locked(directory: Path) -> Iterator[None]:
    """Lock that allows one run a folder at a time; it ends with the process in every case.

    Args:
        directory: made when it does not exist.

    Raises:
        ResultsError: it is no folder, another run is at work in it, or its lock is a link.
    """
    if directory.exists() and not directory.is_dir():
        raise ResultsError(f"{directory}: is not a folder")
    directory.mkdir(parents=True, exist_ok=True)
    path = directory / ".lock"
    try:
        handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
    except OSError as error:
        if error.errno == errno.ELOOP:
            raise ResultsError(f"{path}: is a link, which no lock may be; remove it") from None
        raise
    with os.fdopen(handle, "rb"):
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise ResultsError(f"{directory}: another run is at work in this folder") from None
        yield


@dataclass(slots=True)
class Survey:
    """Which shards of some units exist.

    Attributes:
        keys: of all units, in their order.
        missing: keys of the units that are to be judged.
        parts: number of parts of all units.
        present: number of parts that need no judging.
    """

    keys: dict[str, None] = field(default_factory=dict)
    missing: set[str] = field(default_factory=set)
    parts: int = 0
    present: int = 0

    @classmethod
    def of(cls, units: Iterable[KeyedUnit]) -> Survey:
        """Of units none of which has a shard."""
        sizes = {unit.key: len(unit) for unit in units}
        return cls(dict.fromkeys(sizes), set(sizes), sum(sizes.values()))

    def __or__(self, other: Survey) -> Survey:
        """Of the units of both, which have no key in common."""
        return Survey(
            self.keys | other.keys,
            self.missing | other.missing,
            self.parts + other.parts,
            self.present + other.present,
        )


@dataclass(frozen=True, slots=True)
class _Lost:
    """Placeholder for a part that ended its process, where a crash is no result."""

    reason: str


def lost_part(unit: Any, part: int, reason: str) -> Any:  # noqa: ARG001 - a NoResult
    """Placeholder of the result of a part that has none; see :meth:`Store.complete`."""
    return _Lost(reason)


def _refuse(unit: KeyedUnit, reason: str) -> NoReturn:
    raise ResultsError(f"{unit.describe(0)}: {reason}")


class Store(Generic[Answer, Stored]):
    """The shards of one folder. The lock of the run folder must be held to write.

    Args:
        folder: of the shards; made when the first one is written.
        codec: of their content.
    """

    def __init__(self, folder: Path, codec: Codec[Answer, Stored]) -> None:
        self._folder, self._codec = folder, codec
        self._sums = self._listed()

    def __contains__(self, key: str) -> bool:
        """True if a shard of this key exists, intact or damaged."""
        return key in self._sums

    def keys(self) -> list[str]:
        """The keys of all shards, in no particular order."""
        return list(self._sums)

    def content(self, key: str) -> bytes:
        """The bytes of a shard, as they were written.

        Raises:
            DamagedError: it has changed since.
            ResultsError: it is missing.
        """
        try:
            path = self.path(key)
            found = content_of(path, MAX_TABLE_BYTES)
        except (KeyError, FileNotFoundError):
            raise ResultsError(f"{self._folder}: shard {key} is missing; run it again") from None
        if checksum(found) != self._sums[key]:
            raise DamagedError(path)
        return found

    def read(self, key: str) -> Stored:
        """The decoded content of a shard; raises as :meth:`decoded`."""
        return self.decoded(key, self._codec.decode)

    def decoded(self, key: str, decode: Callable[[bytes], Decoded]) -> Decoded:
        """The content of a shard, decoded otherwise.

        Raises:
            ResultsError: its table is too large, or as :meth:`content`.
        """
        content = self.content(key)
        try:
            return decode(content)
        except TableTooLargeError as error:
            raise ResultsError(f"{self.path(key)}: is too large: {error}") from None
        except (ArithmeticError, AttributeError, LookupError, OSError, TypeError, ValueError):
            raise DamagedError(self.path(key)) from None
        except (pa.ArrowException, RecursionError):
            raise DamagedError(self.path(key)) from None

    def parts_of(self, unit: Any) -> int:
        """How many parts a unit counts for."""
        return len(unit)

    def write(self, key: str, answers: Sequence[Answer]) -> None:
        """Write a shard, completely or not at all."""
        refuse_unless_kept(self._folder, 1, 1)
        self.add(key, self._codec.encode(answers))

    def add(self, key: str, content: bytes) -> None:
        """Write the bytes of a shard that was kept elsewhere, completely or not at all."""
        self.drop(key)
        not_a_link(self._folder).mkdir(parents=True, exist_ok=True)
        self._sums[key] = checksum(content)
        write_atomically(self.path(key), content)

    def drop(self, key: str) -> None:
        """Remove a shard if it exists."""
        if key in self._sums:
            not_a_link(self._folder)
            self.path(key).unlink(missing_ok=True)
            del self._sums[key]

    def missing(self, keys: Iterable[str]) -> set[str]:
        """The keys without an intact shard; a warning names a damaged one, which is removed."""
        return {key for key in keys if not self._is_whole(key)}

    def survey(self, units: Iterable[KeyedUnit], *, rerun: bool = False) -> Survey:
        """Find which shards of some units exist; half-written files of earlier runs are removed.

        Args:
            units: iterated once, so that there may be any number.
            rerun: count every shard as missing.
        """
        clear_unfinished(not_a_link(self._folder), f"*{self._codec.suffix}")
        self._sums, found = self._listed(), Survey()
        for unit in units:
            if unit.key in found.keys:
                continue
            found.keys[unit.key] = None
            found.parts += self.parts_of(unit)
            if rerun or not self._is_whole(unit.key):
                found.missing.add(unit.key)
            else:
                found.present += self.parts_of(unit)
        return found

    def complete(
        self,
        units: Iterable[Unit],
        work: Callable[[Unit], Iterator[Answer]],
        *,
        crashed: Callable[[Unit, int, str], Answer] | None = None,
        lost: Callable[[Unit, str], None] = _refuse,
        limit: PartLimit[Unit, Answer] | None = None,
        workers: int | Executor = IN_THIS_PROCESS,
        progress: Progress = silent,
        survey: Survey | None = None,
    ) -> int:
        """Judge the missing units, and write every shard as soon as it is complete.

        Args:
            units: all units whose shards are wanted; of units with the same key the first counts.
            work: see :func:`steadyload.runs.pool.run_units`, as for workers.
            crashed: makes the result of a part that ends its process. None: there is no result, and
                the unit stays missing.
            lost: called with such a unit and the reason; by default it is an error.
            limit: CPU time that a part may take, and the result of one that takes longer.
            workers: number of processes, or an executor.
            progress: called with parts done and parts in all, first with the existing ones.
            survey: the result of :meth:`survey`; units are then iterated once. None makes the
                survey here, and holds all units.

        Returns:
            The number of parts that were judged now, without those that are lost.

        Raises:
            NotKeptError: see :func:`steadyload.runs.kept_only.kept_only`.
            ResultsError: a unit ended its process, and neither ``crashed`` nor ``lost`` was given.
            WorkerDiedError: see :func:`steadyload.runs.pool.run_units`.
        """
        if survey is None:
            units = list(units)
            survey = self.survey(units)
        missing = survey.missing
        refuse_unless_kept(
            self._folder, survey.parts - survey.present, survey.parts,
            lambda: (unit.describe(0) for unit in units if unit.key in missing),
        )  # fmt: skip
        progress(survey.present, survey.parts)
        waiting, done = set(survey.missing), 0
        for unit, answers in run_units(
            work,
            _each_once(units, waiting),
            workers=workers,
            crashed=crashed or lost_part,
            limit=limit,
        ):
            why = [answer.reason for answer in answers if isinstance(answer, _Lost)]
            if why:
                lost(unit, why[0])
            else:
                self.write(unit.key, answers)
                done += self.parts_of(unit)
            progress(survey.present + done, survey.parts)
        return done

    def _is_whole(self, key: str) -> bool:
        if key in self._sums and not is_whole(self.path(key), self._sums[key]):
            self.drop(key)
        return key in self._sums

    def path(self, key: str) -> Path:
        """The file of a shard that exists."""
        return self._folder / f"{key}.{self._sums[key]}{self._codec.suffix}"

    def _listed(self) -> dict[str, str]:
        """The checksums of existing shards, by key; a file name without one is not a shard's."""
        name = re.compile(
            rf"([^.].*)\.([0-9a-f]{{{CHECKSUM_DIGITS}}}){re.escape(self._codec.suffix)}"
        )
        files = self._folder.iterdir() if self._folder.is_dir() else ()
        return {m[1]: m[2] for file in files if (m := name.fullmatch(file.name))}


def _each_once(units: Iterable[Unit], waiting: set[str]) -> Iterator[Unit]:
    for unit in units:
        if unit.key in waiting:
            waiting.remove(unit.key)
            yield unit
