"""The search: places of all boxes at which they can be loaded, as near to the plan as may be."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from steadyload.layouts.model.layout import TOLERANCE, FloatArray
from steadyload.repairing.loading_order import LoadingOrder
from steadyload.repairing.places import Places
from steadyload.repairing.plan import LEFT_OUT, Boxes, Kind, Worth
from steadyload.statics.balance import inset

MARGIN = 0.05
"""Margin of balance [cm] of boxes at their places in the plan, at least."""

_OF_ITS_OWN = 0.99
"""Share of the largest margin that a box can have, on any support."""

_LOOKED_AT = 1552
"""Places of a box that are looked at, at most."""

_STEPS, _NEAR, _TAKEN_OFF = 0.4, 0.05, 0.25
"""Of geometric distributions: of how many boxes are put back, of which of the nearest places of a
box is taken, and of how many boxes are taken off."""

_TRIED_NEARER = 24
"""Places of a box, nearer than where it is, that are tried in the end."""

_FINEST = 0.05
"""A box that is slid towards its place in the plan ends so near to where it would fall [cm]."""

_TRIED, _TRIED_WITH_LIMITS = 4, 24
"""Places at which a box is balanced that are tried with all other boxes; and where boxes state what
they may bear, which is looked at only then."""

_OUT = np.array([0.0, 0.0, 0.0, LEFT_OUT])
"""In place of the place of a box that is left out."""


@dataclass(frozen=True)
class Attempt:
    """A changed plan by the search.

    Attributes:
        places: by box, shape (J, 4), see :class:`Boxes`.
        order: the boxes that are kept, as they are loaded.
        worth: what it costs.
    """

    places: FloatArray = field(compare=False)
    order: tuple[int, ...]
    worth: Worth

    @property
    def left_out(self) -> list[int]:
        """The boxes that are left out."""
        return left_out(self.places)


class Search:
    """Searches for changed plans.

    Args:
        boxes: of the plan.
        allowed: what may change; boxes are left out whatever this says, and it is for the caller to
            refuse that.
        shift_cm: see :class:`Places`.
        seed: of random choices.
        check_time: called often; raises an error where the time is up.
        margin: of balance that all boxes have, or nearly the largest that their own base allows
            [cm].

    Attributes:
        most: the margin that each box can have at most [cm], shape (J,).
        places: where boxes may be.
        loading: of boxes at their places, with their margins.
    """

    def __init__(
        self,
        boxes: Boxes,
        allowed: Collection[Kind],
        shift_cm: float,
        seed: int,
        check_time: Callable[[], None],
        margin: float = MARGIN,
    ) -> None:
        self._boxes, self._check_time = boxes, check_time
        self.places = Places(boxes, allowed, shift_cm)
        self.most = _OF_ITS_OWN * np.maximum(inset(boxes.layout, slice(None)), 0.0)
        own = np.minimum(max(margin, MARGIN), self.most)
        self.loading = LoadingOrder(boxes, reorder=Kind.ORDER in allowed, margins=own)
        self._random = np.random.default_rng(seed)
        self._middles = boxes.centres(boxes.planned)

    def complete(self, places: FloatArray, worst: Worth | None = None) -> Attempt | None:
        """Move boxes that cannot be loaded, one by one, to the nearest places where they stand.

        Args:
            places: by box; one that is left out stays so unless there is a place in the end.
            worst: give up once it is known that this is not improved.

        Returns:
            None if given up.
        """
        now = places
        while True:
            self._check_time()
            loaded = self.loading.load(now)
            if not loaded.stuck:
                break
            now = self._moved(loaded.stuck[0], now, loaded.stuck)
            if worst is not None and self._boxes.worth(now, ()) >= worst:
                return None
        left = left_out(now)
        noise = self._random.uniform(0.5, 1.5, len(left))
        for place in np.argsort(-self._boxes.volumes[left] * noise, kind="stable"):
            now = self._moved(left[place], now, ())
        stuck = self.loading.load(now).stuck
        if stuck:
            now = now.copy()
            now[list(stuck)] = _OUT
        order = self.loading.load(now).order
        return Attempt(now, order, self._boxes.worth(now, order))

    def nearer(self, attempt: Attempt) -> Attempt:
        """The same with each moved box put as near to its place in the plan as all others allow."""
        planned = self._boxes.planned
        for box in attempt.order:
            if (attempt.places[box] == planned[box]).all():
                continue
            for place in self._nearer_places(box, attempt.places):
                self._check_time()
                attempt = self._with_place(attempt, box, place) or attempt
            for axis in (0, 2):
                attempt = self._pulled(attempt, box, axis)
        return attempt

    def _nearer_places(self, box: int, places: FloatArray) -> FloatArray:
        """Free places of a box that are nearer than where it is, the nearest last."""
        found, far = self.places.of(box, places, self._margin(box))
        now = float(np.linalg.norm((self._boxes.centres(places) - self._middles)[box]))
        nearer = found[far < now - 1e-6][-_TRIED_NEARER:]
        return nearer[(nearer != self._boxes.planned[box]).any(axis=1)][::-1]

    def _pulled(self, attempt: Attempt, box: int, axis: int) -> Attempt:
        """The attempt with a box slid along an axis towards the plan as far as it stands."""
        now = attempt.places[box]
        size = self._boxes.sides[int(now[3]), box, axis]
        goal = self._middles[box, axis] - 0.5 * size
        low, high = self._boxes.limits[axis], self._boxes.limits[3 + axis] - size
        way, share, step = min(max(goal, low), high) - now[axis], 0.0, 1.0
        while abs(way) * step > _FINEST:
            self._check_time()
            place = now.copy()
            place[axis] = round(now[axis] + (share + step) * way, 3)
            found = self._with_place(attempt, box, place)
            if found is not None:
                attempt, share = found, share + step
            if share == 1.0:
                break
            step *= 0.5
        return attempt

    def _with_place(self, attempt: Attempt, box: int, place: FloatArray) -> Attempt | None:
        """The attempt with a box elsewhere; None where that is no better, or a box is stuck."""
        places = with_place(attempt.places, box, place)
        loaded = self.loading.load(places)
        worth = self._boxes.worth(places, loaded.order)
        if loaded.stuck or worth >= attempt.worth:
            return None
        return Attempt(places, loaded.order, worth)

    def neighbour(self, best: Attempt) -> FloatArray:
        """Places to start from: changed boxes about one of them are put back, and others moved."""
        draw, planned = self._random, self._boxes.planned
        changed = np.flatnonzero((best.places != planned).any(axis=1))
        chosen = int(draw.choice(changed))
        far = np.abs(self._middles[changed] - self._middles[chosen]).sum(axis=1)
        changed = changed[np.argsort(far, kind="stable")]
        start = best.places.copy()
        back = changed[: int(draw.geometric(_STEPS))]
        start[back] = planned[back]
        # What was changed has to be put elsewhere anyhow, and may be in the way of a better place.
        ignored = changed.tolist() if draw.random() < 0.5 else []
        way = draw.random()
        if best.worth.left and draw.random() < 0.5:
            self._take_off(start)
        elif way < 0.4:
            self._push_below(chosen, start, ignored)
        elif way < 0.8:
            for _ in range(int(draw.integers(1, 3))):
                self._push_aside(chosen, start, ignored)
        return start

    def _take_off(self, places: FloatArray) -> None:
        """Take out some of the boxes of the upper half, for them and those left out to be put."""
        kept = np.flatnonzero(places[:, 3] != LEFT_OUT)
        upper = kept[np.argsort(places[kept, 1])[len(kept) // 2 :]]
        count = min(int(self._random.geometric(_TAKEN_OFF)), len(upper))
        places[self._random.choice(upper, count, replace=False)] = _OUT

    def _push_below(self, box: int, places: FloatArray, ignored: Collection[int]) -> None:
        """Put another box, if one may be there, below one that is at its place in the plan."""
        boxes, draw = self._boxes, self._random
        kept = np.flatnonzero(places[:, 3] != LEFT_OUT)
        kept = kept[kept != box]
        if not len(kept):
            return
        other = int(draw.choice(kept))
        found, _ = self.places.of(other, places, self._margin(other), ignored)
        tops = found[:, :3] + boxes.sides[found[:, 3].astype(int), other]
        low, high = boxes.layout.lower[box], boxes.layout.upper[box]
        below = np.abs(tops[:, 1] - low[1]) <= TOLERANCE
        shared = np.minimum(tops, high) - np.maximum(found[:, :3], low)
        below &= shared[:, ::2].min(axis=1) > TOLERANCE
        at = np.flatnonzero(below)
        if len(at):
            places[other] = found[at[min(int(draw.geometric(0.3)) - 1, len(at) - 1)]]

    def _push_aside(self, box: int, places: FloatArray, ignored: Collection[int]) -> None:
        """Put a box that is below or beside another one elsewhere, or take it out for now."""
        near = self._beside(box, places)
        if not len(near):
            return
        other = int(self._random.choice(near))
        found, _ = self.places.of(other, places, self._margin(other), ignored)
        k = int(self._random.geometric(_NEAR)) - 1
        places[other] = found[k] if k < len(found) else _OUT

    def _beside(self, box: int, places: FloatArray) -> NDArray[np.int64]:
        """Kept boxes that touch the place of a box in the plan, or nearly."""
        low, high = self._boxes.layout.lower[box] - 1.0, self._boxes.layout.upper[box] + 1.0
        turns = places[:, 3].astype(int)
        ends = places[:, :3] + self._boxes.sides[turns, np.arange(len(places))]
        near = ((places[:, :3] < high) & (ends > low)).all(axis=1) & (places[:, 3] != LEFT_OUT)
        near[box] = False
        return np.flatnonzero(near)

    def _moved(self, box: int, places: FloatArray, stuck: Sequence[int]) -> FloatArray:
        """The places with a box at the nearest one at which it stands and least others get stuck;
        left out where there is none.
        """
        for ignored in ((), stuck) if len(stuck) > 1 else ((),):
            best: tuple[int, FloatArray] | None = None
            for place in self._where_it_stands(box, places, ignored):
                trial = with_place(places, box, place)
                left = self.loading.load(trial).stuck
                if box in left:
                    continue
                if best is None or len(left) < best[0]:
                    best = len(left), trial
                if len(left) < max(len(stuck), 1):
                    break
            if best is not None and (ignored or best[0] <= len(stuck)):
                return best[1]
        return with_place(places, box, _OUT)

    def _where_it_stands(
        self, box: int, places: FloatArray, ignored: Collection[int]
    ) -> list[FloatArray]:
        """The nearest places at which a box stands among the boxes that are loaded.

        Args:
            box: it is not loaded.
            places: by box.
            ignored: boxes that it may overlap, which have to be put elsewhere then.
        """
        self._check_time()
        self.loading.load(places)
        margin = self._margin(box)
        found, _ = self.places.of(box, places, margin, ignored)
        most = _TRIED_WITH_LIMITS if self._boxes.limited else _TRIED
        return self.loading.first_standing(box, found[:_LOOKED_AT], margin, most)

    def _margin(self, box: int) -> float:
        """Of a box that is moved [cm]."""
        return float(self.loading.margins[1, box])


def left_out(places: FloatArray) -> list[int]:
    """The boxes that are left out."""
    found: list[int] = np.flatnonzero(places[:, 3] == LEFT_OUT).tolist()
    return found


def with_place(places: FloatArray, box: int, place: FloatArray) -> FloatArray:
    """Places of boxes with another one of one of them."""
    found = places.copy()
    found[box] = place
    return found
