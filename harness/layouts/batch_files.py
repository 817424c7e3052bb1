"""Layout files as batches."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Unpack

from steadyload.layouts.files.csv_batch import batch_of_csv
from steadyload.layouts.files.limits import MAX_FILE_BYTES
from steadyload.layouts.files.record import FormatError, Refused
from steadyload.layouts.files.sources import (
    STANDARD_INPUT,
    Content,
    File,
    Source,
    opened_source,
    read_rest,
    source_name,
    source_of,
)
from steadyload.layouts.formats import (
    HEAD_BYTES,
    Format,
    Reading,
    detect_format,
    resolved,
    scan_batches,
)
from steadyload.layouts.json_batch import batch_of_json
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.plausibility import implausible_among

_log = logging.getLogger("steadyload")

_BLOCK_BYTES = 64 * 1024
"""Bytes of a JSON file that are parsed at a time: objects of more leave a processor's caches."""

_ITEMS = 500
"""Items of layouts that are held as objects, or those of one layout more."""


def read_batch(path: File, **reading: Unpack[Reading]) -> LayoutBatch:
    """All layouts of a file as arrays: those of :func:`read_layouts`, to the last bit.

    Three kinds of files become arrays without an object an item: CSV in centimetres and kilograms,
    with y up, corners as positions, a decimal point and no quotes; steadyload JSON that states
    its format and version first, and the same of all boxes; and Parquet that states no loads that
    boxes may bear. Every other file, one that is not valid, and one of which gaps are to be closed,
    costs what :func:`read_layouts` costs.

    Args:
        path: see :func:`read_layouts`.
        reading: see :class:`Reading`.

    Raises:
        LayoutError: as :func:`read_layouts` does.
        FloorError: likewise.
        OSError: the file cannot be read.
    """
    source = source_of(path)
    found = plain_batch(source, reading)
    if found is None:
        return LayoutBatch.joined(list(_batches(source, reading)))
    if doubt := implausible_among(found):
        _log.warning("%s: %s", source_name(source), doubt)
    return found


def _batches(source: Source, reading: Reading) -> Iterator[LayoutBatch]:
    def valid() -> Iterator[LayoutBatch | Layout]:
        for entry in scan_batches(source, **reading):
            if isinstance(entry, Refused):
                raise entry.error
            yield entry

    return (batch for batch, _ in in_batches(valid()))


def in_batches(
    entries: Iterable[LayoutBatch | Layout],
) -> Iterator[tuple[LayoutBatch, Sequence[Layout]]]:
    """The same layouts as batches, each with the layouts that it was made of: none for one given.

    Args:
        entries: layouts, of which some come as batches.
    """
    singles: list[Layout] = []
    items = 0
    for entry in entries:
        if isinstance(entry, Layout):
            singles.append(entry)
            items += len(entry)
        if singles and (items >= _ITEMS or isinstance(entry, LayoutBatch)):
            yield LayoutBatch.of(singles), singles
            singles, items = [], 0
        if isinstance(entry, LayoutBatch):
            yield entry, ()
    if singles:
        yield LayoutBatch.of(singles), singles


def plain_batch(source: Source, reading: Reading) -> LayoutBatch | None:
    """The batch of a file of which :func:`read_batch` makes no object an item; None for others."""
    dialect, deck, gap = resolved(reading)
    if gap:
        return None
    if not isinstance(source, Content) and (
        not Path(source).is_file() or str(source) == STANDARD_INPUT
    ):  # it can be read only once
        return None
    with opened_source(source) as file:
        head = file.read(HEAD_BYTES)
        kind = detect_format(head.decode("utf-8", errors="replace"), dialect)
        if kind is Format.NATIVE and not dialect.stated():
            return batch_of_json(chain([head], iter(partial(file.read, _BLOCK_BYTES), b"")), deck)
        if kind is not Format.CSV:
            return None
        try:
            content = read_rest(file, head, MAX_FILE_BYTES)
        except FormatError:
            return None
    return batch_of_csv(content, dialect, deck, source_name(source))
