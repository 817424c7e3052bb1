"""What became of the facts of a page: the same, moved, worded anew, changed, missing, new."""

from __future__ import annotations

import difflib
import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from facts import Cell, Page, Table, cells, numbers

_LIKE = 0.5
"""Similarity from which a sentence with the same numbers is taken for the same, worded anew."""


@dataclass
class Renames:
    """Declared changes: old titles with their new ones, and facts that are waived with a reason."""

    entries: dict[str, list[dict[str, str]]] = field(default_factory=dict)

    def new(self, kind: str, page: str, old: str) -> str:
        """The present title of a heading, column, row, sentence or figure."""
        for entry in self.entries.get(kind, []):
            if entry.get("page", page) == page and entry["old"] == old:
                return entry["new"]
        return old

    def waived(self, page: str, **place: str) -> bool:
        """Whether a fact is declared to be gone or to have another value, for a stated reason."""
        return any(
            entry.get("page", page) == page
            and entry["reason"]
            and len(entry) > 1 + ("page" in entry)
            and all(
                re.fullmatch(pattern, place.get(what, ""))
                for what, pattern in entry.items()
                if what not in ("reason", "page")
            )
            for entry in self.entries.get("waived", [])
        )


@dataclass
class Found:
    """What a comparison found; a line a fact."""

    same: int = 0
    moved: list[str] = field(default_factory=list)
    elsewhere: list[str] = field(default_factory=list)
    reworded: list[str] = field(default_factory=list)
    waived: list[str] = field(default_factory=list)
    changed: list[str] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)
    new: list[str] = field(default_factory=list)

    @property
    def clean(self) -> bool:
        """Whether no fact is changed or missing."""
        return not (self.changed or self.missing)


@dataclass
class _Place:
    """A cell of the present page that may hold a fact."""

    table: Table
    row: list[str]
    column: str
    taken: bool = False

    @property
    def value(self) -> str:
        return self.row[self.table.columns.index(self.column)]

    def named(self, key: Iterable[tuple[str, str]]) -> bool:
        """Whether the row has all these titles, in their columns or, without those, anywhere."""
        return all(
            self.row[self.table.columns.index(column)] == text
            if column in self.table.columns
            else text in self.row or text in self.table.heading
            for column, text in key
        )


def compare_pages(name: str, old: Page, new: Page, renames: Renames) -> Found:
    """Look for every old fact on the new page."""
    found = Found()
    _compare_cells(name, old, new, renames, found)
    _compare_sentences(name, old, new, renames, found)
    left = Counter(map(_stem, new.figures))
    for figure in old.figures:
        wanted = _stem(renames.new("figure", name, figure))
        if left[wanted]:
            left[wanted] -= 1
            found.same += 1
        elif renames.waived(name, figure=figure):
            found.waived.append(f"figure {figure}")
        else:
            found.missing.append(f"figure {figure}")
    found.new += [f"figure {figure}" for figure in left.elements()]
    return found


def _stem(figure: str) -> str:
    """The name of a figure without its ending: a figure may be drawn as SVG or as PNG."""
    return figure.rpartition(".")[0]


def _compare_cells(name: str, old: Page, new: Page, renames: Renames, found: Found) -> None:
    by_column: dict[str, list[_Place]] = defaultdict(list)
    for table in new.tables:
        for row in table.rows:
            for column in table.columns:
                by_column[column].append(_Place(table, row, column))
    later = []
    ordinal = _ordinals(old)
    for table in old.tables:
        for fact in cells(table):
            wanted = _renamed(name, fact, renames)
            places = [p for p in by_column[wanted.column] if p.named(wanted.key)]
            there = _under(places, wanted.heading, ordinal[id(table)], new)
            if not there:
                later.append((fact, wanted, places))
            elif not _take(there, wanted.value):
                _report_changed(name, fact, there, renames, found)
            else:
                found.same += 1
    headings = {table.heading for table in new.tables}
    for fact, wanted, places in later:
        near = [p for p in places if _context(p, wanted)] or places
        if _take(near, wanted.value):
            found.moved.append(f"{fact}: {fact.value}")
        elif wanted.heading not in headings and any(p.value == wanted.value for p in near):
            found.elsewhere.append(f"{fact}: {fact.value}")
        elif near:
            _report_changed(name, fact, near, renames, found)
        elif renames.waived(name, **_place_of(fact)):
            found.waived.append(f"{fact}: {fact.value}")
        else:
            found.missing.append(f"{fact}: {fact.value}")
    kept = {id(p.row): p for places in by_column.values() for p in places if p.taken}
    for table in new.tables:
        found.new += [
            f"row {table.heading} | {' | '.join(row[:3])}"
            for row in table.rows
            if id(row) not in kept and len(table.columns) > 1
        ]


def _ordinals(page: Page) -> dict[int, tuple[int, int]]:
    """Which one of how many tables under its heading a table is."""
    under: dict[str, list[int]] = defaultdict(list)
    for table in page.tables:
        under[table.heading].append(id(table))
    return {
        one: (place, len(several))
        for several in under.values()
        for place, one in enumerate(several)
    }


