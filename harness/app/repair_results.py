"""Results of repairs: one a plan, as sentences and as records."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from steadyload.app.answers import Check
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import Item, Layout
from steadyload.notebook import ShownInNotebook
from steadyload.repairing.changes import Change
from steadyload.repairing.confirmed import Stopped
from steadyload.statics.load_margin import LoadMargin


class Outcome(StrEnum):
    """Outcome of a repair.

    ``unchanged``: the plan stands as it is. ``repaired``: a changed plan stands. ``not repaired``:
    none was found. ``bad input``: the layout is not valid.
    """

    UNCHANGED = "unchanged"
    REPAIRED = "repaired"
    NOT_REPAIRED = "not repaired"
    BAD_INPUT = "bad input"


@dataclass(frozen=True, slots=True)
class Repair(ShownInNotebook):
    """The nearest plan that stands.

    Attributes:
        name: of the layout.
        outcome: see :class:`Outcome`.
        layout: the plan that stands, or the one that was given where none was found; None where
            it is not valid.
        origins: of every item of ``layout`` its step in the plan that was given.
        changes: what differs, in words by :meth:`Change.sentence`.
        left_out: the boxes that are left out, as they were.
        judged_by: spec of the method that says so.
        before: its answer on the plan that was given; None where that is not valid.
        after: its answer on ``layout``; ``before`` where nothing was changed.
        chance: the probability that a repaired plan balances, with its gaps closed, where every
            centre of mass is off by 5 mm (s.d.), 0 to 1; None where there is none.
        reason: why there is no plan that stands; else empty.
        stopped: what ended the search.
        seconds: CPU time.
        file: that it was read from; empty for none.
        frame: axes and unit of all sentences.
    """

    name: str
    outcome: Outcome
    layout: Layout | None
    origins: tuple[int, ...] = ()
    changes: tuple[Change, ...] = ()
    left_out: tuple[Item, ...] = ()
    judged_by: str = ""
    before: Check | None = None
    after: Check | None = None
    chance: float | None = None
    reason: str = ""
    stopped: Stopped = Stopped.DONE
    seconds: float = 0.0
    file: str = ""
    frame: Frame = Frame()

    @property
    def stands(self) -> bool:
        """Whether ``layout`` stands."""
        return self.after is not None and self.after.stands

    @property
    def by_order_alone(self) -> bool:
        """Whether it stands by another order of loading, every box at its place."""
        reordered = self.outcome is Outcome.REPAIRED and not self.left_out
        return reordered and not any(change.moved for change in self.changes)

    @property
    def moved(self) -> int:
        """Number of boxes at another place."""
        return sum(change.moved for change in self.changes)

    @property
    def distance_cm(self) -> float:
        """How far these are moved, all together [cm]."""
        return sum(change.distance_cm for change in self.changes)

    @property
    def sentences(self) -> list[str]:
        """The changes in words, in the axes and the unit of the frame."""
        return [change.sentence(self.frame) for change in self.changes]

    @property
    def sentence(self) -> str:
        """The outcome in a few words."""
        if self.outcome is Outcome.UNCHANGED:
            return "stands as it is"
        if self.outcome in (Outcome.NOT_REPAIRED, Outcome.BAD_INPUT):
            return f"{self.outcome}: {self.reason}"
        if self.by_order_alone:
            return f"stands{self._by}, by another order of loading alone"
        said = [f"{_boxes(self.moved)} moved"] if self.moved else []
        if self.left_out:
            said.append(f"{_boxes(len(self.left_out))} left out")
        reordered = sum(bool(change.before or change.after) for change in self.changes)
        if reordered:
            said.append(f"{_boxes(reordered)} loaded at another time")
        return f"stands{self._by}: {', '.join(said)}"

    @property
    def margin(self) -> LoadMargin | None:
        """The margin of a repaired plan; None where there is none that is known."""
        if self.outcome is not Outcome.REPAIRED or self.after is None:
            return None
        return self.after.margin

    @property
    def _by(self) -> str:
        """The margin of a repaired plan, to follow "stands"."""
        return "" if self.margin is None else f", by {self.margin.words(self.frame)}"

    def __str__(self) -> str:
        judged_by = f" [{self.judged_by}]" if self.judged_by else ""
        return "; ".join([f"{self.name}: {self.sentence}{judged_by}", *self.sentences])

    def to_dict(self) -> dict[str, Any]:
        """The repair as values that JSON can hold, with units in the names."""
        left = {change.step for change in self.changes if change.new_step is None}
        return {
            "layout": self.name,
            "file": self.file,
            "outcome": str(self.outcome),
            "items": None if self.layout is None else len(self.layout) + len(self.left_out),
            "judged_by": self.judged_by,
            "answer_before": None if self.before is None else str(self.before.answer),
            "failing_step_before": _failing(self.before),
            "answer_after": None if self.after is None else str(self.after.answer),
            "margin_cm": None if self.margin is None else round(self.margin.cm, 3),
            "margin_kind": None if self.margin is None else str(self.margin.kind),
            "chance_5mm": self.chance,
            "by_order_alone": self.by_order_alone,
            "boxes_moved": self.moved,
            "distance_cm": round(self.distance_cm, 6),
            "boxes_left_out": len(left),
            "steps_left_out": sorted(left),
            "changes": [
                {**change.to_dict(), "sentence": sentence}
                for change, sentence in zip(self.changes, self.sentences, strict=True)
            ],
            "reason": self.reason,
            "stopped": str(self.stopped),
            "cpu_seconds": self.seconds,
        }


def repair_fields(repair: Repair | None) -> dict[str, Any]:
    """A repair as further fields of the record of a check; None for a load that needs none."""
    done = repair is not None and repair.outcome is Outcome.REPAIRED
    return {
        "repair_outcome": None if repair is None else str(repair.outcome),
        "repair_sentence": None if repair is None else repair.sentence,
        "repair_margin_cm": repair.margin.cm if repair and repair.margin else None,
        "repair_chance_5mm": repair.chance if repair and done else None,
        "repair_by_order_alone": repair.by_order_alone if repair and done else None,
        "repair_boxes_moved": repair.moved if repair and done else None,
        "repair_distance_cm": round(repair.distance_cm, 6) if repair and done else None,
        "repair_boxes_left_out": len(repair.left_out) if repair and done else None,
        "repair_changes": [] if repair is None else repair.sentences,
    }


def counted_repairs(repairs: Iterable[Repair]) -> str:
    """How many plans stand as they are, were repaired, and were not, in words."""
    numbers = Counter(one.outcome for one in repairs)
    unchanged = numbers[Outcome.UNCHANGED]
    said = [f"{unchanged} stand as they are" if unchanged != 1 else "1 stands as it is"]
    said += [
        f"{numbers[outcome]} {outcome}"
        for outcome in Outcome
        if outcome is not Outcome.UNCHANGED and (numbers[outcome] or outcome is Outcome.REPAIRED)
    ]
    return ", ".join(said)


def _failing(answer: Check | None) -> int | None:
    return None if answer is None or answer.verdict is None else answer.verdict.failing_step


def _boxes(count: int) -> str:
    return f"{count} box{'es' if count != 1 else ''}"
