"""Closed-form tests of engines and the engines' results."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ClosedFormTest:
    """A quantity whose value is known from mechanics.

    ``series`` is the heading; tests that differ in one number share it and have that number as
    ``argument``, named ``argument_name``. ``expected`` is in ``unit``. An error is the difference
    in ``unit``, or in per cent of the expected value where ``relative``. ``resolution``, in the
    unit of the error: smaller errors count as none. ``when_soft``: the reason why an engine with
    compliant contact and regularised friction cannot be exact here, however small its steps.
    """

    name: str
    series: str
    definition: str
    expected: float
    unit: str
    relative: bool
    resolution: float
    argument: float | None = None
    argument_name: str = ""
    when_soft: str = ""

    @property
    def error_unit(self) -> str:
        """Per cent, or the unit of the measured quantity."""
        return "%" if self.relative else self.unit


@dataclass(frozen=True, slots=True)
class ClosedFormResult:
    """Result of one engine: ``found`` in the test's unit, ``error`` in its error unit.

    ``frequency`` is None for an engine that chooses its own steps. ``note`` gives the reason why
    there is no value, or a remark on it.
    """

    test: str
    engine: str
    frequency: int | None
    found: float | None
    error: float | None
    note: str = ""
