"""Files of recorded motion, Parquet or CSV: one row for each frame. See ``docs/measured.md``."""

from __future__ import annotations

import csv
import io
from array import array
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from steadyload.atomic import write_atomically
from steadyload.errors import nearest
from steadyload.escaping import printable, shown
from steadyload.layouts.files.csv_cells import harmless, unguarded
from steadyload.layouts.files.parquet_footer import is_parquet
from steadyload.layouts.files.parquet_table import TableTooLargeError, is_text, table_of
from steadyload.measured.bodies import Body
from steadyload.measured.csv_rows import csv_rows, number_in, places
from steadyload.measured.errors import MotionError
from steadyload.measured.motion import COLUMNS, FloatArray, Trial
from steadyload.reading import MAX_STORED_BYTES, content_of

REQUIRED = ("trial", "time", *COLUMNS["positions"], *COLUMNS["attitudes"])
"""Columns that every file has."""

OF_BODY = {
    "size": ("size_x", "size_y", "size_z"),
    "mass": ("mass",),
    "inertia": ("inertia_x", "inertia_y", "inertia_z"),
    "friction": ("friction",),
    "restitution": ("restitution",),
}
"""Quantity of a body -> its columns, which are constant in a trial."""

KNOWN = (
    *REQUIRED, *COLUMNS["velocities"], *COLUMNS["spins"],
    *(name for names in OF_BODY.values() for name in names),
)  # fmt: skip
"""All columns, in the order in which they are written."""

MAX_TRIALS, MAX_FRAMES = 100_000, 1_000_000
"""Trials of a file, and frames of all of them: nearly two hours at 148 Hz."""

Given = tuple[FloatArray, NDArray[np.bool_]]
"""Numbers of a column, and whether each is given."""


_OF_OTHER_COLUMNS = "; a profile (--profile) says which columns have other names or are ignored"


def read_motion(
    path: str | Path,
    *,
    columns: Mapping[str, str] | None = None,
    constants: Mapping[str, float] | None = None,
    ignored: Collection[str] = (),
) -> tuple[Trial, ...]:
    """All trials of a file, in the order in which they first appear in it.

    Args:
        path: Parquet, or CSV; which one is seen by its content.
        columns: name of :data:`KNOWN` -> name in this file, where that is another.
        constants: name of a quantity of the body, such as ``mass`` -> its value for all trials,
            where the file has no such column.
        ignored: names of further columns of the file, which are not read.

    Raises:
        MotionError: the file cannot be read, has unknown or missing columns, or holds what is not
            allowed: says in which trial and frame, and what is.
        TooLargeError: it has too many bytes.
        OSError: it cannot be opened.
    """
    named, stated = checked_names(columns or {}, constants or {})
    content = content_of(Path(path), MAX_STORED_BYTES)
    try:
        parse = _of_parquet if is_parquet(content) else _of_csv
        names, values = parse(content, named, ignored)
        del content
        for name, value in stated.items():
            if name in values:
                raise MotionError(
                    f"has a column {name!r}, and a constant of that name; allowed: one of the two"
                )
            values[name] = np.full(len(names), value), np.ones(len(names), dtype=bool)
        for group in (*COLUMNS.values(), *OF_BODY.values()):
            there = [name for name in group if name in values]
            if there and len(there) < len(group):
                missing = next(name for name in group if name not in values)
                raise MotionError(
                    f"has no column {missing!r}, and has {there[0]!r}; allowed: all of "
                    f"{', '.join(group)}, or none"
                )
        return _trials(names, values)
    except MotionError as error:
        raise MotionError(f"{path}: {error}") from None


def checked_names(
    columns: Mapping[str, str], constants: Mapping[str, float]
) -> tuple[dict[str, str], dict[str, float]]:
    """Name in the file -> name of ours; and constants as numbers.

    Raises:
        MotionError: an unknown name, or a constant that is no number.
    """
    for name in columns:
        if name not in KNOWN:
            raise MotionError(f"columns: unknown column {shown(name)}; {nearest(str(name), KNOWN)}")
    allowed = [name for names in OF_BODY.values() for name in names]
    found = {}
    for name, value in constants.items():
        if name not in allowed:
            raise MotionError(
                f"constants: unknown quantity {shown(name)}; {nearest(str(name), allowed)}"
            )
        try:
            found[name] = float(value)
        except (TypeError, ValueError, OverflowError):
            raise MotionError(f"constants: {name} is {shown(value)}; allowed: a number") from None
    return {theirs: ours for ours, theirs in columns.items()}, found