def _under(
    places: Sequence[_Place], heading: str, ordinal: tuple[int, int], new: Page
) -> list[_Place]:
    """Places under a heading; of as many tables there as before, those of the same one."""
    there = [p for p in places if p.table.heading == heading]
    now = _ordinals(new)
    return [p for p in there if now[id(p.table)] == ordinal] or [
        p for p in there if now[id(p.table)][1] != ordinal[1]
    ]


def _report_changed(
    name: str, fact: Cell, places: Sequence[_Place], renames: Renames, found: Found
) -> None:
    now = " or ".join(dict.fromkeys(p.value for p in places))
    line = f"{fact}: {fact.value} -> {now}"
    waived = renames.waived(name, **_place_of(fact))
    (found.waived if waived else found.changed).append(line)


def _place_of(fact: Cell) -> dict[str, str]:
    row = ", ".join(text for _, text in fact.key)
    return {"heading": fact.heading, "row": row, "column": fact.column, "value": fact.value}


def _renamed(name: str, fact: Cell, renames: Renames) -> Cell:
    return Cell(
        renames.new("heading", name, fact.heading),
        tuple(
            (renames.new("column", name, column), renames.new("row", name, text))
            for column, text in fact.key
        ),
        renames.new("column", name, fact.column),
        fact.value,
    )


def _take(places: Sequence[_Place], value: str) -> bool:
    """Take a free cell with the value."""
    for place in places:
        if not place.taken and place.value == value:
            place.taken = True
            return True
    return False


def _context(place: _Place, fact: Cell) -> bool:
    """Whether the row names in a cell what the fact's old heading named, such as a scenario."""
    words = set(re.split(r"[\s/,`]+", fact.heading))
    titles = {text for _, text in fact.key}
    return any(text in words and text not in titles for text in place.row if len(text) > 1)


def _compare_sentences(name: str, old: Page, new: Page, renames: Renames, found: Found) -> None:
    left = Counter(text for _, text in new.sentences)
    missing = []
    for heading, text in old.sentences:
        wanted = renames.new("sentence", name, text)
        if left[wanted]:
            left[wanted] -= 1
            found.same += 1
        else:
            missing.append((heading, wanted))
    for heading, text in missing:
        alike = [
            other
            for other, count in left.items()
            if count and numbers(other) == numbers(text) and _likeness(text, other) >= _LIKE
        ]
        near = max(alike, key=lambda other: _likeness(text, other), default=None)
        if near is not None:
            left[near] -= 1
            found.reworded.append(f"{heading}: {text!r} -> {near!r}")
        elif text in left:
            found.elsewhere.append(f"{heading}: {text!r}")
        elif renames.waived(name, heading=heading, sentence=text):
            found.waived.append(f"{heading}: {text!r}")
        else:
            nearest = difflib.get_close_matches(text, [t for t, n in left.items() if n], 1, 0.6)
            hint = f" -> perhaps {nearest[0]!r}" if nearest else ""
            found.missing.append(f"{heading}: {text!r}{hint}")
    found.new += [f"sentence {text!r}" for text in left.elements()]


def _likeness(one: str, other: str) -> float:
    return difflib.SequenceMatcher(None, one, other).ratio()


def compare_rows(name: str, old: dict[str, Any], new: dict[str, Any], renames: Renames) -> Found:
    """Look for every old row among the new ones; order and repeated equal rows do not matter."""
    found = Found()
    for kind, table in old.items():
        columns = table["columns"]
        size = table["key"]
        present = new.get(kind, {"columns": columns, "rows": []})
        place = [present["columns"].index(c) if c in present["columns"] else -1 for c in columns]
        rows = [[row[p] if p >= 0 else None for p in place] for row in present["rows"]]
        whole = {_frozen(row) for row in rows}
        by_key = defaultdict(list)
        for row in rows:
            by_key[_frozen(row[:size])].append(row)
        if not rows and renames.waived(name, rows=kind):
            found.waived.append(f"{len(table['rows'])} rows of {kind}")
            continue
        if not rows:
            found.missing.append(f"all {len(table['rows'])} rows of {kind}")
            continue
        for row in table["rows"]:
            if _frozen(row) in whole:
                found.same += 1
                continue
            here = by_key.get(_frozen(row[:size]))
            line = f"{kind} {row[:size]}: {row[size:]}"
            if renames.waived(name, rows=kind, row=str(row[0])):
                found.waived.append(line)
            elif here:
                found.changed.append(f"{line} -> {' or '.join(str(r[size:]) for r in here[:2])}")
            else:
                found.missing.append(line)
        known = {_frozen(row[:size]) for row in table["rows"]}
        found.new += [f"{kind} {list(key)}" for key in by_key if key not in known]
    return found


def _frozen(row: Sequence[Any]) -> tuple[str, ...]:
    return tuple(repr(value) for value in row)
