"""Rows that a run left in its work folder, without what clocks decide.

They are found by their columns, not by the names of files, so that a store may name its files anew.
"""

from __future__ import annotations

import base64
import gzip
import json
import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq

_VERDICT = (
    "method", "layout", "scenario", "repetition", "item_count", "status", "failing_step", "score",
    "moved_item", "displacement", "rotation", "substeps", "reason",
)  # fmt: skip
_LABEL = ("layout", "scenario", "item_count", "failing_step", "robust")

_RECORDS: Mapping[str, tuple[str, ...]] = {
    "sampled cases": (
        "layout", "scenario", "item_count", "samples", "nominal", "safe", "lost", "low", "high",
        "ending", "variance",
    ),
    "cells of sweeps": ("sweep", "engine", "frequency", "value", "outcome", "numbers", "note"),
}  # fmt: skip
"""Kinds of records in JSON files: fields that one must have."""

_KEYS = {"verdicts": 4, "labels": 2, "sampled cases": 4, "cells of sweeps": 4, "view": 1}
_CLOCKS = re.compile(r"cpu|wall|seconds|version|revision", re.IGNORECASE)


def rows_of(work: Path) -> dict[str, Any]:
    """Rows below a folder by their kind."""
    found: dict[str, tuple[tuple[str, ...], list[list[Any]]]] = {}
    for file in sorted(work.rglob("*.parquet")):
        if "shards" in file.parts:
            continue  # parts of a whole that lies beside them
        columns = pq.read_schema(file).names
        for kind, wanted in (("verdicts", _VERDICT), ("labels", _LABEL)):
            if set(wanted) <= set(columns):
                records = pq.read_table(file, columns=list(wanted)).to_pylist()
                found.setdefault(kind, (wanted, []))[1].extend(
                    [_plain(record[column]) for column in wanted] for record in records
                )
                break
    for file in sorted(work.rglob("*.json")):
        for record in _records(json.loads(file.read_text())):
            for kind, wanted in _RECORDS.items():
                if set(wanted) <= set(record):
                    row = [_plain(record[column]) for column in wanted]
                    found.setdefault(kind, (wanted, []))[1].append(row)
    for file in sorted(work.rglob("*.html")):
        found.setdefault("view", (("path", "value"), []))[1].extend(_view(file))
    return {
        kind: {"columns": list(columns), "key": _KEYS[kind], "rows": _sorted(rows)}
        for kind, (columns, rows) in found.items()
    }


def _sorted(rows: list[list[Any]]) -> list[list[Any]]:
    """Distinct rows in an order of their own."""
    return [json.loads(text) for text in sorted({json.dumps(row) for row in rows})]


def _plain(value: Any) -> Any:
    """A value as JSON has it, without what clocks decide."""
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in sorted(value.items()) if not _CLOCKS.search(k)}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, float) and math.isnan(value):
        return None
    if isinstance(value, str):
        return re.sub(r"[\w./-]*/([\w.]+-\d)-[0-9a-f]{8,}/weights", r"\1/weights", value)
    return value


def _records(content: Any) -> Iterator[dict[str, Any]]:
    if isinstance(content, dict):
        yield content
        for value in content.values():
            if isinstance(value, dict | list):
                yield from _records(value)
    elif isinstance(content, list):
        for value in content:
            if isinstance(value, dict | list):
                yield from _records(value)


def _view(file: Path) -> Iterator[list[Any]]:
    """Leaves of the data of a page that plays a loading; lists without lists in them stay whole."""
    held = re.search(r'<script type="text/plain" id="data">\s*([\w+/=]+)', file.read_text())
    if held is None:
        return
    content = json.loads(gzip.decompress(base64.b64decode(held[1])))
    yield from _leaves(_plain(content), file.name)


def _leaves(content: Any, path: str) -> Iterator[list[Any]]:
    if isinstance(content, dict):
        for key, value in content.items():
            yield from _leaves(value, f"{path}.{key}")
    elif isinstance(content, list) and any(isinstance(value, dict | list) for value in content):
        for place, value in enumerate(content):
            yield from _leaves(value, f"{path}[{place}]")
    else:
        yield [path, content]
