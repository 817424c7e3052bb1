"""The nearest plan that stands by the word of another judge than the search."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Generic, TypeVar

from steadyload.layouts.model.growing import numbered
from steadyload.layouts.model.layout import Layout
from steadyload.repairing.loading_order import OF_MOVED
from steadyload.repairing.plan import Boxes, Kind, Worth
from steadyload.repairing.search import MARGIN, Attempt, Search
from steadyload.time_limit import TimeLimit, TimeoutExpiredError

MARGINS = (MARGIN, OF_MOVED, 1.0, 2.0, 4.0)
"""Margins of balance [cm]: a box at fault gets the next larger one that it can have."""

_PATIENCE, _WITH_BOXES_LEFT, _WITHOUT_A_PLAN = 50, 1000, 10_000
"""Tries without a better plan after which the search ends: where all boxes are kept, where some are
left out, and where these have to be kept, so that there is no plan yet."""

_OF_FEW = 2000
"""More of these, divided by the number of boxes: tries with few boxes take little time."""

_CORRECTIONS = 25
"""Plans that are corrected one after the other until one is confirmed, at most."""

_ANY = 10**9
"""More boxes than there are."""

_NEARER = 0.01
"""Share of the distance by which a plan that differs in nothing else has to be nearer."""


class Stopped(StrEnum):
    """End of a search: nothing better was found any more, the time was up, or a user ended it."""

    DONE = "done"
    TIME = "time"
    INTERRUPTED = "interrupted"


@dataclass(frozen=True)
class Confirmation:
    """Answer of the judge on a changed plan.

    Attributes:
        stands: it does.
        at_fault: steps of the boxes at fault; empty where it stands, or where none is known.
    """

    stands: bool
    at_fault: tuple[int, ...] = ()


Said = TypeVar("Said", bound=Confirmation)


@dataclass(frozen=True)
class Found(Generic[Said]):
    """Result of a search.

    Attributes:
        attempt: the nearest plan that was confirmed; None where none was.
        confirmation: the judge's answer on it; likewise.
        nearest: the best plan that was not, where none was; None where none was searched.
        stopped: what ended the search.
        tried: plans that were searched.
        judged: plans that the judge was given.
    """

    attempt: Attempt | None
    confirmation: Said | None
    nearest: Attempt | None
    stopped: Stopped
    tried: int
    judged: int


def changed_plan(boxes: Boxes, attempt: Attempt) -> Layout:
    """The layout of an attempt, under the name of the plan."""
    items = [
        numbered(boxes.item(box, attempt.places[box]), step)
        for step, box in enumerate(attempt.order)
    ]
    return Layout(boxes.layout.name, boxes.layout.pallet, tuple(items))


class ConfirmedSearch(Generic[Said]):
    """Searches, has the judge confirm what is better, and corrects what it does not confirm.

    Args:
        boxes: of the plan.
        allowed: what may change.
        shift_cm: how far a box that is shifted may move sideways.
        seed: of random choices.
        judge: says whether a changed plan stands.
        seconds: CPU time after which the search ends where a plan is confirmed, the judge's
            included.
        margin: of balance that boxes are to have [cm].
        without: CPU time after which it ends where none is; None for ``seconds``.
    """

    def __init__(
        self,
        boxes: Boxes,
        allowed: Collection[Kind],
        shift_cm: float,
        seed: int,
        judge: Callable[[Layout], Said],
        seconds: float,
        margin: float = MARGIN,
        without: float | None = None,
    ) -> None:
        self._boxes, self._allowed, self._judge = boxes, allowed, judge
        self._search = Search(boxes, allowed, shift_cm, seed, lambda: self._limit.check(), margin)
        self._whole = TimeLimit(seconds, "repair")
        self._limit = self._whole if without is None else TimeLimit(without, "repair")
        self._tried = self._judged = 0
        self._best: Attempt | None = None
        self._said: Said | None = None
        self._base: Attempt | None = None

    def run(self) -> Found[Said]:
        """Search until nothing better is found, the time is up, or a user interrupts.

        Raises:
            KeyboardInterrupt: before any plan was confirmed.
        """
        stopped = Stopped.DONE
        try:
            self._run()
        except TimeoutExpiredError:
            stopped = Stopped.TIME
        except KeyboardInterrupt:
            if self._best is None:
                raise
            stopped = Stopped.INTERRUPTED
        nearest = self._base if self._best is None else None
        return Found(self._best, self._said, nearest, stopped, self._tried, self._judged)

    def _run(self) -> None:
        self._tried += 1
        first = self._search.complete(self._boxes.planned)
        assert first is not None, "a search without a bound gives up nothing"
        self._base = walker = self._corrected(first)
        if not self._search.places.exist:
            return
        stalled = 0
        while self._base.worth.moved + self._base.worth.left > 0 and stalled <= self._patience():
            stalled += 1
            bound, keeps_all = self._bound(), not self._base.worth.left
            start = self._search.neighbour(self._base if keeps_all else walker)
            self._tried += 1
            found = self._search.complete(start, bound if keeps_all else _as_full(walker.worth))
            if found is None:
                continue
            if not keeps_all and found.worth < _as_full(walker.worth):
                walker = found
            if bound is not None and not _is_better(found.worth, bound):
                continue
            corrected = self._corrected(found)
            if bound is None or corrected.worth < bound:
                stalled, self._base = 0, corrected
                walker = corrected
        self._tried += 1
        nearer = self._search.nearer(self._base)
        if _is_better(nearer.worth, self._base.worth):
            self._corrected(nearer)

    def _bound(self) -> Worth | None:
        """The worth that a plan has to improve; None where any that is confirmed does."""
        assert self._base is not None, "the search has begun"
        return self._base.worth if self._best is not None or self._lacks(self._base) else None

    def _lacks(self, attempt: Attempt) -> bool:
        """Whether boxes are left out that have to be kept: any, unless that is allowed, or all."""
        return attempt.worth.left > 0 and (Kind.LEAVE not in self._allowed or not attempt.order)

    def _patience(self) -> int:
        """Tries without a better plan after which the search ends."""
        assert self._base is not None, "the search has begun"
        if self._lacks(self._base):
            return _WITHOUT_A_PLAN
        least = _WITH_BOXES_LEFT if self._base.worth.left else _PATIENCE
        return least + _OF_FEW // len(self._boxes)

    def _corrected(self, attempt: Attempt) -> Attempt:
        """The attempt with boxes at fault moved until the judge confirms it, or it is no better.

        What is confirmed is the best plan so far.
        """
        for _ in range(_CORRECTIONS):
            if self._lacks(attempt):
                break
            self._judged += 1
            confirmation = self._judge(changed_plan(self._boxes, attempt))
            if confirmation.stands:
                self._best, self._said, self._limit = attempt, confirmation, self._whole
                break
            self._ask_for_more(attempt, confirmation)
            self._tried += 1
            bound = None if self._best is None else self._best.worth
            corrected = self._search.complete(attempt.places, bound)
            if corrected is None:
                assert self._best is not None, "there is a bound"
                return self._best
            attempt = corrected
        return attempt

    def _ask_for_more(self, attempt: Attempt, confirmation: Confirmation) -> None:
        """Give boxes at fault, or all where none is known, the next larger margin.

        A place at which a box is at fault with the largest one is not taken any more.
        """
        steps = confirmation.at_fault or range(len(attempt.order))
        for box in {attempt.order[step] for step in steps}:
            place, loading = attempt.places[box], self._search.loading
            is_moved = bool((place != self._boxes.planned[box]).any())
            now = loading.margins[int(is_moved), box]
            larger = [m for m in MARGINS if now < m <= self._search.most[box]]
            if larger:
                loading.set_margin(box, larger[0])
            else:
                loading.refuse(box, place)


def _as_full(worth: Worth) -> Worth:
    """A bound that a plan keeps to which leaves out no more, whatever else it changes.

    As long as boxes are left out, a search goes from plan to plan that are as full, to places that
    no single step from the best one leads to.
    """
    return replace(worth, moved=_ANY, distance=0.0, reordered=0)


def _is_better(new: Worth, old: Worth) -> bool:
    """Whether a plan is worth being judged."""
    if (new.left, new.volume, new.moved) != (old.left, old.volume, old.moved):
        return new < old
    return new.distance < (1.0 - _NEARER) * old.distance
