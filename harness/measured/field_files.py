"""Tables of tests of real stacks: CSV, one row for each test. See ``docs/field-test.md``."""

from __future__ import annotations

import csv
import io
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Unpack

from steadyload.atomic import write_atomically
from steadyload.errors import UserError, nearest
from steadyload.escaping import shown
from steadyload.layouts.files.csv_cells import harmless, unguarded
from steadyload.layouts.formats import Reading, read_layouts
from steadyload.layouts.model.layout import Layout
from steadyload.measured.csv_rows import csv_rows, number_in, places
from steadyload.measured.errors import FieldTestError
from steadyload.measured.field_tests import LEVELS, TOWARDS, Done, FieldTest
from steadyload.reading import MAX_HISTORY_BYTES, content_of

REQUIRED = ("test", "plan", "done", "moved_box")
"""Columns that every table has."""

LEVEL_COLUMNS = tuple(name for names in LEVELS.values() for name in names[:2])

KNOWN = (*REQUIRED, "layout", "towards", *LEVEL_COLUMNS, "moved_at_box", "note")

COLUMNS = (
    "test", "plan", "layout", "done", "towards", "tilt_deg", "acceleration_g", "moved_box",
    "moved_at_box", "moved_at_deg", "moved_at_g", "note",
)  # fmt: skip
"""All columns, in the order in which they are written."""

UNKNOWN_BOX = "?"
"""Stands for the box that moved where it is not known which one did."""

MAX_TESTS = 10_000
"""Tests of a table."""

_STEP = re.compile(r"(?:step |item )?([0-9]{1,9})")


@dataclass(frozen=True)
class FieldTests:
    """A table of tests.

    Attributes:
        tests: in the order of the file.
        comments: texts of the lines before the header that begin with ``#``.
    """

    tests: tuple[FieldTest, ...]
    comments: tuple[str, ...] = ()


def read_field_tests(path: str | Path, **reading: Unpack[Reading]) -> FieldTests:
    """All tests of a table, each with its plan.

    Args:
        path: CSV; plans are files whose names are relative to its folder.
        reading: of the plans, see :class:`steadyload.layouts.formats.Reading`.

    Raises:
        FieldTestError: the file is no such table, or holds what is not allowed: says in which test,
            and what is.
        TooLargeError: it has too many bytes.
        OSError: it cannot be opened.
    """
    content = content_of(Path(path), MAX_HISTORY_BYTES)
    try:
        opened = csv_rows(content, KNOWN, FieldTestError)
        found = places(opened.header, KNOWN, REQUIRED, FieldTestError)
        reader = _Rows(Path(path).parent, reading, {})
        tests: dict[str, FieldTest] = {}
        for line, row in opened.rows:
            cells = {name: unguarded(row[place].strip()) for name, place in found.items()}
            name = cells["test"]
            if not name:
                raise FieldTestError(f"line {line} names no test; allowed: a name in every row")
            if name in tests:
                raise FieldTestError(
                    f"test {shown(name)} stands there twice; allowed: one row for each test"
                )
            if len(tests) == MAX_TESTS:
                raise FieldTestError(f"has more than {MAX_TESTS:,} tests; allowed: up to so many")
            tests[name] = reader.test(cells)
        if not tests:
            raise FieldTestError("holds no tests; allowed: one row for each test")
    except FieldTestError as error:
        raise FieldTestError(f"{path}: {error}") from None
    return FieldTests(tuple(tests.values()), opened.comments)


