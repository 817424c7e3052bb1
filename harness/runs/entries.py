"""Layouts that were read and checked once, handed out in turn from a temporary file."""

from __future__ import annotations

import pickle
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from typing import Self, Unpack

from steadyload.layouts.files.record import Refused
from steadyload.layouts.files.refusals import Refusals
from steadyload.layouts.files.sources import Source, source_name
from steadyload.layouts.formats import Reading, scan_layouts
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.layout import Layout
from steadyload.reading import naming

Entry = tuple[str, Layout | Refused]
"""The name of a file, and a layout of it."""

_IN_MEMORY = 8 * 1024**2
"""Bytes up to which there is no file."""

_ITEMS = 500
"""Items of the layouts that are written and read at a time, as one block or as one layout more."""

_PREFIX = 8
"""Bytes that tell the length of a block."""


def scan_entries(
    files: Sequence[Source],
    *,
    limit: int | None = None,
    strict: bool = False,
    **reading: Unpack[Reading],
) -> Iterator[Entry]:
    """The layouts of some files, as they are read.

    Args:
        files: layout files in any known format, or the contents of such.
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


class Entries:
    """Entries that are known to be all there are, in a temporary file, handed out in their order.

    Making it takes all of the iterable, so that whatever is wrong with a file is raised before the
    first entry is handed out, and a file is read once, be it a pipe or changed meanwhile. Entries
    can be iterated again, one iteration at a time, and are not checked again. Leaving its ``with``
    block removes the file, as does the end of the process.

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
        self.refused = Refusals()
        self.sizes: set[int] = set()
        self._count = 0
        self._file = tempfile.SpooledTemporaryFile(_IN_MEMORY)  # noqa: SIM115 - left by __exit__
        try:
            for block in self._blocks(entries):
                content = pickle.dumps(_packed(block), pickle.HIGHEST_PROTOCOL)
                with naming(tempfile.gettempdir()):
                    self._file.write(len(content).to_bytes(_PREFIX, "little"))
                    self._file.write(content)
                    self._file.flush()
        except BaseException:
            self._file.close()
            raise

    def _blocks(self, entries: Iterable[Entry]) -> Iterator[list[Entry]]:
        block: list[Entry] = []
        items = 0
        for file, one in entries:
            block.append((file, one))
            self._count += 1
            if isinstance(one, Refused):
                self.refused.add(str(one.error))
                items += 1
            else:
                self.sizes.add(len(one))
                items += len(one)
            if items >= _ITEMS:
                yield block
                block, items = [], 0
        if block:
            yield block

    @property
    def valid(self) -> int:
        """Number of layouts that can be judged."""
        return self._count - self.refused.count

    def __len__(self) -> int:
        return self._count

    def __iter__(self) -> Iterator[Entry]:
        self._file.seek(0)
        while prefix := self._file.read(_PREFIX):
            content = self._file.read(int.from_bytes(prefix, "little"))
            files, layouts = pickle.loads(content)  # noqa: S301 - what was written here
            valid = iter(layouts)
            for file, refused in files:
                yield file, next(valid) if refused is None else refused

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        self._file.close()


def _packed(
    block: Sequence[Entry],
) -> tuple[list[tuple[str, Refused | None]], LayoutBatch | list[Layout]]:
    """Entries in parts: file and refusal of each, and the layouts of those that are not refused.

    As a batch layouts take half the time and bytes, but it has no place for the load that an item
    may bear.
    """
    files = [(file, one if isinstance(one, Refused) else None) for file, one in block]
    layouts = [one for _, one in block if isinstance(one, Layout)]
    bearing = any(item.max_load is not None for one in layouts for item in one.items)
    return files, layouts if bearing else LayoutBatch.of(layouts)