def _places(
    header: Sequence[str], named: Mapping[str, str], ignored: Collection[str]
) -> dict[str, int]:
    """Place of each of our columns in a header of the file's own names."""
    for name in named:
        if name not in header:
            raise MotionError(
                f"has no column {shown(name)}, which columns name; {nearest(name, header)}"
            )
    kept = [(place, name) for place, name in enumerate(header) if name not in ignored]
    ours = [named.get(name, name) for _, name in kept]
    found = places(ours, KNOWN, REQUIRED, MotionError, _OF_OTHER_COLUMNS)
    return {name: kept[place][0] for name, place in found.items()}


def _check_frames(count: int) -> None:
    if count > MAX_FRAMES:
        raise MotionError(f"holds more than {MAX_FRAMES:,} frames; allowed: up to so many")


def _of_csv(
    content: bytes, named: Mapping[str, str], ignored: Collection[str]
) -> tuple[list[str], dict[str, Given]]:
    """Trials and numbers of all rows of a CSV file."""
    opened = csv_rows(content, (*KNOWN, *named, *ignored), MotionError)
    found = _places([name.strip() for name in opened.header], named, ignored)
    own = found.pop("trial")
    names: list[str] = []
    numbers = {name: array("d") for name in found}
    given = {name: bytearray() for name in found}
    for line, row in opened.rows:
        names.append(unguarded(row[own].strip()))
        _check_frames(len(names))
        if not names[-1]:
            raise MotionError(f"line {line} names no trial; allowed: its name in every row")
        for name, place in found.items():
            cell = row[place]
            value = number_in(cell) if cell.strip() else 0.0
            if value is None:
                raise MotionError(f"line {line}: {name} is {shown(cell)}; allowed: a number")
            numbers[name].append(value)
            given[name].append(bool(cell.strip()))
    return names, {
        name: (np.array(numbers[name]), np.frombuffer(given[name], dtype=bool)) for name in found
    }


def _of_parquet(
    content: bytes, named: Mapping[str, str], ignored: Collection[str]
) -> tuple[list[str], dict[str, Given]]:
    """Trials and numbers of all rows of a Parquet file."""
    try:
        found = _places(pq.read_schema(pa.BufferReader(content)).names, named, ignored)
        table = table_of(content)
    except MotionError:
        raise
    except TableTooLargeError as error:
        raise MotionError(str(error)) from None
    except (OSError, ValueError, pa.ArrowException) as error:
        raise MotionError(
            f"is no Parquet file that can be read ({printable(str(error), 200)}); allowed: one, or "
            "CSV"
        ) from None
    _check_frames(table.num_rows)
    trials = table.column(found.pop("trial"))
    if pa.types.is_dictionary(trials.type):
        trials = trials.cast(trials.type.value_type)
    if not (is_text(trials.type) or pa.types.is_integer(trials.type)):
        raise MotionError(f"trial is a column of {trials.type}; allowed: texts or whole numbers")
    try:
        names = ["" if name is None else str(name) for name in trials.to_pylist()]
    except UnicodeDecodeError:
        raise MotionError("trial holds what is no text; allowed: texts in UTF-8") from None
    if "" in names:
        row = names.index("")
        raise MotionError(f"row {row} names no trial; allowed: its name in every row")
    return names, {name: _numbers(name, table.column(place)) for name, place in found.items()}


def _numbers(name: str, column: Any) -> Given:
    if pa.types.is_null(column.type):
        column = column.cast(pa.float64())
    if not (pa.types.is_integer(column.type) or pa.types.is_floating(column.type)):
        raise MotionError(f"{name} is a column of {column.type}; allowed: numbers")
    given = ~np.asarray(column.is_null().to_numpy(), dtype=bool)
    return np.asarray(column.cast(pa.float64(), safe=False).fill_null(0.0).to_numpy()), given


def _trials(names: Sequence[str], values: Mapping[str, Given]) -> tuple[Trial, ...]:
    numbers: dict[str, int] = {}
    rows = np.array([numbers.setdefault(name, len(numbers)) for name in names], dtype=np.intp)
    if not numbers:
        raise MotionError("holds no frames; allowed: one row for each frame of a trial")
    if len(numbers) > MAX_TRIALS:
        raise MotionError(f"holds {len(numbers):,} trials; allowed: up to {MAX_TRIALS:,}")
    order = np.argsort(rows, kind="stable")
    ends = np.cumsum(np.bincount(rows))
    return tuple(
        _trial(name, {key: (v[frames], g[frames]) for key, (v, g) in values.items()})
        for name, frames in zip(numbers, np.split(order, ends[:-1]), strict=True)
    )


