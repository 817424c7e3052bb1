"""Closed forms at several sizes: what lengths that are fixed within an engine cost.

Lengths are multiplied by a factor and times by its root, under the same gravity, so that exact
mechanics finds the same numbers at every size (Froude's law of similitude).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import product

from steadyload.engines.world import Box, FixedStepWorld, Poses, WorldSettings
from steadyload.properties import closed_forms as measuring
from steadyload.properties.closed_form_tests import (
    ClosedFormResult,
    ClosedFormTest,
    closed_form_tests,
    result_of,
)
from steadyload.properties.closed_forms import Stage
from steadyload.reports.columns import cell, column, compact, general, row
from steadyload.runs.provenance import made_on
from steadyload.studies.kit import Asked, Lab, asked

EDGES = (0.1, 1.0, 10.0)
"""Edge of the cubes of a test [m]; at the first one a test is that of the closed forms."""

TESTS = ("sliding threshold", "tipping offset", "time to 10 degrees, 1 mm", "overhang of 5")
"""Names of the tests that are run at every size."""

FREQUENCY = 480
"""Substeps a second at the first size; they take as long as times do at the others."""


@dataclass(frozen=True, slots=True)
class ScaledStage(Stage):
    """A stage on which lengths are multiplied; what is read is in the lengths of the test."""

    scale: float = 1.0

    @contextmanager
    def scene(self, boxes: Sequence[Box], settings: WorldSettings) -> Iterator[FixedStepWorld]:
        """A world that holds the boxes, larger by the factor."""
        larger = [
            replace(box, size=self._larger(box.size), centre=self._larger(box.centre))
            for box in boxes
        ]
        with Stage.scene(self, larger, settings) as world:
            yield world

    def _larger(self, lengths: tuple[float, float, float]) -> tuple[float, float, float]:
        x, y, z = lengths
        return self.scale * x, self.scale * y, self.scale * z

    def run(self, world: FixedStepWorld, seconds: float) -> Poses:
        """Poses after a further time of the test [s]."""
        pace = math.sqrt(self.scale)
        slower = Stage(self.engine, self.frequency / pace)  # type: ignore[arg-type]
        poses = slower.run(world, pace * seconds)
        return poses._replace(centres=poses.centres / self.scale)


class SizeUnit(
    Asked[ClosedFormResult],
    what="closed form at a size",
    frequency=FREQUENCY,
    version=measuring.VERSION,
):
    """A test on an engine at a size."""

    test: str
    engine: str
    edge: float
    made_by: Mapping[str, str] = asked("made by")

    def describe(self, part: int) -> str:
        """Description of the test for messages."""
        return f"{self.test} on {self.engine}, edges of {self.edge:g} m"

    def measure(self) -> ClosedFormResult:
        """Run the test."""
        stage = ScaledStage(self.engine, FREQUENCY, scale=self.edge / EDGES[0])
        return result_of(_tests()[self.test], stage, FREQUENCY)


@row
class SizeRow:
    """Results of a closed form at a size, by engine."""

    test: str = column()
    unit: str = column("in")
    edge: float = column("edge, m", general)
    errors: Mapping[str, ClosedFormResult] = column(
        "{}", lambda one: one.note or cell(None) if one.error is None else compact(one.error)
    )


def _tests() -> dict[str, ClosedFormTest]:
    return {test.name: test for test in closed_form_tests() if test.name in TESTS}


def closed_forms_by_size(lab: Lab, engines: Sequence[str], folder: str) -> list[SizeRow]:
    """Errors by test and edge; measured where they are missing."""
    known, made = _tests(), {engine: made_on(engine) for engine in engines}
    units = [
        SizeUnit(test, engine, edge, made[engine])
        for test, edge, engine in product(TESTS, EDGES, engines)
    ]
    found = iter(lab.measure(units, ClosedFormResult, folder=folder, parallel=True).rows)
    return [
        SizeRow(test, known[test].error_unit, edge, {name: next(found) for name in engines})
        for test, edge in product(TESTS, EDGES)
    ]
