"""Every engine compared with mechanics: single bodies and small stacks whose motion is known.

A test is a definition with its expected value and a function that measures an engine. All tests but
one are planar, so that 2-D engines take part in them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from steadyload.engines.registry import engines as registered
from steadyload.engines.registry import engines_here, package_versions, world_class
from steadyload.errors import nearest
from steadyload.progress import NamedProgress, silent
from steadyload.properties import closed_forms as runs
from steadyload.properties.closed_form_tests import (
    ClosedFormResult,
    ClosedFormTest,
    closed_form_tests,
    result_of,
)
from steadyload.runs.asked import Asked, kept_rows
from steadyload.runs.definition import StudyError
from steadyload.runs.pool import IN_THIS_PROCESS, Executor
from steadyload.runs.provenance import made_on

FREQUENCIES = (90, 240, 1000)

SAMPLING = 240
"""Rate at which an engine that chooses its own steps is sampled [1/s]."""


def _cells(
    engines: Sequence[str] | None, frequencies: Sequence[int], tests: Sequence[ClosedFormTest]
) -> list[tuple[ClosedFormTest, str, int | None]]:
    """Test by test the engines, each with its frequencies; None where it chooses its own steps."""
    names = engines_here() if engines is None else tuple(engines)
    for name in names:
        if name not in registered():
            raise StudyError(f"unknown engine {name!r}; {nearest(name, registered())}")
    own = {name for name in names if world_class(name).capabilities.error_controlled}
    return [
        (test, name, frequency)
        for test in tests
        for name in names
        for frequency in ((None,) if name in own else frequencies)
    ]


class ClosedFormUnit(
    Asked[ClosedFormResult], question="closed form", version=runs.VERSION, sampling=SAMPLING
):
    """A test on an engine at a frequency."""

    test: str
    engine: str
    frequency: int | None
    made_by: Mapping[str, str]

    def describe(self, part: int) -> str:
        """Description of the test for messages."""
        rate = "" if self.frequency is None else f", {self.frequency} Hz"
        return f"{self.test} on {self.engine}{rate}"

    def measure(self) -> ClosedFormResult:
        """Run the test."""
        test = next(test for test in closed_form_tests() if test.name == self.test)
        stage = runs.Stage(self.engine, self.frequency or SAMPLING)
        return result_of(test, stage, self.frequency)


def closed_forms(
    work: Path,
    engines: Sequence[str] | None = None,
    frequencies: Sequence[int] = FREQUENCIES,
    *,
    tests: Sequence[ClosedFormTest] | None = None,
    workers: int | Executor = IN_THIS_PROCESS,
    progress: NamedProgress = silent,
) -> list[ClosedFormResult]:
    """Results of engines, test by test, measured where they are missing.

    Args:
        work: folder of the results; an interrupted run is resumed.
        engines: registered names; those of :func:`engines_here` if None.
        frequencies: substeps a second; an engine that controls its own error runs once.
        tests: a choice of :func:`closed_form_tests`; all if None.
        workers: see :func:`steadyload.runs.store.Store.complete`.
        progress: called with what is done, results done and results in all.

    Raises:
        StudyError: no engine of that name.
        EngineNotInstalledError: the library behind an engine is missing.
        ResultsError: another run is at work in the folder.
    """
    cells = _cells(engines, frequencies, closed_form_tests() if tests is None else tests)
    made = {
        name: made_on(name) | package_versions(("numpy", "scipy"))
        for name in dict.fromkeys(name for _, name, _ in cells)
    }
    units = [ClosedFormUnit(test.name, name, rate, made[name]) for test, name, rate in cells]
    return kept_rows(
        work / "results",
        units,
        ClosedFormResult,
        workers=workers,
        progress=lambda *of: progress("closed forms", *of),
    ).rows
