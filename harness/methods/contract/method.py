"""The contract of methods: a method turns a :class:`Layout` into a :class:`Verdict`."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any, ClassVar, Self

import numpy as np

from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.growing import GrowingLayout
from steadyload.layouts.model.layout import (
    Layout,
    require_layout,
    require_layouts,
)
from steadyload.methods.contract.declared import EVERY_LAYOUT, LayoutRange, MovementLimits, Trait
from steadyload.methods.contract.loader import Loader as Loader
from steadyload.methods.contract.spec import MethodSpec, SpecError
from steadyload.methods.contract.stopwatch import Phase as Phase
from steadyload.methods.contract.stopwatch import Seconds as Seconds
from steadyload.methods.contract.stopwatch import Stopwatch as Stopwatch
from steadyload.methods.contract.verdict import STABLE as STABLE
from steadyload.methods.contract.verdict import BatchFindings
from steadyload.methods.contract.verdict import BatchVerdicts as BatchVerdicts
from steadyload.methods.contract.verdict import Effort as Effort
from steadyload.methods.contract.verdict import Finding as Finding
from steadyload.methods.contract.verdict import Status as Status
from steadyload.methods.contract.verdict import Verdict as Verdict
from steadyload.methods.contract.verdict import verdict_of as verdict_of
from steadyload.numbers import seconds_allowed
from steadyload.time_limit import TimeoutExpiredError as TimeoutExpiredError


class RefusedError(Exception):
    """A method does not apply to a layout; becomes a verdict with status ``refused``."""


class NotStepwiseError(SpecError):
    """A method that cannot judge single steps."""


class NotBatchedError(SpecError):
    """A method that cannot judge a batch of layouts at once."""


def verdict_by(
    find: Callable[[Stopwatch], Finding],
    item_count: int,
    timeout: float | None,
    layout: Layout | None = None,
) -> Verdict:
    """Verdict of a judgement, with the time that it takes.

    Args:
        find: judges; may raise :class:`RefusedError` and :class:`TimeoutExpiredError`.
        item_count: of the layout.
        timeout: of :meth:`Method.judge`.
        layout: that is judged, where the verdict keeps it.
    """
    watch = Stopwatch(timeout)
    finding = finding_by(find, watch)
    cpu, wall = watch.stop()
    return verdict_of(finding, item_count, cpu, wall, layout)


def finding_by(find: Callable[[Stopwatch], Finding], watch: Stopwatch) -> Finding:
    """The finding of a judgement, also where it refuses or takes too long.

    Args:
        find: see :func:`verdict_by`.
        watch: of the judgement.
    """
    try:
        return find(watch)
    except RefusedError as error:
        return Finding(status=Status.REFUSED, reason=str(error))
    except TimeoutExpiredError as error:
        return Finding(status=Status.TIMEOUT, reason=str(error))


class WholeLoader(Loader):
    """A loader for any method: judges the whole layout at every placement, so its cost grows."""

    def __init__(self, method: Method, layout: GrowingLayout) -> None:
        super().__init__(layout)
        self._method = method

    def place(self, watch: Stopwatch) -> Finding:
        """See :meth:`Loader.place`."""
        return self._method._judge(self.layout.layout(), watch)

    def go_back(self, count: int) -> None:
        """Nothing is kept."""

    def fork(self, layout: GrowingLayout) -> WholeLoader:
        """See :meth:`Loader.fork`."""
        return WholeLoader(self._method, layout)


class StepScorer(ABC):
    """Scores of single steps of one layout by one method, each step judged by itself.

    Steps are scored in ascending order; any of them may be left out. All steps before are taken to
    be stable, whatever the method's own verdict on them.

    Attributes:
        decision_threshold: the step score above which the method itself calls a step unstable.
        ignored, emulated: as in a :class:`Verdict`.
    """

    decision_threshold: float
    ignored: tuple[str, ...] = ()
    emulated: tuple[str, ...] = ()

    @property
    def effort(self) -> Effort:
        """Effort of everything simulated so far."""
        return Effort()

    @abstractmethod
    def step_score(self, step: int) -> float:
        """Score of a step on the method's own scale, higher where the step is less stable; not
        a number where the method has none.
        """

    def finding(self, step: int) -> Finding:
        """Finding on the step scored last: how it fails, or why it has no step score."""
        return Finding(failing_step=step)

    def close(self) -> None:
        """Release resources. Closing twice is allowed."""


class Method(ABC):
    """A method with fixed parameters.

    A subclass declares ``Parameters`` (a frozen dataclass, see :mod:`.spec`) and :attr:`traits`,
    and implements :meth:`_judge`. One that can judge single steps overrides :meth:`steps`, too.

    Args:
        spec: the method's identity; parses and prints back.
        parameters: an instance of ``Parameters``.
    """

    Parameters: ClassVar[type[Any]]
    needs_engine: ClassVar[bool] = False
    title: ClassVar[str] = ""
    """Name in tables and legends; empty for the registered name."""
    version: ClassVar[int] = 1
    """Version of the class's own code: raised by hand when it gives other verdicts."""
    built_on: ClassVar[Mapping[str, int]] = {}
    """Versions of the parts that the class builds on, by name; see :meth:`parts`."""
    packages: ClassVar[tuple[str, ...]] = ("numpy",)
    """Packages whose numbers the class's own code builds on; see :meth:`numerics`."""

    def __init__(self, spec: MethodSpec, parameters: Any) -> None:
        self.spec = spec
        self.parameters = parameters

    def __str__(self) -> str:
        return str(self.spec)

    def anew(self) -> Self:
        """The same method, which has read none of the files that it names yet."""
        return type(self)(self.spec, self.parameters)

    @property
    def traits(self) -> frozenset[Trait]:
        """Traits that the method declares of itself with its parameters."""
        return frozenset()

    @property
    def layout_range(self) -> LayoutRange:
        """The layouts that the method judges, where it was made for some alone."""
        return EVERY_LAYOUT

    @property
    def movement_limits(self) -> MovementLimits | None:
        """The movements that its verdict is about; None where any loss of balance fails a step."""
        return None

    @classmethod
    def parameters_on(cls, engine: str | None) -> type[Any]:
        """The ``Parameters`` to be bound when the method runs on the named engine."""
        return cls.Parameters

    @classmethod
    def implied_by(cls, values: Mapping[str, Any]) -> Mapping[str, Any]:
        """Values of parameters that come with others, unless they are stated, too.

        Args:
            values: as a spec states them, as texts.
        """
        return {}

    @property
    def trained(self) -> str:
        """Hash of the weights that were trained; empty where there are none."""
        return ""

    def made_of(self) -> str:
        """Hash of everything that determines verdicts besides parameters and code, such as trained
        weights; empty where there is nothing.
        """
        return ""

    def parts(self) -> Mapping[str, int]:
        """Versions of the parts that verdicts come from, by name of the part.

        A stored verdict stays valid until one of them is raised. That is done by hand, where
        verdicts change: moving, renaming or speeding up code raises none.
        """
        return {"method": self.version, **self.built_on}

    def numerics(self) -> frozenset[str]:
        """Names of the packages that verdicts come from: another version makes them stale."""
        return frozenset(self.packages)

    def classes(self) -> tuple[type, ...]:
        """The classes that verdicts come from; those of other distributions have no versions of
        parts, so that their source stands for them.
        """
        return (type(self),)

    def prepare(self, item_count: int = 0) -> None:
        """Make ready for layouts of up to ``item_count`` items.

        Raises errors that concern the user before judging starts, and takes one-time costs
        (imports, compilation) out of the first judgement.
        """

    def judge(self, layout: Layout, *, timeout: float | None = None) -> Verdict:
        """Judge one layout. A judgement that fails gives a verdict with another status than done.

        Args:
            layout: any valid layout.
            timeout: CPU seconds after which a long judgement ends with status ``timeout``, with a
                backstop of wall time (:mod:`steadyload.time_limit`); looked at between engine
                calls, so a single call may overrun it.

        Raises:
            LayoutError: it is no layout.
            NumberError: the timeout is no finite number above 0.
        """
        require_layout(layout)
        return verdict_by(lambda watch: self._judge(layout, watch), len(layout), timeout, layout)

    def judge_many(
        self, layouts: Iterable[Layout], *, timeout: float | None = None
    ) -> list[Verdict]:
        """Judge layouts, in order, as :meth:`judge` does.

        Where the method judges batches, all are judged at once; what does not stand is then looked
        at by itself, for the item and the reason. Each verdict has its share of the time.

        Args:
            layouts: any valid layouts; a batch is one.
            timeout: of :meth:`judge`, for each layout that is judged by itself.

        Raises:
            NumberError: the timeout is no finite number above 0.
        """
        watch = Stopwatch()  # to make a batch of layouts is a part of judging them
        given = layouts if isinstance(layouts, LayoutBatch) else require_layouts(layouts)
        try:
            batch = given if isinstance(given, LayoutBatch) else LayoutBatch.of(given)
            found = self.findings(batch, timeout=timeout, watch=watch)
        except NotBatchedError:
            return [self.judge(layout, timeout=timeout) for layout in given]
        return found.verdicts(batch.item_counts.tolist())

    def findings(
        self, batch: LayoutBatch, *, timeout: float | None = None, watch: Stopwatch | None = None
    ) -> BatchFindings:
        """Judge a batch as :meth:`judge_many` does, without an object a layout that is stable.

        Args:
            batch: any valid layouts.
            timeout: of :meth:`judge`, for each layout that is judged by itself.
            watch: that runs already; None for one from now on.

        Raises:
            NotBatchedError, NumberError: see :meth:`evaluate` and :meth:`judge`.
        """
        seconds_allowed(timeout)
        watch, found = watch or Stopwatch(), self.evaluate(batch)
        fails, apart = found.failing_step >= 0, dict[int, Finding]()
        for k in np.flatnonzero(fails | (found.status != Status.DONE)).tolist():
            if found.finding is None or not fails[k]:
                apart[k] = finding_by(partial(self._judge, batch[k]), Stopwatch(timeout))
            else:
                apart[k] = found.finding(k)
        return BatchFindings(apart, *(spent.shared(len(batch)) for spent in watch.stop()))

    @property
    def batched(self) -> bool:
        """Whether it judges batches, in compiled code, see :meth:`evaluate`."""
        return type(self).evaluate is not Method.evaluate

    def evaluate(self, batch: LayoutBatch) -> BatchVerdicts:
        """Judge all layouts of a batch at once, in compiled code that any thread may run.

        A class that judges batches defines this beside its :meth:`_judge`.

        Args:
            batch: the layouts.

        Raises:
            NotBatchedError: the method judges one layout at a time.
        """
        raise NotBatchedError(f"{self.spec}: judges one layout at a time, not batches")

    def __init_subclass__(cls, **arguments: Any) -> None:
        """A class that judges in a way of its own does not judge batches as its base does."""
        super().__init_subclass__(**arguments)
        if "_judge" in vars(cls) and "evaluate" not in vars(cls):
            cls.evaluate = Method.evaluate  # type: ignore[method-assign]

    def begin(self, layout: GrowingLayout) -> Loader:
        """A loader that judges placements on a layout while it grows.

        The default judges all of the layout at every placement. A method whose verdict on a step
        takes less than that overrides it.

        Args:
            layout: without items yet; whoever calls puts items on it and takes them off.
        """
        return WholeLoader(self, layout)

    def steps(self, layout: Layout, watch: Stopwatch) -> StepScorer:
        """Scores of single steps of a layout, as a cascade needs them.

        Args:
            layout: any valid layout.
            watch: of the judgement in progress.

        Raises:
            NotStepwiseError: the method judges whole loadings alone.
            RefusedError: the method does not apply to the layout.
        """
        raise NotStepwiseError(f"{self.spec}: judges whole loadings, no single steps")

    @abstractmethod
    def _judge(self, layout: Layout, watch: Stopwatch) -> Finding:
        """The judgement itself; may raise :class:`RefusedError`."""


def judge(method: Method, layout: Layout, timeout: float | None = None) -> Verdict:
    """Like :meth:`Method.judge`, but an unexpected exception becomes a verdict ``error``.

    Raises:
        NumberError: the timeout is no finite number above 0.
    """
    seconds_allowed(timeout)
    try:
        return method.judge(layout, timeout=timeout)
    except Exception as error:
        reason = f"{type(error).__name__}: {error}"
        return Verdict(len(layout), Status.ERROR, reason=reason, layout=layout)
