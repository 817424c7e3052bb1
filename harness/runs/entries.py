"""Layouts that were read and checked once, handed out in turn from a temporary file."""

from __future__ import annotations

import os
import pickle
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Generic, Self, TypeVar, Unpack

from steadyload.layouts.files.record import Refused
from steadyload.layouts.files.refusals import Refusals
from steadyload.layouts.files.sources import source_name
from steadyload.layouts.formats import Reading, scan_layouts
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.layout import Layout
from steadyload.reading import naming

Entry = tuple[str, Layout | Refused]
"""The name of a file, and a layout of it."""

One = TypeVar("One", bound=Layout | Refused)

_IN_MEMORY = 8 * 1024**2
"""Bytes up to which there is no file."""

_ITEMS = 500
"""Items of the layouts that are written and read at a time, as one block or as one layout more."""

_PREFIX = 8
"""Bytes that tell the length of a block."""


def scan_entries(
    files: Sequence[str | Path],
    *,
    limit: int | None = None,
    strict: bool = False,
    **reading: Unpack[Reading],
) -> Iterator[Entry]:
    """The layouts of some files, as they are read.

    Args:
        files: layout files in any known format.
        limit: only the first layouts; files after them are not read.
        strict: end at the first layout that is not valid.
        reading: see :class:`steadyload.layouts.formats.Reading`.

    Raises:
        LayoutError: a file cannot be read as a whole; or a layout is not valid, if ``strict``.
    """
    count = 0
    for file in files:
        for entry in scan_layouts(file, **reading):
            if isinstance(entry, Refused) and strict:
                raise entry.error
            yield source_name(file), entry
            count += 1
            if count == limit:
                return


class Spool(Generic[One]):
    """Layouts in a temporary file, each with a word on it, handed out in turn and in their order.

    They can be iterated again, one iteration at a time, and are not checked again. Leaving its
    ``with`` block removes the file, as does the end of the process.

    Raises:
        OSError: there is no room for temporary files.
    """

    def __init__(self) -> None:
        self._count, self._items = 0, 0
        self._block: list[tuple[str, One]] = []
        self._file = tempfile.SpooledTemporaryFile(_IN_MEMORY)  # noqa: SIM115 - left by __exit__

    def add(self, word: str, one: One) -> None:
        """Keep one more; none may be added while they are iterated."""
        self._block.append((word, one))
        self._count += 1
        self._items += len(one) if isinstance(one, Layout) else 1
        if self._items >= _ITEMS:
            self._write()

    def _write(self) -> None:
        content = pickle.dumps(_packed(self._block), pickle.HIGHEST_PROTOCOL)
        self._block, self._items = [], 0
        with naming(tempfile.gettempdir()):
            self._file.seek(0, os.SEEK_END)
            self._file.write(len(content).to_bytes(_PREFIX, "little"))
            self._file.write(content)
            self._file.flush()

    def __len__(self) -> int:
        return self._count

    def __iter__(self) -> Iterator[tuple[str, One]]:
        if self._block:
            self._write()
        self._file.seek(0)
        while prefix := self._file.read(_PREFIX):
            content = self._file.read(int.from_bytes(prefix, "little"))
            places, layouts = pickle.loads(content)  # noqa: S301 - what was written here
            valid = iter(layouts)
            for word, refused in places:
                yield word, next(valid) if refused is None else refused

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        self._file.close()


class Entries(Spool[Layout | Refused]):
    """Entries that are known to be all there are, without being held in memory.

    Making it takes all of the iterable, so that whatever is wrong with a file is raised before the
    first entry is handed out, and a file is read once, be it a pipe or changed meanwhile.

    Args:
        entries: what is kept.

    Attributes:
        refused: the layouts that are not valid.
        sizes: numbers of boxes of the others.

    Raises:
        OSError: there is no room for temporary files.
        Exception: what the iterable raises.
    """

    def __init__(self, entries: Iterable[Entry]) -> None:
        super().__init__()
        self.refused = Refusals()
        self.sizes: set[int] = set()
        try:
            for file, one in entries:
                self.add(file, one)
                if isinstance(one, Refused):
                    self.refused.add(str(one.error))
                else:
                    self.sizes.add(len(one))
            self._write()
        except BaseException:
            self._file.close()
            raise

    @property
    def valid(self) -> int:
        """Number of layouts that can be judged."""
        return len(self) - self.refused.count


def _packed(
    block: Sequence[tuple[str, Layout | Refused]],
) -> tuple[list[tuple[str, Refused | None]], LayoutBatch | list[Layout]]:
    """Entries in parts: word and refusal of each, and the layouts of those that are not refused.

    As a batch layouts take half the time and bytes, but it has no place for the load that an item
    may bear.
    """
    places = [(word, None if isinstance(one, Layout) else one) for word, one in block]
    layouts = [one for _, one in block if isinstance(one, Layout)]
    bearing = any(item.max_load is not None for one in layouts for item in one.items)
    return places, layouts if bearing else LayoutBatch.of(layouts)
