"""Properties: cases drawn by a strategy, and a check that a method passes or violates."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property

from hypothesis.strategies import SearchStrategy

from steadyload.engines.registry import world_class
from steadyload.engines.world import Capabilities
from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.declared import EVERY_LAYOUT, Trait
from steadyload.methods.contract.method import Method, Status, Verdict
from steadyload.methods.registry import make_method
from steadyload.properties.transforms import brought_within
from steadyload.statistics.placed import items_placed


class Violation(Exception):  # noqa: N818 - what a check finds, no fault of the program
    """A property does not hold.

    Args:
        message: says what was found and what was expected.
        steps: distance of the failing step found from the expected one, a stable layout failing
            after all; None where the property is about something else.
    """

    def __init__(self, message: str, *, steps: int | None = None) -> None:
        super().__init__(message)
        self.steps = steps


class LayoutRefused(Exception):  # noqa: N818 - a result, no fault of the program
    """The method refuses a layout: it lies outside the range that the method declares."""


@contextmanager
def errors_as_violations() -> Iterator[None]:
    """Turn every exception of a method or an engine into a :class:`Violation`.

    Exceptions of a property's own code are faults of that code, and no violation.
    """
    try:
        yield
    except Exception as error:
        raise Violation(f"{type(error).__name__}: {error}") from error


@dataclass(frozen=True, slots=True)
class Case:
    """Case of a property: the layout, and whatever else was drawn.

    Attributes:
        layout: the layout as it is to be judged first.
        change: what else was drawn, by name; for people.
    """

    layout: Layout
    change: Mapping[str, float] = field(default_factory=dict)


class MethodUnderTest:
    """A method under test, with its declared traits and capabilities.

    Args:
        spec: the method's spec string.

    Raises:
        SpecError: no such method, engine or parameter.
    """

    def __init__(self, spec: str) -> None:
        self.method: Method = make_method(spec)
        self.spec = str(self.method.spec)

    @property
    def engine(self) -> str | None:
        """The engine that the method runs on, if any."""
        return self.method.spec.engine

    @cached_property
    def capabilities(self) -> Capabilities | None:
        """Capabilities of the engine; None without one."""
        return world_class(self.engine).capabilities if self.engine else None

    @property
    def planar(self) -> bool:
        """Judges planar layouts only."""
        return self.capabilities is not None and self.capabilities.dimensions == 2

    def within_range(self, drawn: SearchStrategy[Layout]) -> SearchStrategy[Layout]:
        """Drawn layouts, made into ones of the range that the method declares."""
        declared = self.method.layout_range
        if declared == EVERY_LAYOUT:
            return drawn
        return drawn.map(lambda layout: brought_within(layout, declared))

    def has(self, trait: Trait) -> bool:
        """True if the method declares a trait."""
        return trait in self.method.traits

    def verdict(self, layout: Layout) -> Verdict:
        """The verdict on a layout.

        Raises:
            LayoutRefused: the method refuses the layout.
            Violation: there is none (diverged, error), or the method raised an exception.
        """
        with errors_as_violations():
            verdict = self.method.judge(layout)
        check_done(verdict.status, verdict.reason)
        return verdict


def check_done(status: Status, reason: str) -> None:
    """Check that a judgement ended with a verdict.

    Raises:
        LayoutRefused: the method refused the layout.
        Violation: it ended otherwise.
    """
    if status is Status.REFUSED:
        raise LayoutRefused(reason)
    if status is not Status.DONE:
        raise Violation(f"no verdict: {status} ({reason})")


Check = Callable[[MethodUnderTest, Case], bool]
"""Raises :class:`Violation` or :class:`LayoutRefused`. Returns whether the case tested anything:
False where the property requires nothing of it."""


@dataclass(frozen=True, slots=True)
class Property:
    """A property that methods must have.

    Attributes:
        name: in registries and on the command line.
        about: one sentence that says what must hold.
        cases: the strategy of its cases, for a method.
        check: tests a method on a case.
        applies: true if the property is tested on a method, by what that declares.
        version: raised by hand when it asks something else; stored results are stale then.
        share: of the cases of others; less than 1 where a case takes many simulations.
    """

    name: str
    about: str
    cases: Callable[[MethodUnderTest], SearchStrategy[Case]]
    check: Check
    applies: Callable[[MethodUnderTest], bool] = lambda tested: True
    version: int = 1
    share: float = 1.0


def declaring(trait: Trait) -> Callable[[MethodUnderTest], bool]:
    """A property's ``applies``: true for methods that declare a trait."""
    return lambda tested: tested.has(trait)


def steps_between(layout: Layout, first: int | None, second: int | None) -> int:
    """Distance of two failing steps of a layout, a stable one failing after all its items."""
    return abs(items_placed(first, len(layout)) - items_placed(second, len(layout)))


def spoken(failing_step: int | None) -> str:
    """A failing step in words."""
    return "stable" if failing_step is None else f"fails at step {failing_step}"
