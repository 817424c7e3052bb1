"""All results of a search, line by line in one file, from which it can be resumed.

A line is written as soon as it is known. A search that is started again proposes the same genotypes
in the same order, finds those that were judged, and goes on where it was interrupted. Not a
:class:`steadyload.runs.store.Store`: what is judged next follows from all that is known by then.
"""

from __future__ import annotations

import json
import lzma
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from steadyload.atomic import checksum, not_a_link, write_atomically
from steadyload.reading import MAX_STORED_BYTES, content_of, unpacked
from steadyload.stored import differing
from steadyload.tuning import TuningError
from steadyload.tuning.space import Genotype
from steadyload.tuning.trial import TrialResult

_FILE = "search.jsonl"
_SUM = "sum"
_KEPT = f"{_FILE}.xz"
"""A finished search as it is kept: to be read, not to be gone on with."""


@dataclass(frozen=True)
class Entry:
    """A genotype, the generation in which it was judged, and its trial."""

    genotype: Genotype
    generation: int
    trial: TrialResult


@dataclass(frozen=True, slots=True)
class GenerationEnd:
    """A finished generation: genotypes proposed, their median fitness, and wall seconds spent."""

    number: int
    asked: int
    median: float
    wall: float


class Ledger:
    """The file of a search. Reading it changes nothing: a search may be writing to it.

    Args:
        directory: of the search; made when it does not exist.
        identity: what the search is; a file of another one is refused.

    Raises:
        TuningError: the folder holds another search, or a file that is none.
    """

    def __init__(self, directory: Path, identity: Mapping[str, Any]) -> None:
        directory.mkdir(parents=True, exist_ok=True)
        self._path = _path(directory)
        self.facts: dict[str, Any] = {}
        self.entries: dict[Genotype, Entry] = {}
        self.ends: list[GenerationEnd] = []
        self._cut: int | None = None
        """Bytes to keep before writing on, where a line was cut off."""
        self._begun = self._path.exists() and self._read(dict(identity))
        self._identity = dict(identity)

    @classmethod
    def of(cls, directory: Path) -> tuple[dict[str, Any], Ledger]:
        """The identity and the ledger that a folder holds.

        Raises:
            TuningError: it holds no search.
        """
        path = _path(directory)
        if not path.exists():
            raise TuningError(f"{directory}: holds no search")
        identity = _identity(_content(path).partition(b"\n")[0], path)
        return identity, cls(directory, identity)

    def keep(self, directory: Path) -> None:
        """Write a copy that takes a tenth of the space; :meth:`of` reads it."""
        directory.mkdir(parents=True, exist_ok=True)
        write_atomically(directory / _KEPT, lzma.compress(_content(self._path)))

    def state(self, name: str, value: Any) -> None:
        """Write down something that was measured before the search, such as the cost model."""
        self.facts[name] = value
        self._write({"fact": name, "value": value})

    def add(self, entry: Entry) -> None:
        """Store the trial of a genotype."""
        self.entries[entry.genotype] = entry
        trial = entry.trial
        self._write(
            {
                "genotype": list(entry.genotype),
                "generation": entry.generation,
                "n": len(trial),
                "right": np.packbits(trial.right).tobytes().hex(),
                "cost": trial.cost.tolist(),
                "cpu": round(trial.cpu, 3),
                **({"reason": trial.reason} if trial.reason else {}),
            }
        )

    def end(self, end: GenerationEnd) -> None:
        """Write down that a generation is finished."""
        self.ends.append(end)
        self._write({"end": end.number, "asked": end.asked, "median": end.median, "wall": end.wall})

    def _write(self, line: Mapping[str, Any]) -> None:
        if self._path.name == _KEPT:
            raise TuningError(f"{self._path}: is kept to be read; unpack it (xz -d) to go on")
        if self._cut is not None:
            os.truncate(not_a_link(self._path), self._cut)
            self._cut = None
        begin = [] if self._begun else [json.dumps({"search": self._identity})]
        self._begun = True
        with not_a_link(self._path).open("a", encoding="utf-8") as file:
            checked = json.dumps({**line, _SUM: checksum(json.dumps(line).encode())})
            file.writelines(text + "\n" for text in (*begin, checked))

    def _read(self, identity: dict[str, Any]) -> bool:
        """Take in the file; returns whether it held a whole line."""
        content = _content(self._path)
        end = content.rfind(b"\n") + 1
        if end < len(content):  # the line in writing when the search was interrupted
            self._cut = end
        if not end:
            return False
        texts = content[:end].splitlines()
        found = _identity(texts[0], self._path)
        if found != identity:
            differs = differing(found, identity)
            raise TuningError(
                f"{self._path}: holds another search ({differs} differ); choose another "
                "folder, or remove it"
            )
        for number, text in enumerate(texts[1:], 2):
            line = _parse(text, self._path, number)
            told = line.pop(_SUM, None)  # of lines of earlier versions none is known
            if told not in (None, checksum(json.dumps(line).encode())):
                raise _damaged(self._path, number)
            try:
                self._take(line)
            except (KeyError, TypeError, ValueError, OverflowError):
                raise _damaged(self._path, number) from None
        return True

    def _take(self, line: Mapping[str, Any]) -> None:
        if "fact" in line:
            self.facts[line["fact"]] = line["value"]
        elif "end" in line:
            self.ends.append(
                GenerationEnd(line["end"], line["asked"], line["median"], line["wall"])
            )
        else:
            entry = _entry(line)
            self.entries[entry.genotype] = entry


def _path(directory: Path) -> Path:
    """The file of a search: the one that is written to, before the one that is kept."""
    kept = directory / _KEPT
    return kept if kept.exists() and not (directory / _FILE).exists() else directory / _FILE


def _content(path: Path) -> bytes:
    content = content_of(path, MAX_STORED_BYTES)
    try:
        return unpacked(content, MAX_STORED_BYTES) if path.name == _KEPT else content
    except ValueError:
        raise _damaged(path) from None


def _parse(line: bytes, path: Path, number: int = 1) -> dict[str, Any]:
    try:
        return dict(json.loads(line))
    except (TypeError, ValueError, RecursionError):
        raise _damaged(path, number) from None


def _identity(first: bytes, path: Path) -> dict[str, Any]:
    found = _parse(first, path).get("search")
    if not isinstance(found, dict):
        raise TuningError(f"{path}: is not the file of a search")
    return found


def _damaged(path: Path, number: int = 1) -> TuningError:
    kept = f", or its lines from {number} on to go on from there" if number > 1 else ""
    return TuningError(f"{path}: is damaged; remove it to start anew{kept}")


def _entry(line: Mapping[str, Any]) -> Entry:
    bits = np.frombuffer(bytes.fromhex(line["right"]), dtype=np.uint8)
    right = np.unpackbits(bits, count=line["n"]).astype(bool)
    trial = TrialResult(right, np.array(line["cost"]), line["cpu"], line.get("reason", ""))
    return Entry(tuple(line["genotype"]), line["generation"], trial)
