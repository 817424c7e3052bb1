"""Layout files: one reader per format, picked by the file's content; writers for four of them.

Every reader turns its file into plain records (name, pallet, items as mappings of named values) and
one function turns records into validated layouts, so that all formats complain alike. The formats
are described in ``docs/layouts.md``, the native one also in ``docs/layouts.schema.json``.
"""

from __future__ import annotations

import io
import logging
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from dataclasses import replace
from enum import StrEnum
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any, BinaryIO, TypedDict, Unpack

from steadyload.atomic import write_atomically
from steadyload.errors import WrongTypeError, nearest, required
from steadyload.escaping import shown
from steadyload.layouts.files.csv_reader import is_csv, read_csv
from steadyload.layouts.files.dialect import Dialect
from steadyload.layouts.files.limits import MAX_FILE_BYTES, MAX_VALUE_LENGTH, MAX_YAML_BYTES
from steadyload.layouts.files.parquet_footer import is_parquet
from steadyload.layouts.files.record import FormatError, Record, Refused, to_layout
from steadyload.layouts.files.sources import (
    Content,
    File,
    Source,
    decoded,
    opened_source,
    read_rest,
    seekable,
    source_name,
    source_of,
)
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.distinct_names import DistinctNames
from steadyload.layouts.model.floor import FloorKind
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import Layout, LayoutError
from steadyload.layouts.model.plausibility import implausible, implausible_among
from steadyload.layouts.model.snapping import snap
from steadyload.layouts.packers.with_packingsolver import HEADER, read_certificate
from steadyload.layouts.readers import read_aclpp, read_blocks, read_json
from steadyload.layouts.writers import as_csv, as_job, as_native
from steadyload.numbers import number_within
from steadyload.reading import MAX_COPY_BYTES, lines_of, regular

_log = logging.getLogger("steadyload")

_TWICE = "name stands there twice; allowed: one layout a name"
HEAD_BYTES = 64 * 1024
"""Bytes of a file by which its format is told."""

_CHUNK_BYTES = 256 * 1024

_OTHERS = {
    b"\x1f\x8b": "compressed (gzip)",
    b"PK\x03\x04": "a spreadsheet (.xlsx) or another ZIP file",
    b"\xff\xfe": "no text in UTF-8 but in UTF-16",
    b"\xfe\xff": "no text in UTF-8 but in UTF-16",
}
"""What files are often given instead, by their first bytes."""

_PLAIN = Dialect()


class Format(StrEnum):
    """The file formats."""

    NATIVE = "native"
    CSV = "csv"
    JOB = "job"
    ACLPP = "aclpp"
    PACKINGSOLVER = "packingsolver"
    PARQUET = "parquet"


class Reading(TypedDict, total=False):
    """Choices in reading layouts, each of which may be left out.

    Attributes:
        dialect: units, axes, positions and columns of CSV files, which all files then are; None for
            those of ours.
        snap_gap: close vertical gaps up to this [cm], see :func:`snap`; 0 closes none.
        overhang: how far items may stand out over the edges of the deck [cm]; None for what a file
            states, or else 10.
        floor: ``auto``, ``deck`` or ``infinite``, see :class:`FloorKind`; None for what a file
            states, or else ``auto``.
    """

    dialect: Dialect | None
    snap_gap: float
    overhang: float | None
    floor: FloorKind | str | None


def resolved(reading: Reading) -> tuple[Dialect, dict[str, Any], float]:
    """The choices in reading: the dialect, what is stated of all decks, and the gap to close [cm].

    Raises:
        WrongTypeError: there is no such choice, or the dialect is none.
        FloorError: there is no such floor.
        NumberError: the gap is no finite number, 0 or more.
    """
    for key in reading:
        if key not in Reading.__annotations__:
            raise WrongTypeError(
                f"unknown argument {shown(key)}; {nearest(key, Reading.__annotations__)}"
            )
    dialect, floor = reading.get("dialect"), reading.get("floor")
    if dialect is not None:
        required(
            "dialect",
            dialect,
            Dialect,
            "a Dialect, as steadyload.load_profile(file) gives, or None",
        )
    stated = {
        "overhang": reading.get("overhang"),
        "floor": None if floor is None else FloorKind.named(floor),
    }
    gap = reading.get("snap_gap")
    return (
        dialect or _PLAIN,
        {key: value for key, value in stated.items() if value is not None},
        number_within("snap_gap", 0.0 if gap is None else gap, 0.0, unit="[cm]"),
    )