def _trial(name: str, values: Mapping[str, Given]) -> Trial:
    for key in REQUIRED[1:]:
        missing = np.flatnonzero(~values[key][1])
        if len(missing):
            raise MotionError(
                f"trial {shown(name)}, frame {missing[0]}: {key} is missing; allowed: a number"
            )
    try:
        body = Body(**{key: _constant(values, group) for key, group in OF_BODY.items()})
    except MotionError as error:
        raise MotionError(f"trial {shown(name)}: {error}") from None
    arrays = {key: _columns(name, values, group) for key, group in COLUMNS.items()}
    return Trial(name, values["time"][0], **arrays, body=body)  # type: ignore[arg-type]


def _columns(name: str, values: Mapping[str, Given], group: Sequence[str]) -> FloatArray | None:
    """Columns of a trial side by side; None where they are not given in any of its frames."""
    if group[0] not in values:
        return None
    given = np.stack([values[key][1] for key in group], axis=1)
    if not given.any():
        return None
    if not given.all():
        frame, place = np.argwhere(~given)[0]
        raise MotionError(
            f"trial {shown(name)}, frame {frame}: {group[place]} is missing; allowed: a number in "
            f"every frame, or {', '.join(group)} in none"
        )
    return np.stack([values[key][0] for key in group], axis=1)


def _constant(values: Mapping[str, Given], group: Sequence[str]) -> Any:
    """A quantity of a body: a number, or three; None where no frame of the trial has it."""
    found = []
    for key in group:
        numbers, given = values.get(key, (np.zeros(1), np.zeros(1, dtype=bool)))
        if not given.any():
            continue
        other = np.flatnonzero(~given | (numbers != numbers[0]))
        if len(other) and not np.isnan(numbers[0]):
            stated = f"{numbers[other[0]]:g}" if given[other[0]] else "missing"
            raise MotionError(
                f"frame {other[0]}: {key} is {stated}, and {numbers[0]:g} in the first; allowed: "
                "one value in a trial"
            )
        found.append(float(numbers[0]))
    if found and len(found) < len(group):
        raise MotionError(f"only some of {', '.join(group)} are given; allowed: all, or none")
    if not found:
        return None
    return found[0] if len(group) == 1 else tuple(found)


def write_motion(path: str | Path, trials: Iterable[Trial]) -> None:
    """Write trials to a file, whole or not at all. Reading it back gives equal trials.

    Args:
        path: ``.parquet`` or ``.csv``.
        trials: with names of which each is there once.

    Raises:
        MotionError: another ending; no trial; a name twice, or with blanks at its ends.
        OSError: the file cannot be written.
    """
    target, listed = Path(path), list(trials)
    if target.suffix not in (".parquet", ".csv"):
        raise MotionError(f"{path}: ends in {shown(target.suffix)}; allowed: .csv, .parquet")
    names = [trial.name for trial in listed]
    counts = Counter(names)
    wrong = next((n for n in names if counts[n] > 1 or n != n.strip()), None)
    if wrong is not None or not names:
        raise MotionError(
            f"{path}: trial {shown(wrong)}; allowed: one or more, each name once and without "
            "blanks at its ends"
        )
    table = pa.concat_tables([_table(trial) for trial in listed])
    table = table.select([n for n in KNOWN if table.column(n).null_count < table.num_rows])
    if target.suffix == ".parquet":
        sink = io.BytesIO()
        pq.write_table(table, sink)
        write_atomically(target, sink.getvalue(), follow=True)
        return
    write_atomically(target, _csv(table), follow=True)


def _csv(table: Any) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(table.column_names)
    for row in zip(*(column.to_pylist() for column in table.columns), strict=True):
        writer.writerow([harmless(row[0]), *("" if v is None else repr(v) for v in row[1:])])
    return text.getvalue()


def _table(trial: Trial) -> Any:
    """A table of all columns; null for what is not known."""
    count = len(trial)
    columns: dict[str, Any] = {"trial": [trial.name] * count, "time": trial.times}
    for key, group in COLUMNS.items():
        values = getattr(trial, key)
        columns |= {n: None if values is None else values[:, k] for k, n in enumerate(group)}
    for key, group in OF_BODY.items():
        value = getattr(trial.body, key)
        each = value if isinstance(value, tuple) else (value,) * len(group)
        columns |= {
            n: None if v is None else np.full(count, v) for n, v in zip(group, each, strict=True)
        }
    return pa.table(
        {
            name: pa.nulls(count, pa.float64())
            if columns[name] is None
            else pa.array(columns[name])
            for name in KNOWN
        }
    )