@dataclass(frozen=True)
class _Rows:
    """Rows of a table as tests; every plan is read once."""

    folder: Path
    reading: Reading
    plans: dict[str, list[Layout]]

    def test(self, cells: Mapping[str, str]) -> FieldTest:
        """The test of a row."""
        try:
            layout = self._layout(cells)
            done = cells["done"].casefold()
            moved = cells["moved_box"]
            if done not in [*Done]:
                raise FieldTestError(
                    f"box {shown(moved)} moved in a test in which nothing was done (done is "
                    f"empty); allowed: {', '.join(Done)}"
                    if moved and not done
                    else f"done is {shown(cells['done'])}; {nearest(done, [*Done])}"
                )
            numbers = {name: _level(name, cells.get(name, "")) for name in LEVEL_COLUMNS}
            at = cells.get("moved_at_box", "")
            step = None if moved in ("", UNKNOWN_BOX) else box_of(layout, moved, "moved_box")
            at_step = box_of(layout, at, "moved_at_box") if at else None
            towards = _direction(cells.get("towards", ""))
        except FieldTestError as error:
            raise FieldTestError(f"test {shown(cells['test'])}: {error}") from None
        return FieldTest(
            name=cells["test"], plan=cells["plan"], layout=layout, done=Done(done),
            towards_deg=towards, moved=bool(moved), moved_step=step, moved_at_step=at_step,
            note=cells.get("note", ""), **numbers,
        )  # fmt: skip

    def _layout(self, cells: Mapping[str, str]) -> Layout:
        """The plan of a row."""
        plan, name = cells["plan"], cells.get("layout", "")
        if plan not in self.plans:
            self.plans[plan] = self._read(plan)
        layouts = self.plans[plan]
        if not name and len(layouts) == 1:
            return layouts[0]
        found = next((layout for layout in layouts if layout.name == name), None)
        if found is None:
            names = [layout.name for layout in layouts[:20]]
            raise FieldTestError(
                f"layout is {shown(name)}; {nearest(name, names)}, of {shown(plan)}"
            )
        return found

    def _read(self, plan: str) -> list[Layout]:
        file = os.path.join(self.folder, plan)  # noqa: PTH118, "-" stays the name of a file
        try:
            there = bool(plan) and Path(file).is_file()
        except (OSError, ValueError):
            there = False
        if not there:
            raise FieldTestError(
                f"plan {shown(plan)} is no file; allowed: a layout file, relative to the folder of "
                "the table"
            )
        try:
            return read_layouts(file, **self.reading)
        except (UserError, OSError) as error:
            raise FieldTestError(f"plan {shown(plan)}: {error}") from None


def box_of(layout: Layout, text: str, where: str) -> int:
    """Step of the box that a text names: by its id, or by its step, such as ``step 4``.

    Args:
        layout: the plan.
        text: an id, or a step, counted from 0; an id goes first.
        where: name of the column, for the message.

    Raises:
        FieldTestError: there is no such box, or several have this id.
    """
    found = [step for step, name in enumerate(layout.ids) if name == text]
    if len(found) == 1:
        return found[0]
    if found:
        steps = ", ".join(f"step {step}" for step in found[:20])
        raise FieldTestError(f"{where} is {shown(text)}, the id of several boxes; allowed: {steps}")
    step = _STEP.fullmatch(text)
    if step and int(step[1]) < len(layout):
        return int(step[1])
    names = [name for name in dict.fromkeys(layout.ids) if name][:20]
    hint = f"{nearest(text, names)}; or " if names else "allowed: "
    raise FieldTestError(
        f"{where} is {shown(text)}, which layout {shown(layout.name)} does not have; {hint}step 0 "
        f"to step {len(layout) - 1}"
    )


def box_text(layout: Layout, step: int) -> str:
    """A text by which :func:`box_of` finds the box of a step."""
    name = layout.items[step].name
    whole = name and name == name.strip() and name != UNKNOWN_BOX and layout.ids.count(name) == 1
    return name if whole else f"step {step}"


def _level(name: str, cell: str) -> float | None:
    value = number_in(cell) if cell else None
    if cell and value is None:
        raise FieldTestError(f"{name} is {shown(cell)}; allowed: a number, or nothing")
    return value


def _direction(cell: str) -> float | None:
    if not cell:
        return None
    found = TOWARDS.get(cell.casefold(), number_in(cell))
    if found is None:
        raise FieldTestError(
            f"towards is {shown(cell)}; {nearest(cell, TOWARDS)}, or 0 to 360 [degrees]"
        )
    return found


def write_field_tests(
    path: str | Path, tests: Iterable[FieldTest], comments: Sequence[str] = ()
) -> None:
    """Write a table, whole or not at all; plans are named and not written.

    Args:
        path: of the table.
        tests: to write.
        comments: lines before its header, printable.

    Raises:
        OSError: the file cannot be written.
    """
    text = io.StringIO()
    text.writelines(f"# {comment}\n" for comment in comments)
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows(_cells(test) for test in tests)
    write_atomically(Path(path), text.getvalue(), follow=True)


def _cells(test: FieldTest) -> list[str]:
    def number(value: float | None) -> str:
        return "" if value is None else repr(float(value))

    def box(step: int | None) -> str:
        return "" if step is None else harmless(box_text(test.layout, step))

    moved = box(test.moved_step) or (UNKNOWN_BOX if test.moved else "")
    return [
        harmless(test.name), harmless(test.plan), harmless(test.layout.name), str(test.done),
        number(test.towards_deg), number(test.tilt_deg), number(test.acceleration_g), moved,
        box(test.moved_at_step), number(test.moved_at_deg), number(test.moved_at_g),
        harmless(test.note),
    ]  # fmt: skip