def read_layouts(path: File, **reading: Unpack[Reading]) -> list[Layout]:
    """All layouts of a file.

    Args:
        path: a file in any of the formats of :class:`Format`; ``-`` for standard input. Or its
            content: bytes, or a file that is open to be read as bytes.
        reading: see :class:`Reading`.

    Raises:
        WrongTypeError: ``path`` or a choice in reading is of another type.
        LayoutError: the file is in no known format, is cut off, or holds an invalid layout.
        FloorError: there is no such floor.
        NumberError: the gap is no finite number, 0 or more.
        MissingFileError: there is no such file.
        FolderError: it is a folder.
        OSError: the file cannot be read.
    """
    layouts = []
    for entry in scan_layouts(path, **reading):
        if isinstance(entry, Refused):
            raise entry.error
        layouts.append(entry)
    return layouts


def scan_layouts(path: File, **reading: Unpack[Reading]) -> Iterator[Layout | Refused]:
    """Like :func:`read_layouts`, but an invalid layout is handed out instead of raised.

    The first layout whose units were probably read wrong is told as a warning of the logger
    ``steadyload``, which the command line prints; see :func:`implausible`.
    """
    for entry in scan_batches(path, **reading):
        yield from entry if isinstance(entry, LayoutBatch) else (entry,)


def scan_batches(
    path: File, **reading: Unpack[Reading]
) -> Iterator[LayoutBatch | Layout | Refused]:
    """Like :func:`scan_layouts`, but layouts that become arrays at once come as batches."""
    source = source_of(path)
    file, (dialect, deck, snap_gap) = source_name(source), resolved(reading)
    frame = Frame.of(dialect)
    names = DistinctNames()
    doubt, tried = "", False

    def doubted(told: str) -> str:
        if told:
            _log.warning("%s: %s", file, told)
        return told

    try:
        for record in _entries(source, dialect, deck):
            own = record.names if isinstance(record, LayoutBatch) else (record.name,)
            if (again := names.add(own)) is not None:
                raise FormatError(_TWICE, layout=again)
            if isinstance(record, LayoutBatch):
                doubt = doubt or doubted(implausible_among(record))
                yield from (snap(each, snap_gap) for each in record) if snap_gap else (record,)
                continue
            try:
                if isinstance(record, Refused):
                    raise record.error
                layout = to_layout(record, **deck)
                doubt = doubt or doubted(implausible(layout, frame))
                yield snap(layout, snap_gap) if snap_gap > 0.0 else layout
            except LayoutError as error:
                if not tried and isinstance(record, Record):
                    tried = True
                    if _is_valid_with_z_up(source, dialect, deck, record.name):
                        error = error.adding("; did you mean --up z?")
                told = error.framed(frame).located(file=file, layout=record.name)
                yield Refused(record.name, told)
        if not names:
            raise FormatError("holds no layouts; allowed: one or more")
    except LayoutError as error:
        raise error.located(file=file) from None


def _is_valid_with_z_up(
    source: Source, dialect: Dialect, deck: Mapping[str, Any], name: str
) -> bool:
    """Whether a layout that is not valid in a CSV file would be so if z pointed up there."""
    if dialect.up != "y" or not (isinstance(source, Content) or Path(source).is_file()):
        return False  # it can be read only once
    try:
        with opened_source(source) as file:
            for record in records_of(file, replace(dialect, up="z"), None):
                if record.name == name:
                    return isinstance(record, Record) and len(to_layout(record, **deck)) > 0
    except LayoutError:  # no CSV file, or not valid so, either
        pass
    return False


def detect_format(head: str, dialect: Dialect | None = None) -> Format | None:
    """The format of a text that begins with ``head``; JSON formats differ only when parsed.

    Returns :attr:`Format.NATIVE` for any JSON object.
    """
    text = head.lstrip("\ufeff \t\r\n")
    if text.startswith("{"):
        return Format.NATIVE
    if text.startswith(HEADER):
        return Format.PACKINGSOLVER
    lines = (line.rstrip() for line in text.splitlines())
    first = next((line for line in lines if line and line != "---" and line[0] != "#"), "")
    if first in ("flights:", "segments:"):
        return Format.ACLPP
    return Format.CSV if is_csv(first, dialect or _PLAIN) else None


def _other(head: bytes) -> str:
    """The kind, in words, of a file that is in no format of ours."""
    told = (kind for start, kind in _OTHERS.items() if head.startswith(start))
    return next(told, "in no known format")


def _entries(
    source: Source, dialect: Dialect, deck: Mapping[str, Any]
) -> Iterator[LayoutBatch | Record | Refused]:
    """Contents of a file, checked where its format is checked many layouts at a time."""
    with opened_source(source) as file:
        head = file.read(HEAD_BYTES)
        if is_parquet(head):  # pyarrow takes longer to import than all other formats
            from steadyload.layouts.parquet_reader import read_parquet

            _refuse_dialect(dialect)
            yield from read_parquet(seekable(file, head), deck)
        else:
            yield from _records(head, file, dialect, source_name(source))


