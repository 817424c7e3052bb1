"""Look for a case that violates a property, and make it as small as it gets."""

from __future__ import annotations

import statistics
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import hypothesis
from hypothesis import HealthCheck, Phase, settings
from hypothesis.errors import Flaky

from steadyload.properties.property import Case, LayoutRefused, MethodUnderTest, Property, Violation

VERSION = 2
"""Of cases and how the smallest one is found: raised when others would be."""


@dataclass(frozen=True, slots=True)
class Counterexample:
    """Smallest case found that violates a property, and the message of the violation."""

    case: Case
    found: str


@dataclass(frozen=True, slots=True)
class Frequency:
    """How often a property is violated, on cases that no smaller one was looked for.

    Attributes:
        violated: number of cases that violate it.
        tested: number of cases that tested it.
        steps: median distance of the failing steps found from those expected, over the violations;
            None where the property is about something else.
    """

    violated: int
    tested: int
    steps: float | None = None


@dataclass(frozen=True, slots=True)
class PropertyResult:
    """Result of testing one property on one method.

    Attributes:
        examples: cases tried; those of the search for a smaller one not counted.
        asked: how many of them tested the property.
        counterexample: None where the property held.
        refused: how many the method refused; they lie outside the range that it declares.
        crashed: why there is no result, where the engine ended the process; empty otherwise.
        frequency: of violations, where there is a counterexample.
    """

    examples: int
    asked: int
    counterexample: Counterexample | None
    refused: int = 0
    crashed: str = ""
    frequency: Frequency | None = None


def search(
    asked: Property, tested: MethodUnderTest, *, examples: int, seed: int, shrink: bool = True
) -> PropertyResult:
    """Test a property on a method, with cases that depend on the arguments alone.

    In a clone they depend on the loaded code, too: hypothesis draws a twentieth of all numbers
    from those that stand in it.

    An exception of the method's own counts as a violation, too, and so does a case that is violated
    at one time and not at another. A case that the method refuses tests nothing. Exceptions of
    the property's own code are raised as they are.

    Args:
        asked: the property.
        tested: the method.
        examples: cases at most; a strategy with fewer ends early.
        seed: of the cases; property and method have their own for each.
        shrink: make a counterexample small, which may take a hundred more cases.
    """
    tried = said = refused = 0
    smallest: Counterexample | None = None

    def check(case: Case) -> None:
        nonlocal tried, said, refused, smallest
        counting = smallest is None
        tried += counting
        try:
            said += asked.check(tested, case) and counting
        except LayoutRefused:
            refused += counting
        except Violation as violation:
            # Hypothesis runs the smallest one last.
            smallest = Counterexample(case, str(violation))
            raise

    phases = (Phase.generate, Phase.shrink) if shrink else (Phase.generate,)
    draw = _drawn_for(asked, tested, examples, seed, phases)
    try:
        draw(check)
    except Flaky:
        if smallest is None:
            raise
        said += 1
        found = f"{smallest.found} (not every time that this case was asked)"
        smallest = Counterexample(smallest.case, found)
    except Violation:
        assert smallest is not None, "what is raised here was raised by the check"
        said += 1
    if smallest is None:
        return PropertyResult(tried, said, None, refused)
    frequency = _frequency(asked, tested, _drawn_for(asked, tested, examples, seed, _ONCE))
    return PropertyResult(tried, said, smallest, refused, frequency=frequency)


_ONCE = (Phase.generate,)

_Check = Callable[[Case], None]


def _drawn_for(
    asked: Property, tested: MethodUnderTest, examples: int, seed: int, phases: Sequence[Phase]
) -> Callable[[_Check], None]:
    """Function that runs a check on the cases that depend on the arguments alone."""

    def run(check: _Check) -> None:
        @hypothesis.seed(zlib.crc32(f"{seed} {asked.name} {tested.spec}".encode()))
        @settings(
            max_examples=examples,
            database=None,
            deadline=None,
            derandomize=False,
            phases=phases,
            suppress_health_check=list(HealthCheck),
            report_multiple_bugs=False,
            print_blob=False,
        )
        @hypothesis.given(asked.cases(tested))
        def each(case: Case) -> None:
            check(case)

        each()

    return run


def _frequency(
    asked: Property, tested: MethodUnderTest, draw: Callable[[_Check], None]
) -> Frequency:
    """Frequency of violations among all cases, none of which ends the search."""
    steps: list[int | None] = []
    said = 0

    def check(case: Case) -> None:
        nonlocal said
        try:
            said += asked.check(tested, case)
        except LayoutRefused:
            pass
        except Violation as violation:
            said += 1
            steps.append(violation.steps)

    draw(check)
    known = [each for each in steps if each is not None]
    return Frequency(len(steps), said, statistics.median(known) if known else None)
