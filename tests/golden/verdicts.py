"""Golden verdicts: judged in sequence in one process, stored, and compared."""

import json
import math
import time
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import moved_starts
import pyarrow as pa
import pyarrow.parquet as pq
from golden_cases import Case, load_cases
from golden_methods import Asked, asked

from steadyload.engines.registry import package_versions
from steadyload.methods.contract.method import judge
from steadyload.methods.registry import make_method
from steadyload.runs.provenance import machine

FOLDER = Path(__file__).parent / "verdicts"
ONE_MACHINE = FOLDER / "one_machine.json"
"""Method, layout and scenario of the verdicts that hold on one kind of machine alone."""
SEEDS = ("1", "2", "3")
"""Starts are moved by these to find them."""
KEYS = ("method", "layout", "scenario")
DISCRETE = ("status", "failing_step", "moved_item")
FLOATS = ("displacement", "rotation")

SCHEMA = pa.schema(
    [
        pa.field("method", pa.string(), nullable=False),
        pa.field("layout", pa.string(), nullable=False),
        pa.field("scenario", pa.string(), nullable=False),
        pa.field("robust", pa.bool_(), nullable=False),
        pa.field("packages", pa.string(), nullable=False),
        pa.field("status", pa.string(), nullable=False),
        pa.field("failing_step", pa.int32()),
        pa.field("moved_item", pa.int32()),
        pa.field("displacement", pa.float64()),
        pa.field("rotation", pa.float64()),
    ]
)

Row = Mapping[str, Any]
Spent = dict[str, float]


_FEWEST = 6
"""Cases of a method at least: one turn of the rule that chooses them."""


def judged(
    asked: Iterable[Asked], spent: Spent | None = None, seconds: float = math.inf
) -> Iterator[Row]:
    """A row a verdict, in turn.

    Args:
        asked: what is judged.
        spent: takes the CPU seconds by method.
        seconds: CPU time after which a method judges no further cases.
    """
    cases = {planar: load_cases(planar=planar) for planar in (False, True)}
    for each in asked:
        method, before = make_method(each.spec), time.process_time()
        packages = " ".join(
            f"{k}={v}" for k, v in package_versions(sorted(method.numerics())).items()
        )
        for place in each.cases:
            if place >= _FEWEST and time.process_time() - before > seconds:
                break
            case = cases[each.planar][place]
            yield {**_row(each.spec, case), "packages": packages, **_said(method, case)}
        if spent is not None:
            spent[each.spec] = time.process_time() - before


def _row(spec: str, case: Case) -> Row:
    return {
        "method": spec,
        "layout": case.layout.name,
        "scenario": case.scenario,
        "robust": case.robust,
    }


def _said(method: Any, case: Case) -> Row:
    verdict = judge(method, case.layout)
    said = {name: getattr(verdict, name) for name in (*DISCRETE, *FLOATS)}
    return {**said, "status": str(verdict.status)}


def turned(kept: Sequence[Row], asked: Sequence[Asked]) -> set[tuple[str, ...]]:
    """Keys of the verdicts that are other ones when starts are moved by less than rounding moves
    them on another kind of machine.

    Args:
        kept: verdicts.
        asked: the same, as they are judged.
    """
    found: set[tuple[str, ...]] = set()
    for seed in SEEDS:
        with moved_starts.by(seed):
            for row, now in zip(kept, judged(asked), strict=True):
                if any(row[k] != now[k] for k in DISCRETE):
                    found.add(tuple(row[k] for k in KEYS))
    return found


def differences(
    golden: Iterable[Row],
    now: Iterable[Row],
    *,
    same_machine: bool,
    one_machine: Collection[tuple[str, ...]] = (),
) -> list[str]:
    """A sentence for every verdict that is another one now.

    Args:
        golden: what is kept.
        now: the same verdicts, in the same order.
        same_machine: of the kind that the golden ones were judged on: floats count to the last
            bit. Elsewhere only what is discrete counts, and only on robust cases. What was judged
            with other versions of packages is another question.
        one_machine: keys of the verdicts that do not count elsewhere.
    """
    found = []
    for kept, row in zip(golden, now, strict=True):
        where = f"{row['method']} on {row['layout']} ({row['scenario']})"
        key = tuple(row[k] for k in KEYS)
        assert key == tuple(kept[k] for k in KEYS), where
        holds_elsewhere = kept["robust"] and key not in one_machine
        if kept["packages"] != row["packages"] or not (same_machine or holds_elsewhere):
            continue
        compared = (*DISCRETE, *FLOATS) if same_machine else DISCRETE
        changed = [f"{k} {kept[k]!r} -> {row[k]!r}" for k in compared if kept[k] != row[k]]
        if changed:
            found.append(f"{where}: {', '.join(changed)}")
    return found


def advice(found: list[str]) -> str:
    """What to do about differences."""
    shown = "\n".join(found[:20])
    return (
        f"{len(found)} golden verdicts are other ones now. Mend the code, or raise the version of "
        "the part that says something else (method, contacts, scene, loading, balance, motion, "
        "world, engine, features or inference) and record anew: python tests/golden/record.py. "
        f"Where only floats differ, judge all of validation and test before.\n{shown}"
    )


def write(path: Path, rows: Iterable[Row]) -> None:
    """Keep verdicts, and what they were judged on."""
    table = pa.Table.from_pylist([dict(row) for row in rows], schema=SCHEMA)
    pq.write_table(table.replace_schema_metadata({"machine": machine()}), path, compression="zstd")


def plan(golden: Sequence[Row], *, deep: bool) -> list[Asked]:
    """What is judged, as many cases as were kept."""
    count = Counter(row["method"] for row in golden)
    every = asked(deep=deep)
    assert {each.spec for each in every} == set(count), "record anew: the plan is another one"
    return [each._replace(cases=each.cases[: count[each.spec]]) for each in every]


def holding_on_one_machine() -> set[tuple[str, ...]]:
    """Keys of the verdicts that hold on one kind of machine alone, as they are kept."""
    return {tuple(key) for key in json.loads(ONE_MACHINE.read_text())}


def read(path: Path) -> tuple[list[Row], str]:
    """Kept verdicts, and the kind of machine that they were judged on."""
    table = pq.read_table(path)
    return table.to_pylist(), (table.schema.metadata or {})[b"machine"].decode()