def records_of(file: BinaryIO, dialect: Dialect, name: str | None) -> Iterator[Record | Refused]:
    """Records of an open file, in the order of the file.

    Args:
        file: it.
        dialect: of CSV files.
        name: of the file, for warnings; None for no warnings.

    Raises:
        FormatError: the file is in no known format, or is cut off.
    """
    yield from _records(file.read(HEAD_BYTES), file, dialect, name)


def _records(
    head: bytes, file: BinaryIO, dialect: Dialect, name: str | None
) -> Iterator[Record | Refused]:
    text = head.decode("utf-8", errors="replace")
    kind = detect_format(text, dialect) if b"\0" not in head else None
    if not head:
        raise FormatError("is empty")
    if kind is None:
        raise FormatError(
            f"is {_other(head)}; allowed: steadyload JSON, CSV with a header line (columns "
            "of your own are named with --columns or in a profile), job JSON with 'ulds', "
            "ACLPP schedule YAML, a certificate of PackingSolver, JSON of Packvium, Parquet with "
            "a row a layout"
        )
    if kind not in (Format.CSV, Format.PACKINGSOLVER):
        _refuse_dialect(dialect)
    if kind is Format.NATIVE:
        yield from read_json(chain([head], iter(partial(file.read, _CHUNK_BYTES), b"")))
        return
    cap = MAX_YAML_BYTES if kind is Format.ACLPP else MAX_FILE_BYTES
    content = read_rest(file, head, cap)
    if kind is Format.CSV:
        yield from read_csv(content, dialect, name)
        return
    text = decoded(content).removeprefix("\ufeff").replace("\r\n", "\n")
    del content
    if kind is Format.PACKINGSOLVER:
        yield from read_certificate(text, dialect)
    else:
        yield from read_aclpp(text)


def _refuse_dialect(dialect: Dialect) -> None:
    if dialect.stated():
        raise FormatError(
            f"is no CSV file; {' and '.join(dialect.stated())} can be stated of CSV files "
            "only, and units of certificates of PackingSolver, since other formats have units "
            "and axes of their own"
        )


def write_layouts(path: str | Path, layouts: Iterable[Layout], kind: Format) -> None:
    """Write layouts to one file, whole or not at all. Reading it back gives equal layouts.

    Those of a native file are asked for one by one, those of a Parquet file in groups.

    Raises:
        FormatError: two layouts have the same name; or a pallet has more than a size, for which
            native and Parquet files alone have a place; or ``kind`` is one that is only read, such
            as ACLPP YAML, which has no place for pallet sizes and centres of mass.
        OSError: the file cannot be written.
    """
    if kind not in _WRITERS:
        raise FormatError(f"cannot be written as {kind}; allowed: {', '.join(_WRITERS)}")
    write_atomically(Path(path), _WRITERS[kind](_each_once(layouts)), follow=True)


def _each_once(layouts: Iterable[Layout]) -> Iterator[Layout]:
    names: set[str] = set()
    for layout in layouts:
        if layout.name in names:
            raise FormatError(
                "two of the layouts to write have this name; allowed: each once", layout=layout.name
            )
        names.add(layout.name)
        yield layout


def read_written(path: str | Path, names: Container[str] | None = None) -> Iterator[Layout]:
    """The layouts of a native or Parquet file as :func:`write_layouts` leaves it, in turn.

    Args:
        path: the file, however large; other native files may stand in other lines, and are not
            read.
        names: those wanted; None for all.

    Raises:
        LayoutError: the file is no such file, is cut off, or holds an invalid layout.
        TooLargeError: it has too many bytes, or a line has.
        OSError: the file cannot be read.
    """
    try:
        with regular(Path(path), MAX_COPY_BYTES) as content:
            head = content.read(HEAD_BYTES)
            content.seek(0)
            if is_parquet(head):
                yield from _written_rows(content, names)
                return
            with io.TextIOWrapper(content, encoding="utf-8") as file:
                for record in read_blocks(lines_of(file, Path(path), MAX_VALUE_LENGTH)):
                    if names is None or record.name in names:
                        yield to_layout(record)
    except UnicodeDecodeError:
        raise FormatError("is not UTF-8 text; is it damaged?", file=str(path)) from None
    except LayoutError as error:
        raise error.located(file=str(path)) from None


def _written_rows(file: BinaryIO, names: Container[str] | None) -> Iterator[Layout]:
    from steadyload.layouts.parquet_reader import layouts_of, written_groups

    for rows in written_groups(file):
        for layout in layouts_of(rows):
            if names is None or layout.name in names:
                yield layout


def _as_parquet(layouts: Iterable[Layout]) -> Iterator[bytes]:
    from steadyload.layouts.files.parquet_layouts import as_parquet

    yield from as_parquet(layouts)


_WRITERS: dict[Format, Callable[[Iterable[Layout]], str | Iterator[str] | Iterator[bytes]]] = {
    Format.NATIVE: as_native,
    Format.CSV: as_csv,
    Format.JOB: as_job,
    Format.PARQUET: _as_parquet,
}
