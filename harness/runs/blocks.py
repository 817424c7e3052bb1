"""Blocks of rows that are judged at once: a run's layouts as columns, from their file to its rows.

A study of its own layouts, as they are given, by methods that judge batches needs no object a
layout. Its run folder holds the layouts as one Parquet file, in which a row group is a block. A
unit of work is a block, which the worker reads by itself, and its result are the bytes of a shard.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from steadyload.atomic import without_link, write_atomically
from steadyload.layouts.batch_files import in_batches
from steadyload.layouts.files.parquet_layouts import (
    parquet_of,
    rows_of,
    written_batch,
)
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.parquet_reader import layouts_of, written_group
from steadyload.methods.contract.method import STABLE, Method, Verdict, judge, verdict_of
from steadyload.runs.definition import AS_GIVEN, StudyDefinition
from steadyload.runs.methods_here import method_named
from steadyload.runs.pool import Executor, PartLimit, SinglePart
from steadyload.runs.results import OF_VERDICTS, SCHEMA, said_of, shard_of
from steadyload.runs.store import Codec, Store, lost_part
from steadyload.runs.units import MadeBy, Unit, check_made_by, verdicts_key

Loads = Sequence[Sequence[float | None]]
"""Of each layout the loads that its items may bear, as :func:`rows_of` takes them."""

BLOCK_LAYOUTS, BLOCK_ITEMS = 20_000, 250_000
"""Most layouts and boxes of a block, which has one layout or more."""


@dataclass(frozen=True, slots=True)
class Block:
    """Layouts of a study that are judged at once.

    Attributes:
        batch: the layouts.
        loads: that their items may bear.
        fingerprint: of the layouts and their names.
    """

    batch: LayoutBatch
    loads: Loads
    fingerprint: str


def blocks_of(entries: Iterable[LayoutBatch | Layout]) -> Iterator[Block]:
    """The layouts of a study in blocks, which depend on the layouts alone, not on their files."""
    waiting: list[LayoutBatch] = []
    loads: list[Sequence[float | None]] = []
    count = items = 0
    for batch, singles in in_batches(entries):
        waiting.append(batch)
        loads += [layout.max_loads for layout in singles] or [()] * len(batch)
        count, items = count + len(batch), items + len(batch.weights)
        if count >= BLOCK_LAYOUTS or items > BLOCK_ITEMS:
            joined, start = LayoutBatch.joined(waiting), 0
            while (end := _block_end(joined, start)) is not None:
                yield _block(joined[start:end], loads[start:end])
                start = end
            waiting, loads = [joined[start:]], loads[start:]
            count, items = len(waiting[0]), len(waiting[0].weights)
    if count:
        yield _block(LayoutBatch.joined(waiting), loads)


def _block_end(batch: LayoutBatch, start: int) -> int | None:
    """The layout after a block that begins at one; None where more may follow that belong to it.

    A block has one layout or more.
    """
    most = int(np.searchsorted(batch.starts, batch.starts[start] + BLOCK_ITEMS, "right")) - 1
    end = max(start + 1, min(start + BLOCK_LAYOUTS, most))
    return end if end < len(batch) or end == start + BLOCK_LAYOUTS else None


def _block(batch: LayoutBatch, loads: Loads) -> Block:
    return Block(batch, loads if any(loads) else (), batch.fingerprint())


@dataclass(frozen=True, slots=True)
class BlockUnit(SinglePart):
    """A unit of work: one method on a block of a run's layouts.

    Attributes:
        method: its spec.
        layouts: the file of the layouts of the run, or the rows themselves for a worker that cannot
            read it.
        group: the row group of the block in that file.
        count: number of its layouts.
        repetitions: of every judgement.
    """

    method: str
    layouts: Path | bytes
    group: int
    count: int
    repetitions: int
    key: str
    made_by: MadeBy
    timeout: float | None = None

    def describe(self, part: int) -> str:
        """Description for messages."""
        return f"{self.method} on {self.count:,} layouts (block {self.group})"


def judged_in_blocks(study: StudyDefinition) -> tuple[str, ...]:
    """The methods of a study that judge its layouts a block at a time.

    Units of a study that states their size have that size, whatever the method.
    """
    as_given = study.benchmark is None and not study.scenarios and study.max_items is None
    if not as_given or study.shard_size is not None:
        return ()
    return tuple(str(m) for m in study.made if m.batched and not m.spec.engine)


def block_unit(
    study: StudyDefinition, method: str, made: MadeBy, copy: Path, group: int, block: Block
) -> BlockUnit:
    """The unit of a method on a block.

    Args:
        study: the definition of the study.
        method: its spec.
        made: all that its rows depend on.
        copy: the file of the layouts of the run.
        group: the row group of the block in that file.
        block: the layouts.
    """
    key = verdicts_key(study, method, made, block.fingerprint)
    return BlockUnit(
        method, copy, group, len(block.batch), study.repetitions, key, made, study.timeout
    )


def handed_out(units: Iterable[BlockUnit], workers: int | Executor) -> Iterator[BlockUnit]:
    """Units as they are sent to workers: those that cannot read the file are sent the rows."""
    shares = isinstance(workers, int) or workers.shares_files
    return (unit if shares else replace(unit, layouts=_sent(_rows(unit))) for unit in units)


def _sent(rows: pa.RecordBatch) -> bytes:
    """Rows as they are sent: a fraction of the bytes."""
    sink, packed = pa.BufferOutputStream(), pa.ipc.IpcWriteOptions(compression="lz4")
    with pa.ipc.new_stream(sink, rows.schema, options=packed) as stream:
        stream.write_batch(rows)
    return bytes(sink.getvalue())


def _rows(unit: BlockUnit) -> pa.RecordBatch:
    if isinstance(unit.layouts, bytes):
        with pa.ipc.open_stream(unit.layouts) as stream:
            return stream.read_next_batch()
    return written_group(_opened(unit.layouts, unit.layouts.stat().st_mtime_ns), unit.group)


@lru_cache(maxsize=1)
def _opened(path: Path, changed: int) -> pq.ParquetFile:  # noqa: ARG001 - a new file is opened
    """A file of layouts, whose footer, long where there are many blocks, is read but once."""
    return pq.ParquetFile(path)


def judge_block(unit: BlockUnit) -> Iterator[bytes]:
    """Prepare a unit's method, then judge the block: the bytes of its shard, as one result.

    Raises:
        OtherCodeError: the versions of parts or packages here are not those that the unit states.
    """
    check_made_by(unit.method, unit.made_by)
    method = method_named(unit.method)
    batch = written_batch(_rows(unit))
    method.prepare(int(batch.item_counts.max()))
    return _shards(method, batch, unit)


def _shards(method: Method, batch: LayoutBatch, unit: BlockUnit) -> Iterator[bytes]:
    _judged(method, batch[:1], unit.timeout)  # no time that is reported holds what comes but once
    yield _shard(method, batch, unit)


@dataclass(frozen=True, slots=True)
class _Verdicts:
    """Verdicts on a block: the usual one, and others by the place of the layout."""

    usual: Verdict
    apart: Mapping[int, Verdict]


def _judged(method: Method, batch: LayoutBatch, timeout: float | None) -> _Verdicts:
    try:
        found = method.findings(batch, timeout=timeout)
    except Exception:  # one layout of it, which then has a row that says so
        alone = {k: judge(method, layout, timeout) for k, layout in enumerate(batch)}
        return _Verdicts(Verdict(1), alone)
    counts, seconds = batch.item_counts.tolist(), (found.cpu, found.wall)
    apart = {k: verdict_of(each, counts[k], *seconds) for k, each in found.apart.items()}
    return _Verdicts(verdict_of(STABLE, 1, *seconds), apart)


def _shard(method: Method, batch: LayoutBatch, unit: BlockUnit) -> bytes:
    hashes = batch.content_hashes()
    tables = [
        _table(method, batch, hashes, repetition, _judged(method, batch, unit.timeout))
        for repetition in range(unit.repetitions)
    ]
    return shard_of(pa.concat_tables(tables))


def _table(
    method: Method, batch: LayoutBatch, hashes: Sequence[str], repetition: int, found: _Verdicts
) -> pa.Table:
    """The rows of :func:`steadyload.runs.results.result_row`, by columns."""
    of_layouts = {"layout": batch.names, "layout_hash": hashes, "item_count": batch.item_counts}
    same = {"scenario": AS_GIVEN, "repetition": repetition, **said_of(method)}
    places, apart = list(found.apart), list(found.apart.values())

    def values(field: pa.Field) -> pa.Array:
        name = field.name
        if name in of_layouts:
            return pa.array(of_layouts[name], field.type)
        if name in same:
            return pa.repeat(pa.scalar(same[name], field.type), len(batch))
        of, usual = list(map(OF_VERDICTS[name], apart)), OF_VERDICTS[name](found.usual)
        if of.count(usual) == len(of):
            return pa.repeat(pa.scalar(usual, field.type), len(batch))
        column = [usual] * len(batch)
        for k, value in zip(places, of, strict=True):
            column[k] = value
        return pa.array(column, field.type)

    return pa.Table.from_arrays(list(map(values, SCHEMA)), schema=SCHEMA)


def _content(answers: Sequence[bytes]) -> bytes:
    [content] = answers
    return content


class BlockStore(Store[bytes, bytes]):
    """Shards of a run folder that come as bytes; its parts are rows."""

    def __init__(self, directory: Path) -> None:
        super().__init__(directory / "results", Codec(".parquet", _content, bytes))

    def parts_of(self, unit: BlockUnit) -> int:
        """The number of rows of a shard."""
        return unit.count * unit.repetitions


def judging_blocks(limit: PartLimit[Any, Any] | None, again: list[Unit]) -> dict[str, Any]:
    """Arguments of :meth:`Store.complete` for blocks.

    Args:
        limit: hard limit of a judgement, which is that of a block, too.
        again: takes the judgements of a block that ended its process, or took longer, one by one:
            one of them that does costs its row alone.
    """
    return {
        "work": judge_block,
        "lost": lambda unit, reason: again.append(_by_row(unit)),
        "limit": None if limit is None else PartLimit(limit.seconds, lost_part),
    }


def _by_row(unit: BlockUnit) -> Unit:
    layouts = list(layouts_of(_rows(unit)))
    judgements = tuple(
        (repetition, AS_GIVEN, layout)
        for repetition in range(unit.repetitions)
        for layout in layouts
    )
    return Unit(unit.method, judgements, unit.key, unit.made_by, unit.timeout)


def write_copy(path: Path, blocks: Iterable[Block]) -> None:
    """Write a run's copy of its layouts: Parquet with a row group a block, or steadyload JSON.

    Args:
        path: of the copy; its ending says in which format.
        blocks: the layouts, which are asked for in turn.
    """
    groups = (rows_of(block.batch, block.loads) for block in blocks)
    path = without_link(path)
    if path.suffix == ".parquet":
        write_atomically(path, parquet_of(groups))
    else:
        write_layouts(path, chain.from_iterable(map(layouts_of, groups)), Format.NATIVE)
