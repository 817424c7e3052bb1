"""Cases of a labelled set as layout files, with their labels beside them."""

from __future__ import annotations

import csv
import errno
import io
import os
import tempfile
from pathlib import Path
from typing import Any

import pandas as pd

from steadyload.atomic import write_atomically
from steadyload.layouts.benchmark.dataset import KEYS, Benchmark, labelled
from steadyload.layouts.benchmark.parts import Part
from steadyload.layouts.benchmark.tables import BenchmarkError
from steadyload.layouts.files.csv_cells import harmless
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.question import Question
from steadyload.statistics.placed import items_placed_by_case

LABEL_COLUMNS = (
    "layout",
    "scenario",
    "instance",
    "split",
    "rank",
    "item_count",
    "failing_step",
    "score",
    "failing_step_paper",
    "confidence",
    "robust",
    "stands",
    "failing_step_stands",
)
"""Columns of the file of labels. ``layout`` is the name in the layout file; ``failing_step`` is
empty for a stable layout; ``score`` the share of items placed safely; ``confidence`` and ``robust``
are empty for a case that was not judged again. ``stands`` and ``failing_step_stands`` are the label
of the question ``stands``, empty for a case without one; the step also for one that stands."""


def export(
    benchmark: Benchmark,
    path: str | Path,
    kind: Format,
    *,
    part: Part | str = Part.ALL,
    scenarios: tuple[str, ...] = (),
    limit: int | None = None,
    failing: bool = False,
) -> int:
    """Write cases as one file of layouts, and their labels beside it, both or neither.

    A case's layout is named after geometry and scenario, ``NAME_S2a``. Labels go to
    :func:`labels_path`.

    Args:
        benchmark: where the cases come from.
        path: the layout file.
        kind: its format; one that can be written.
        part: as in :meth:`steadyload.layouts.benchmark.dataset.Benchmark.select`.
        scenarios: as there.
        limit: as there; of failing cases where these alone are wanted.
        failing: only cases that fail by the label of at least one question.

    Returns:
        The number of cases written.

    Raises:
        BenchmarkError: no such part or scenario, or no such case.
        FormatError: ``kind`` cannot be written.
        OSError: a file cannot be written; names it.
    """
    target = Path(path).resolve()
    targets = (labels_path(target), target)
    for file in targets:
        if file.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(file))
    cases = benchmark.select(part, scenarios=scenarios, limit=None if failing else limit)
    if failing:
        cases = _failing(benchmark, cases)
        most = len(cases) if limit is None else limit
        cases = cases.groupby("scenario", sort=False).head(most)
    names = [_name(case) for case in cases.to_dict("records")]
    layouts = (
        benchmark.layout(layout, scenario).renamed(name)
        for (layout, scenario), name in zip(cases[KEYS].to_numpy(), names, strict=True)
    )
    try:
        # Both are written in full before either of them is seen.
        with tempfile.TemporaryDirectory(prefix=f".{target.name}.", dir=target.parent) as folder:
            staged = [Path(folder) / file.name for file in targets]
            write_atomically(staged[0], _labels(benchmark, cases, names))
            write_layouts(staged[1], layouts, kind)
            for source, file in zip(staged, targets, strict=True):
                source.replace(file)
    except OSError as error:
        raise type(error)(error.errno, error.strerror, str(path)) from None
    return len(cases)


def _failing(benchmark: Benchmark, cases: pd.DataFrame) -> pd.DataFrame:
    """Those of the cases that fail by the label of at least one question.

    Raises:
        BenchmarkError: none does.
    """
    steps = [benchmark.labels_on(question)[[*KEYS, "failing_step"]] for question in Question]
    falls = pd.MultiIndex.from_frame(pd.concat(steps).dropna()[KEYS])
    found = cases[pd.MultiIndex.from_frame(cases[KEYS]).isin(falls)]
    if found.empty:
        raise BenchmarkError("none of these cases fails; allowed: a part of which some do")
    return found


def labels_path(path: Path) -> Path:
    """The file of labels beside a layout file: ``cases.json`` has ``cases.labels.csv``."""
    return path.with_name(f"{path.stem}.labels.csv")


def _cell(value: Any) -> Any:
    """A value as a cell; a text that a spreadsheet would take for a formula as layouts have it."""
    return harmless(value) if isinstance(value, str) else value


def _name(case: dict[Any, Any]) -> str:
    return f"{case['layout']}_{case['scenario']}"


def _labels(benchmark: Benchmark, cases: pd.DataFrame, names: list[str]) -> str:
    sure = cases[KEYS].merge(
        benchmark.confidence_on(Question.WITHIN).reset_index(), on=KEYS, how="left"
    )
    placed = items_placed_by_case(cases["failing_step"], cases["item_count"])
    other = labelled(benchmark.labels_on(Question.STANDS))[[*KEYS, "failing_step"]]
    steps = cases[KEYS].merge(other, on=KEYS, how="left", indicator="has_label")
    text = io.StringIO()
    writer = csv.DictWriter(text, LABEL_COLUMNS, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    for name, case, how, safe, step, has_label in zip(
        names, cases.to_dict("records"), sure.to_dict("records"), placed, steps["failing_step"],
        steps["has_label"] == "both", strict=True,
    ):  # fmt: skip
        values = how | case | {
            "layout": name, "score": safe / case["item_count"],
            "stands": pd.isna(step) if has_label else None, "failing_step_stands": step,
        }  # fmt: skip
        writer.writerow({k: "" if pd.isna(values[k]) else _cell(values[k]) for k in LABEL_COLUMNS})
    return text.getvalue()
