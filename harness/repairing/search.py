"""The search: places of all boxes at which they can be loaded, as near to the plan as may be."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from steadyload.layouts.model.layout import TOLERANCE, FloatArray, Item
from steadyload.repairing.loading_order import LoadingOrder
from steadyload.repairing.places import Places
from steadyload.repairing.plan import Boxes, Kind, Place, Worth

MARGIN, OF_MOVED = 0.05, 0.5
"""Margins of balance [cm] of boxes at their places in the plan, and of moved ones, at first."""

_AT_FIRST, _AT_ONCE = 16, 64
"""Places that are looked at in the first call, and in each of the next."""

_LOOKED_AT = 1500
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


@dataclass(frozen=True)
class Attempt:
    """A changed plan by the search.

    Attributes:
        places: by box; None for one that is left out.
        order: the boxes that are kept, as they are loaded.
        worth: what it costs.
    """

    places: tuple[Place | None, ...]
    order: tuple[int, ...]
    worth: Worth


class Search:
    """Searches for changed plans.

    Args:
        boxes: of the plan.
        allowed: what may change; boxes are left out whatever this says, and it is for the caller to
            refuse that.
        shift_cm: see :class:`Places`.
        seed: of random choices.
        check_time: called often; raises an error where the time is up.
    """

    def __init__(
        self,
        boxes: Boxes,
        allowed: Collection[Kind],
        shift_cm: float,
        seed: int,
        check_time: Callable[[], None],
    ) -> None:
        self._boxes, self._check_time = boxes, check_time
        self._places = Places(boxes, allowed, shift_cm)
        self._loading = LoadingOrder(boxes, reorder=Kind.ORDER in allowed)
        self._random = np.random.default_rng(seed)
        self.margins: FloatArray = np.full(len(boxes), MARGIN)
        self.refused: set[tuple[int, Place]] = set()

    def complete(
        self, places: Sequence[Place | None], worst: Worth | None = None
    ) -> Attempt | None:
        """Move boxes that cannot be loaded, one by one, to the nearest places where they stand.

        Args:
            places: by box; None for one that is left out, unless there is a place in the end.
            worst: give up once it is known that this is not improved.

        Returns:
            None if given up.
        """
        now = list(places)
        while True:
            self._check_time()
            loaded = self._loading.load(now, self._margins_of(now))
            if not loaded.stuck:
                break
            box = loaded.stuck[0]
            now[box] = self._best_place(box, now, loaded.stuck)
            if worst is not None and self._boxes.worth(now, ()) >= worst:
                return None
        left = [box for box, place in enumerate(now) if place is None]
        noise = self._random.uniform(0.5, 1.5, len(left))
        for place in np.argsort(-self._boxes.volumes[left] * noise, kind="stable"):
            now[left[place]] = self._best_place(left[place], now, ())
        loaded = self._loading.load(now, self._margins_of(now))
        for box in loaded.stuck:
            now[box] = None
        order = self._loading.load(now, self._margins_of(now)).order
        return Attempt(tuple(now), order, self._boxes.worth(now, order))

    def nearer(self, attempt: Attempt) -> Attempt:
        """The same with each moved box put as near to its place in the plan as all others allow."""
        planned = self._boxes.planned
        moved = [box for box in attempt.order if attempt.places[box] != planned[box]]
        for box in moved:
            for place in self._nearer_places(box, attempt.places):
                self._check_time()
                attempt = self._with_place(attempt, box, place) or attempt
            for axis in (0, 2):
                attempt = self._pulled(attempt, box, axis)
        return attempt

    def _nearer_places(self, box: int, places: Sequence[Place | None]) -> list[Place]:
        """Free places of a box that are nearer than where it is, the nearest last."""
        place = places[box]
        assert place is not None, "the box is kept"
        margin = max(OF_MOVED, float(self.margins[box]))
        found, far, turned = self._places.of(box, self._items(places, {box}), margin)
        nearer = np.flatnonzero(far < self._boxes.distance(box, place) - 1e-6)
        made = [_place(found[k], turned[k]) for k in nearer[-_TRIED_NEARER:]]
        return [other for other in made if other != self._boxes.planned[box]][::-1]

    def _pulled(self, attempt: Attempt, box: int, axis: int) -> Attempt:
        """The attempt with a box slid along an axis towards the plan as far as it stands."""
        place = attempt.places[box]
        assert place is not None, "the box is kept"
        was, now = self._boxes.layout.items[box], self._boxes.item(box, place)
        goal = was.position[axis] + 0.5 * (was.size[axis] - now.size[axis])
        low, high = self._boxes.limits[axis], self._boxes.limits[3 + axis] - now.size[axis]
        goal = min(max(goal, low), high)
        way, share, step = goal - now.position[axis], 0.0, 1.0
        while abs(way) * step > _FINEST:
            self._check_time()
            position = list(now.position)
            position[axis] = round(now.position[axis] + (share + step) * way, 3)
            x, y, z = position
            found = self._with_place(attempt, box, Place((x, y, z), place.turned))
            if found is not None:
                attempt, share = found, share + step
            if share == 1.0:
                break
            step *= 0.5
        return attempt

    def _with_place(self, attempt: Attempt, box: int, place: Place) -> Attempt | None:
        """The attempt with a box elsewhere; None where that is no better, or a box is stuck."""
        if (box, place) in self.refused:
            return None
        places = (*attempt.places[:box], place, *attempt.places[box + 1 :])
        loaded = self._loading.load(places, self._margins_of(places))
        worth = self._boxes.worth(places, loaded.order)
        if loaded.stuck or worth >= attempt.worth:
            return None
        return Attempt(places, loaded.order, worth)

    def neighbour(self, best: Attempt) -> list[Place | None]:
        """Places to start from: changed boxes about one of them are put back, and others moved."""
        draw, planned = self._random, self._boxes.planned
        changed = [b for b, place in enumerate(best.places) if place != planned[b]]
        centres = 0.5 * (self._boxes.layout.lower + self._boxes.layout.upper)
        chosen = int(draw.choice(changed))
        changed.sort(key=lambda box: float(np.abs(centres[box] - centres[chosen]).sum()))
        start = list(best.places)
        for box in changed[: int(draw.geometric(_STEPS))]:
            start[box] = planned[box]
        # What was changed has to be put elsewhere anyhow, and may be in the way of a better place.
        ignored = set(changed) if draw.random() < 0.5 else set[int]()
        way = draw.random()
        if best.worth.left and draw.random() < 0.5:
            self._take_off(start)
        elif way < 0.4:
            self._push_below(chosen, start, ignored)
        elif way < 0.8:
            for _ in range(int(draw.integers(1, 3))):
                self._push_aside(chosen, start, ignored)
        return start

    def _take_off(self, places: list[Place | None]) -> None:
        """Take out some of the boxes of the upper half, for them and those left out to be put."""
        kept = [box for box, place in enumerate(places) if place is not None]
        tops = [self._boxes.item(box, places[box]).position[1] for box in kept]  # type: ignore[arg-type]
        upper = np.argsort(tops)[len(kept) // 2 :]
        count = min(int(self._random.geometric(_TAKEN_OFF)), len(upper))
        for place in self._random.choice(upper, count, replace=False):
            places[kept[place]] = None

    def _push_below(self, box: int, places: list[Place | None], ignored: set[int]) -> None:
        """Put another box, if one may be there, below one that is at its place in the plan."""
        boxes, draw = self._boxes, self._random
        kept = [b for b, place in enumerate(places) if place is not None and b != box]
        if not kept:
            return
        other = int(draw.choice(kept))
        found, _, turned = self._places.of(other, self._items(places, {other, *ignored}), OF_MOVED)
        sizes = np.array([boxes.layout.sizes[other], boxes.turned(other).size])
        tops = found + sizes[np.array(turned, dtype=int)]
        low, high = boxes.layout.lower[box], boxes.layout.upper[box]
        below = np.abs(tops[:, 1] - low[1]) <= TOLERANCE
        below &= (np.minimum(tops, high) - np.maximum(found, low))[:, ::2].min(axis=1) > TOLERANCE
        at = np.flatnonzero(below)
        if len(at):
            k = int(at[min(int(draw.geometric(0.3)) - 1, len(at) - 1)])
            places[other] = _place(found[k], turned[k])

    def _push_aside(self, box: int, places: list[Place | None], ignored: set[int]) -> None:
        """Put a box that is below or beside another one elsewhere, or take it out for now."""
        near = self._beside(box, places)
        if not near:
            return
        other = int(self._random.choice(near))
        found, _, turned = self._places.of(other, self._items(places, {other, *ignored}), OF_MOVED)
        k = int(self._random.geometric(_NEAR)) - 1
        places[other] = _place(found[k], turned[k]) if k < len(found) else None

    def _beside(self, box: int, places: Sequence[Place | None]) -> list[int]:
        """Kept boxes that touch the place of a box in the plan, or nearly."""
        low, high = self._boxes.layout.lower[box] - 1.0, self._boxes.layout.upper[box] + 1.0
        found = []
        for other, place in enumerate(places):
            if other == box or place is None:
                continue
            size = self._boxes.item(other, place).size
            corner = np.array(place.position)
            if ((corner < high) & (corner + size > low)).all():
                found.append(other)
        return found

    def _best_place(
        self, box: int, places: list[Place | None], stuck: Sequence[int]
    ) -> Place | None:
        """The nearest place at which a box stands and least others get stuck; None for none."""
        for ignored in ((), stuck) if len(stuck) > 1 else ((),):
            best: tuple[int, Place] | None = None
            for place in self._where_it_stands(box, places, ignored):
                trial = [*places[:box], place, *places[box + 1 :]]
                left = self._loading.load(trial, self._margins_of(trial)).stuck
                if box in left:
                    continue
                if best is None or len(left) < best[0]:
                    best = len(left), place
                if len(left) < max(len(stuck), 1):
                    break
            if best is not None and (ignored or best[0] <= len(stuck)):
                return best[1]
        return None

    def _where_it_stands(
        self, box: int, places: list[Place | None], ignored: Iterable[int]
    ) -> list[Place]:
        """The nearest places at which a box stands among the boxes that are loaded.

        Args:
            box: it is not loaded.
            places: by box.
            ignored: boxes that it may overlap, which have to be put elsewhere then.
        """
        self._loading.load(places, self._margins_of(places))
        margin = max(OF_MOVED, float(self.margins[box]))
        others = self._items(places, {box, *ignored})
        found, _, turned = self._places.of(box, others, margin)
        kept: list[Place] = []
        most = _TRIED_WITH_LIMITS if self._boxes.limited else _TRIED
        first, end = 0, 0
        while len(kept) < most and end < min(len(found), _LOOKED_AT):
            self._check_time()
            first, end = end, end + (_AT_ONCE if end else _AT_FIRST)
            part = slice(first, end)
            flags = np.array(turned[part])
            stands = np.zeros(len(flags), dtype=bool)
            for turn in np.unique(flags).tolist():
                item = self._boxes.turned(box) if turn else self._boxes.layout.items[box]
                own = flags == turn
                stands[own] = self._loading.stands(
                    box, item, np.ascontiguousarray(found[part][own]), margin
                )
            for k in np.flatnonzero(stands):
                place = _place(found[first + k], bool(flags[k]))
                if place != self._boxes.planned[box] and (box, place) not in self.refused:
                    kept.append(place)
        return kept[:most]

    def _items(self, places: Sequence[Place | None], without: Collection[int]) -> list[Item]:
        return [
            self._boxes.item(box, place)
            for box, place in enumerate(places)
            if place is not None and box not in without
        ]

    def _margins_of(self, places: Sequence[Place | None]) -> FloatArray:
        """Margins by box: a moved one has more than one at its place in the plan."""
        moved = np.array([a != b for a, b in zip(places, self._boxes.planned, strict=True)])
        found = np.where(moved, np.maximum(self.margins, OF_MOVED), self.margins)
        for box, place in self.refused:
            if places[box] == place:
                found[box] = np.inf
        return found


def _place(position: FloatArray, turned: bool) -> Place:
    x, y, z = position.tolist()
    return Place((x, y, z), turned)
