"""A loading that is judged while it is planned: for packing heuristics and searches."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache, partial
from types import TracebackType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steadyload.errors import UserError, required
from steadyload.escaping import shown
from steadyload.layouts.model.growing import GrowingLayout, numbered
from steadyload.layouts.model.layout import Item, Layout, LayoutError, Pallet, check_name
from steadyload.methods.contract.method import (
    STABLE,
    Finding,
    Method,
    Seconds,
    Status,
    Stopwatch,
    Verdict,
    finding_by,
    verdict_by,
)
from steadyload.methods.contract.verdict import verdict_of
from steadyload.methods.registry import method_of
from steadyload.numbers import seconds_allowed
from steadyload.statics.bearing.crushing import crushed_by_now


class SessionError(UserError):
    """A request that a session cannot meet: says what was requested and what is allowed."""


class LoadingSession:
    """Items are placed one after the other, and each is judged at once.

    What :meth:`try_place` says is what the method says of the whole layout by then; how much of it
    is looked at anew depends on the method (docs/session.md). A session is used by one thread at a
    time; once closed, what it holds can be read and nothing else.

    Args:
        pallet: what is loaded.
        method: a spec string, or a method.
        name: of the layout. Verdicts depend on it only where positions are jittered.
        timeout: CPU seconds that a placement may take, as of :meth:`Method.judge`; the look for
            boxes that bear too much is a part of it.
        timed: verdicts state the time spent. False saves half of a placement by a rule; their times
            are zero then.

    Raises:
        SpecError: there is no such method.
        EngineNotInstalledError: the library of its engine is missing.
        NumberError: the timeout is no finite number above 0.
        SessionError: the pallet is none.
        LayoutError: the name is not printable, or empty.

    Attributes:
        method: that judges.
    """

    def __init__(
        self,
        pallet: Pallet,
        method: str | Method = "sme",
        *,
        name: str = "session",
        timeout: float | None = None,
        timed: bool = True,
    ) -> None:
        required("pallet", pallet, Pallet, "a Pallet", SessionError)
        check_name(name)
        self.method = method_of(method)
        self.method.prepare()
        self._open()
        self._timeout, self._timed, self._limits = seconds_allowed(timeout), timed, False
        self._layout = GrowingLayout(pallet, name)
        self._loader = self.method.begin(self._layout)

    def __len__(self) -> int:
        """Number of loaded items."""
        with self._alone():
            return len(self._layout)

    @property
    def pallet(self) -> Pallet:
        """The pallet that is loaded."""
        return self._layout.pallet

    @property
    def items(self) -> tuple[Item, ...]:
        """Items loaded so far, in order."""
        with self._alone():
            return tuple(self._layout.items)

    def try_place(self, item: Item) -> Verdict:
        """Place an item if the loading stays stable; otherwise the session stays as it was.

        A placement by which a box comes to bear more than its ``max_load`` fails, too.

        Args:
            item: its sequence number is not looked at: it comes next.

        Returns:
            The verdict on the items loaded so far with the new one; the item stays if and only if
            the verdict is ``stable``. Where a box is crushed its ``moved_item`` is that box, and
            the reason says what it bears.

        Raises:
            LayoutError: the item stands out of the pallet's contour or overlaps another.
            SessionError: it is no item; the session is closed, or in use by another thread.
        """
        # As with _alone(), which would take a fifth of the time of a placement by a rule.
        if self._closed or not self._in_use.acquire(False):
            with self._alone(changes=True):
                return self._try_place(item)
        try:
            return self._try_place(item)
        finally:
            self._in_use.release()

    def feasible(self, item: Item, positions: ArrayLike) -> NDArray[np.bool_]:
        """Whether an item would stand on each of many places; nothing is placed.

        By ``fbs``, ``pbs``, ``sme`` and ``equilibrium`` without ``sides`` and ``time``, the places
        are looked at in compiled code. Any other method tries them one by one.

        Args:
            item: its sequence number and its own position are not looked at.
            positions: of its left-bottom-back corner (x, y, z) [cm], shape (K, 3).

        Returns:
            Shape (K,): True where :meth:`try_place` with that position gives a ``stable`` verdict;
            False also where the item would stand out of the contour or overlap another, or where a
            number is not finite.

        Raises:
            SessionError: it is no item; positions have another shape; the session is closed, or in
                use by another thread.
        """
        try:
            places = np.array(positions, dtype=float, order="C")
        except (OverflowError, TypeError, ValueError):
            places = np.empty(0)
        if places.ndim != 2 or places.shape[1] != 3:
            raise SessionError(
                f"positions have the shape {np.shape(positions)}; allowed: numbers [cm], shape "
                "(K, 3)"
            )
        required("item", item, Item, "an Item", SessionError)
        with self._alone(changes=True):
            next_item = numbered(item, len(self._layout))
            found = self._loader.feasible(next_item, places)
            if found is None:
                found = np.ones(len(places), dtype=bool)
            elif not self._limited(item):
                return found
            for place in np.flatnonzero(found):
                found[place] = self._stands(item, places[place].tolist())
            return found

    def _stands(self, item: Item, position: list[float]) -> bool:
        """True if an item would stand on a place: it is placed there, and taken off."""
        count = len(self._layout)
        x, y, z = position
        try:
            return self._try_place(replace(item, position=(x, y, z))).stable
        except LayoutError:
            return False
        finally:
            self._go_back(count)

    def _try_place(self, item: Item) -> Verdict:
        required("item", item, Item, "an Item", SessionError)
        count = len(self._layout.items)
        load = partial(self._load, numbered(item, count))
        stays = False
        try:
            if self._timed:
                verdict = verdict_by(load, count + 1, self._timeout)
            else:
                verdict = self._untimed(load, count + 1)
            stays = verdict.stable
        finally:
            # Also where something was raised, or the user interrupted.
            if not stays:
                self._go_back(count)
        return verdict

    def _limited(self, item: Item) -> bool:
        """Whether a box states what it may bear; once one does, all placements are looked at."""
        self._limits = self._limits or item.max_load is not None
        return self._limits

    def _load(self, item: Item, watch: Stopwatch) -> Finding:
        """Put an item on the layout and judge that; a box that bears too much fails it, too."""
        finding = self._loader.load(item, watch)
        if finding.failing_step is not None or finding.status is not Status.DONE:
            return finding
        if not self._limited(item):
            return finding
        found = crushed_by_now(self._layout, self._layout.items, watch.check)
        if found is None:
            return finding
        return replace(finding, failing_step=found.step, moved_item=found.item, reason=str(found))

    def _untimed(self, load: Callable[[Stopwatch], Finding], item_count: int) -> Verdict:
        """The verdict on a placement, without times: always the same one where it stands."""
        watch = self._watch if self._timeout is None else Stopwatch(self._timeout)
        finding = finding_by(load, watch)
        if finding is not STABLE:
            return verdict_of(finding, item_count, Seconds(), Seconds())
        return _untimed_stable(item_count)

    def undo(self, steps: int = 1) -> tuple[Item, ...]:
        """Take off the items placed last.

        Args:
            steps: how many, 0 or more.

        Returns:
            The items that were taken off, in loading order.

        Raises:
            SessionError: there are not so many; the session is closed, or in use by another
                thread.
        """
        with self._alone(changes=True):
            count = len(self._layout)
            if not isinstance(steps, int | np.integer) or not 0 <= steps <= count:
                raise SessionError(
                    f"undo {shown(steps)} steps; allowed: 0 to {count}, the items loaded"
                )
            gone = tuple(self._layout.items[count - steps :])
            self._go_back(count - steps)
            return gone

    def fork(self) -> LoadingSession:
        """An independent session with the same items, such as a branch of a search.

        Nothing is judged again. The cost grows with the number of items loaded, slowly. The fork
        may be used by another thread.

        Raises:
            SessionError: the session is closed, or in use by another thread.
        """
        with self._alone(changes=True):
            other = LoadingSession.__new__(LoadingSession)
            other.method, other._timeout = self.method, self._timeout
            other._timed, other._limits = self._timed, self._limits
            other._layout = self._layout.copy()
            other._loader = self._loader.fork(other._layout)
            other._open()
            return other

    def layout(self, name: str | None = None) -> Layout:
        """Layout of the items loaded so far, which can be saved and judged.

        Args:
            name: None for the session's.

        Raises:
            LayoutError: nothing has been loaded.
            SessionError: the session is in use by another thread.
        """
        with self._alone():
            return self._layout.layout(name)

    def close(self) -> None:
        """Release resources of the engine. Closing twice is allowed.

        Raises:
            SessionError: the session is in use by another thread.
        """
        with self._alone():
            self._closed = True
            self._loader.close()

    def __enter__(self) -> LoadingSession:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _open(self) -> None:
        self._closed, self._in_use = False, threading.Lock()
        self._watch = Stopwatch()  # where verdicts state no times, one for all

    @contextmanager
    def _alone(self, *, changes: bool = False) -> Iterator[None]:
        """Refuse a second thread, and anything but reading once the session is closed."""
        if not self._in_use.acquire(blocking=False):
            raise SessionError(
                "the session is in use by another thread; allowed: one thread at a time, or a "
                "fork() for each"
            )
        try:
            if changes and self._closed:
                raise SessionError("the session is closed; allowed: to read what it holds")
            yield
        finally:
            self._in_use.release()

    def _go_back(self, count: int) -> None:
        self._loader.go_back(count)
        self._layout.cut(count)


@lru_cache(maxsize=4096)
def _untimed_stable(item_count: int) -> Verdict:
    return Verdict(item_count)
