"""The search: places of all boxes at which they can be loaded, as near to the plan as may be."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from steadyload.layouts.model.layout import FloatArray, Item
from steadyload.repairing.loading_order import LoadingOrder
from steadyload.repairing.places import Places
from steadyload.repairing.plan import Boxes, Kind, Place, Worth

MARGIN, OF_MOVED = 0.05, 0.5
"""Margins of balance [cm] of boxes at their places in the plan, and of moved ones, at first."""

_AT_ONCE = 64
"""Places that are looked at in one call."""

_LOOKED_AT = 1500
"""Places of a box that are looked at, at most."""

_TRIED = 4
"""Places at which a box stands that are tried with all other boxes."""


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
        for box in sorted(left, key=lambda each: -self._boxes.volumes[each]):
            now[box] = self._best_place(box, now, ())
        loaded = self._loading.load(now, self._margins_of(now))
        for box in loaded.stuck:
            now[box] = None
        order = self._loading.load(now, self._margins_of(now)).order
        return Attempt(tuple(now), order, self._boxes.worth(now, order))

    def neighbour(self, best: Attempt) -> list[Place | None]:
        """Places to start from: some boxes of a plan are put back, and one is put elsewhere."""
        planned = self._boxes.planned
        changed = [b for b, place in enumerate(best.places) if place != planned[b]]
        start = list(best.places)
        count = 1 + int(self._random.integers(min(3, len(changed))))
        picked = self._random.choice(changed, count, replace=False).tolist()
        for box in picked:
            start[box] = planned[box]
        if self._random.random() < 0.7:
            self._push_aside(picked[0], start)
        return start

    def _push_aside(self, box: int, places: list[Place | None]) -> None:
        """Put a box that is below or beside another one elsewhere, or take it out for now."""
        near = self._beside(box, places)
        if not near:
            return
        other = int(self._random.choice(near))
        others = self._items(places, without={other})
        found, _, turned = self._places.of(other, others, OF_MOVED)
        if len(found) and self._random.random() < 0.7:
            k = int(self._random.integers(min(12, len(found))))
            places[other] = _place(found[k], turned[k])
        else:
            places[other] = None

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
        others = self._items(places, without={box, *ignored})
        found, _, turned = self._places.of(box, others, margin)
        kept: list[Place] = []
        for first in range(0, min(len(found), _LOOKED_AT), _AT_ONCE):
            self._check_time()
            part = slice(first, first + _AT_ONCE)
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
            if len(kept) >= _TRIED:
                break
        return kept[:_TRIED]

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
