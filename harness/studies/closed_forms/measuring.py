"""Values that engines find in tests of closed forms, measured where they are missing.

A test is a definition with its expected value and a function that measures an engine. All tests but
one are planar, so that 2-D engines take part in them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from steadyload.engines.errors import EngineNotInstalledError
from steadyload.engines.registry import engines_here, package_versions, world_class
from steadyload.properties import closed_forms as runs
from steadyload.properties.closed_form_tests import (
    ClosedFormResult,
    ClosedFormTest,
    closed_form_tests,
    result_of,
)
from steadyload.runs.provenance import made_on
from steadyload.studies.kit import Asked, Lab

FREQUENCIES = (90, 240, 1000)

SECOND_MODEL = "drake"
"""An engine with a contact model of its own; optional, and part of no other comparison."""


class ClosedFormUnit(
    Asked[ClosedFormResult], what="closed form", version=runs.VERSION, sampling=runs.SAMPLING
):
    """A test on an engine at a frequency; None where the engine chooses its own steps."""

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
        stage = runs.Stage(self.engine, self.frequency or runs.SAMPLING)
        return result_of(test, stage, self.frequency)


def with_second_model() -> tuple[tuple[str, ...], dict[str, str]]:
    """Names of the engines that are compared here, with :data:`SECOND_MODEL` after them where it is
    installed; by name, the reason why it is left out.
    """
    try:
        world_class(SECOND_MODEL)
    except EngineNotInstalledError as error:
        return engines_here(), {SECOND_MODEL: str(error)}
    return (*engines_here(), SECOND_MODEL), {}


def measured(
    lab: Lab,
    engines: Sequence[str],
    frequencies: Sequence[int] = FREQUENCIES,
    tests: Sequence[ClosedFormTest] = (),
) -> list[ClosedFormResult]:
    """Results of engines, test by test.

    Args:
        lab: where it runs.
        engines: registered names.
        frequencies: substeps a second; an engine that controls its own error runs once.
        tests: a choice of :func:`closed_form_tests`; empty for all.
    """
    own = {name for name in engines if world_class(name).capabilities.error_controlled}
    made = {name: made_on(name) | package_versions(("numpy", "scipy")) for name in engines}
    units = [
        ClosedFormUnit(test.name, name, frequency, made[name])
        for test in tests or closed_form_tests()
        for name in engines
        for frequency in ((None,) if name in own else frequencies)
    ]
    return lab.measure(units, ClosedFormResult, folder="results", parallel=True).rows
