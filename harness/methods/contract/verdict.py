"""Verdicts: what a method says of a layout, or of many at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.naming import NAMELESS, Named, label_in, with_ids
from steadyload.methods.contract.stopwatch import Seconds
from steadyload.notebook import ShownInNotebook
from steadyload.statistics.placed import items_placed


class Status(StrEnum):
    """Status of a verdict: how the judgement ended. Only ``done`` has a score.

    ``unsettled``: a method that was asked whether the load stands saw it still move at the end.
    """

    DONE = "done"
    UNSETTLED = "unsettled"
    DIVERGED = "diverged"
    TIMEOUT = "timeout"
    CRASHED = "crashed"
    REFUSED = "refused"
    ERROR = "error"


@dataclass(frozen=True, slots=True)
class Effort:
    """Counts of a simulation's work: the same on every machine. All zero for other methods.

    Attributes:
        worlds: opened.
        boxes: put into worlds, each time anew.
        looks: readings of poses or velocities.
        substeps: engine steps.
        body_substeps: engine steps times the boxes that take part.
    """

    worlds: int = 0
    boxes: int = 0
    looks: int = 0
    substeps: int = 0
    body_substeps: int = 0

    def __add__(self, other: Effort) -> Effort:
        return Effort(
            self.worlds + other.worlds,
            self.boxes + other.boxes,
            self.looks + other.looks,
            self.substeps + other.substeps,
            self.body_substeps + other.body_substeps,
        )


@dataclass(frozen=True, slots=True)
class Verdict(ShownInNotebook):
    """Verdict of a method on a layout.

    Attributes:
        item_count: J, the number of items in the layout.
        status: how the judgement ended.
        failing_step: counted from 0, equals the number of items placed safely; None when the whole
            layout is stable or when there is no verdict.
        moved_item: sequence number of the item that violated the criterion at the failing step.
        displacement: how far that item moved [cm], None for static methods.
        rotation: the largest angle it turned by [degrees], None for static methods.
        reason: one sentence; empty for a stable layout.
        ignored, emulated: settings requested that the engine ignored, or imitated by other means.
        effort: what was simulated.
        stage: spec of the method that decided, where the method has stages; else empty.
        cpu, wall: time spent.
        layout: that was judged, for its picture; None where many were judged at once or a session
            judged. Verdicts are compared without it.
    """

    item_count: int
    status: Status = Status.DONE
    failing_step: int | None = None
    moved_item: int | None = None
    displacement: float | None = None
    rotation: float | None = None
    reason: str = ""
    ignored: tuple[str, ...] = ()
    emulated: tuple[str, ...] = ()
    effort: Effort = Effort()
    stage: str = ""
    cpu: Seconds = Seconds()
    wall: Seconds = Seconds()
    layout: Layout | None = field(default=None, repr=False, compare=False)

    @property
    def stable(self) -> bool:
        """The whole layout can be loaded."""
        return self.status is Status.DONE and self.failing_step is None

    @property
    def score(self) -> float | None:
        """Loading stability ls(A), Eq. 2: items placed safely / J; None without a verdict."""
        placed = self.items_placed
        return None if placed is None else placed / self.item_count

    @property
    def items_placed(self) -> int | None:
        """Number of items placed safely; None without a verdict."""
        if self.status is not Status.DONE:
            return None
        return items_placed(self.failing_step, self.item_count)

    @property
    def item_at_fault(self) -> int | None:
        """The item that moved too far, or that of the failing step where none is known to move."""
        return self.failing_step if self.moved_item is None else self.moved_item

    def to_dict(self) -> dict[str, Any]:
        """The fields of :func:`record_of`."""
        return record_of(self)

    def __str__(self) -> str:
        return self.sentence(Frame())

    def sentence(self, frame: Frame) -> str:
        """One line: "fails at box 6 of 20 (score 0.25): box 5 of 20 moved 13.1 cm, 12.0 degrees".

        Args:
            frame: unit of lengths.
        """
        if self.status is not Status.DONE:
            return f"no verdict, {self.status}" + (f": {self.reason}" if self.reason else "")
        if self.failing_step is None:
            return f"stands, all {self.item_count} items placed (score 1)"
        placed = f"box {self.failing_step + 1} of {self.item_count}"
        said = f"fails at {placed} (score {self.score:.3g})"
        items: Sequence[Named] = (NAMELESS,) * self.item_count
        if self.layout is not None:
            items = self.layout.items
        if self.moved_item is None or self.displacement is None:
            return said + (f": {with_ids(self.reason, items)}" if self.reason else "")
        turned = "" if self.rotation is None else f", {self.rotation:.1f} degrees"
        box = label_in(items, self.moved_item)
        return f"{said}: {box} moved {frame.length(self.displacement)}{turned}"


def record_of(verdict: Verdict) -> dict[str, Any]:
    """A verdict as values that JSON can hold, with units in the names.

    Every record, row and table that holds a verdict takes its values from here.
    """
    return {
        "items": verdict.item_count,
        "status": str(verdict.status),
        "score": verdict.score,
        "failing_step": verdict.failing_step,
        "moved_item": verdict.moved_item,
        "displacement_cm": verdict.displacement,
        "rotation_deg": verdict.rotation,
        "reason": verdict.reason,
        "ignored": list(verdict.ignored),
        "emulated": list(verdict.emulated),
        "cpu_seconds": verdict.cpu.total,
        "wall_seconds": verdict.wall.total,
    }


@dataclass(frozen=True, slots=True)
class Finding:
    """A verdict without bookkeeping, as an implementation of :meth:`Method._judge` returns it.

    The fields are those of :class:`Verdict`.
    """

    failing_step: int | None = None
    moved_item: int | None = None
    displacement: float | None = None
    rotation: float | None = None
    reason: str = ""
    status: Status = Status.DONE
    ignored: tuple[str, ...] = ()
    emulated: tuple[str, ...] = ()
    effort: Effort = Effort()
    stage: str = ""


STABLE = Finding()


def verdict_of(
    finding: Finding, item_count: int, cpu: Seconds, wall: Seconds, layout: Layout | None = None
) -> Verdict:
    """The verdict that a finding becomes.

    Args:
        finding: of a judgement.
        item_count: of the layout.
        cpu: time spent.
        wall: likewise.
        layout: see :class:`Verdict`.
    """
    if finding is STABLE:
        return Verdict(item_count, cpu=cpu, wall=wall, layout=layout)
    return Verdict(
        item_count,
        finding.status,
        finding.failing_step,
        finding.moved_item,
        finding.displacement,
        finding.rotation,
        finding.reason,
        finding.ignored,
        finding.emulated,
        finding.effort,
        finding.stage,
        cpu,
        wall,
        layout,
    )


@dataclass(frozen=True, eq=False, slots=True)
class BatchVerdicts:
    """Verdicts on the layouts of a batch, as arrays.

    Attributes:
        status: of every verdict, shape (L,).
        failing_step: counted from 0; -1 where the whole layout is stable or there is no verdict,
            shape (L,).
        displacement: of the item that moved too far [cm], shape (L,); not a number where a method
            states none.
        rotation: its largest angle [degrees], likewise.
        finding: gives the finding on a layout that fails; None where the layout has to be judged by
            itself for it.
    """

    status: NDArray[np.object_]
    failing_step: NDArray[np.int64]
    displacement: NDArray[np.float64]
    rotation: NDArray[np.float64]
    finding: Callable[[int], Finding] | None = None

    @classmethod
    def of_steps(
        cls,
        batch: LayoutBatch,
        steps: NDArray[np.int64] | NDArray[np.int32],
        *,
        unresolved: NDArray[np.bool_] | bool = False,
        finding: Callable[[int], Finding] | None = None,
    ) -> BatchVerdicts:
        """Verdicts of a static method.

        Args:
            batch: the layouts.
            steps: the failing step of each, its number of items where it is stable, shape (L,).
            unresolved: where there is no verdict, shape (L,): the status is ``error``.
            finding: see :class:`BatchVerdicts`.
        """
        status = np.full(len(batch), Status.DONE, dtype=object)
        status[unresolved] = Status.ERROR
        failing = np.where((steps == batch.item_counts) | unresolved, -1, steps.astype(np.int64))
        unknown = np.full(len(batch), math.nan)
        return cls(status, failing, unknown, unknown.copy(), finding)


@dataclass(frozen=True, slots=True)
class BatchFindings:
    """Findings on the layouts of a batch, with the share of the time that each of them has.

    Attributes:
        apart: by place in the batch, of all layouts that are not stable.
        cpu: time spent on each.
        wall: likewise.
    """

    apart: Mapping[int, Finding]
    cpu: Seconds
    wall: Seconds

    def verdicts(self, item_counts: Iterable[int]) -> list[Verdict]:
        """The verdicts, from the numbers of items of the layouts."""
        return [
            verdict_of(self.apart.get(k, STABLE), count, self.cpu, self.wall)
            for k, count in enumerate(item_counts)
        ]
