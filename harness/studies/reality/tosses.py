"""Single trials: those that every engine gets wrong, and a line for each trial and engine."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Sequence
from typing import Any

from steadyload.layouts.files.csv_cells import harmless
from steadyload.studies.reality.record import Toss
from steadyload.studies.reality.releasing import Ended
from steadyload.studies.reality.running import AllMeasured, ByEngine, Way

COLUMNS = (
    "trial", "half", "recorded_face", "impacts", "departure_mm", "engine", "face", "off_cm",
    "turn_deg", "height_mm", "deepest_mm", "rest_s", "recorded_rest_s", "failed",
)  # fmt: skip
"""Of the CSV file; engines with fitted contacts."""


def worst(found: AllMeasured) -> list[dict[str, Any]]:
    """Trials that all engines get wrong with fitted contacts, by how far the record departs from
    free flight before its first contact; ``predicted``: engines by face.
    """
    by_name = _by_name(found)
    rows = []
    for toss in sorted(found.recorded.tosses, key=lambda one: -one.departure_m):
        ends = by_name[toss.name]
        if not any(end.same_face for end in ends.values()):
            faces = Counter(end.face or "none" for end in ends.values())
            rows.append(
                {
                    "trial": toss.name,
                    "half": toss.half,
                    "recorded_face": toss.face,
                    "predicted": dict(faces.most_common()),
                    "impacts": toss.impacts,
                    "departure_mm": 1e3 * toss.departure_m,
                    "turned_by": toss.turn_deg,
                }
            )
    return rows


def _by_name(found: AllMeasured) -> dict[str, dict[str, Ended]]:
    """Ends with fitted contacts, by trial and engine."""
    ends: dict[str, dict[str, Ended]] = {toss.name: {} for toss in found.recorded.tosses}
    for engine in found.engines:
        for end in engine.batches[Way.FITTED].ended:
            ends[end.name][engine.title] = end
    return ends


def as_csv(found: AllMeasured) -> str:
    """A line for each trial and engine, with fitted contacts."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    tosses = {toss.name: toss for toss in found.recorded.tosses}
    for engine in found.engines:
        for end in engine.batches[Way.FITTED].ended:
            writer.writerow(_line(tosses[end.name], engine, end))
    return text.getvalue()


def _line(toss: Toss, engine: ByEngine, end: Ended) -> Sequence[object]:
    return (
        harmless(toss.name), toss.half, toss.face, toss.impacts,
        _number(toss.departure_m, 1e3), engine.name, end.face, _number(end.off_m, 1e2),
        _number(end.turn_deg), _number(end.height_m, 1e3), _number(end.deepest_m, 1e3),
        _number(end.rest_s), _number(toss.rest_s), harmless(end.failed),
    )  # fmt: skip


def _number(value: float | None, scale: float = 1.0) -> str:
    return "" if value is None else f"{scale * value:.4g}"
