"""The page on time and memory of a study by its number of rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from steadyload.reports.page import Page, Section
from steadyload.reports.table import Column, Table, significant
from steadyload.studies.scale.study import ScalePoint, ScaleStep

_COLUMNS = (
    Column("rows"),
    Column("layouts"),
    Column("folder MiB", "size", significant),
    *(
        column
        for step in ("run", "load", "report")
        for column in (
            Column(f"{step}: wall s", f"{step}.wall", significant),
            Column(f"{step}: CPU s", f"{step}.cpu", significant),
            Column(f"{step}: MiB", f"{step}.peak", "{:.0f}".format),
        )
    ),
)


def scale_page(points: Sequence[ScalePoint], how: str, manifest: Mapping[str, str]) -> Page:
    """Compose the page.

    Args:
        points: by rising number of rows.
        how: a sentence on the methods and layouts.
        manifest: provenance of the page.
    """
    least, most = points[0], points[-1]
    growth = ""
    if most.rows > least.rows:
        added = [b.peak - a.peak for a, b in zip(_steps(least), _steps(most), strict=True)]
        grown = [f"{2**20 * more / (most.rows - least.rows):.0f}" for more in added]
        growth = (
            f" From the first line to the last the memory of the run grows by {grown[0]} bytes a "
            f"row, of the load by {grown[1]}, of the report by {grown[2]}."
        )
    return Page(
        "What a study of many rows needs",
        f"{_answer(most)}{how} MiB is the most memory that the process of a step held at a time, "
        f"imports included.{growth}",
        [
            Section(
                "Time and memory",
                "*Run*: the process that hands out units and writes shards; others judge. *Load*: "
                "`load_results`, all columns. *Report*: what a page shows, from the folder.",
                [Table(points, _COLUMNS)],
            )
        ],
        manifest,
    )


def _answer(most: ScalePoint) -> str:
    """Sentence on the largest study."""
    peaks = [f"{step.peak:.0f}" for step in _steps(most)]
    return (
        f"Beside the judging itself a study of {most.rows:,} rows takes {most.run.cpu:.0f} s of "
        f"CPU time and {peaks[0]} MiB; reading all its rows takes {significant(most.load.cpu)} s "
        f"and {peaks[1]} MiB, its report {significant(most.report.cpu)} s and {peaks[2]} MiB.\n\n"
    )


def _steps(point: ScalePoint) -> tuple[ScaleStep, ...]:
    return point.run, point.load, point.report
