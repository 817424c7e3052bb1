"""Is a box crushed while a load is built up? Its top may bear so much, and bears so much by now."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steadyload.bearing.forces import Rectangles, Statics
from steadyload.layouts.contacts import Supports, find_supports
from steadyload.layouts.frame import Frame
from steadyload.layouts.item import Item
from steadyload.layouts.model import Arrangement, Layout
from steadyload.layouts.naming import box_label

_OVER = 1e-6
"""Share by which a load may exceed a limit: weights that add up to it do not."""


@dataclass(frozen=True, slots=True)
class Crushed:
    """A box that bears more than it may.

    Attributes:
        step: placement after which it does.
        item: the box.
        label: its id with its step, or its number where it has no id, as a sentence has it.
        bears_kg: the load on its top, by the contact forces of least energy, or by those that come
            nearest to balance where none balance.
        allowed_kg: what it may bear.
    """

    step: int
    item: int
    label: str
    bears_kg: float
    allowed_kg: float

    def sentence(self, frame: Frame) -> str:
        """The box and its load, in the unit of weights of a frame."""
        said = (self.bears_kg / frame.kg, self.allowed_kg / frame.kg)
        bears, allowed = (f"{weight:.4g}" for weight in said)
        if bears == allowed:
            bears, allowed = (f"{weight:.9g}" for weight in said)
        bears = f"{bears} {frame.weight}"
        return f"crushed at step {self.step}: {self.label} bears {bears} of {allowed}"

    def __str__(self) -> str:
        return self.sentence(Frame())


def first_crushed(
    layout: Layout,
    *,
    before: int | None = None,
    check_time: Callable[[], None] = lambda: None,
) -> Crushed | None:
    """The box that is crushed first while a load is built up, box by box; None where none is.

    After a step at which no forces balance the load, those that come nearest count.

    Args:
        layout: the plan, in the order of loading.
        before: a step; later ones are not looked at, nor is that. None for all.
        check_time: called now and then; what it raises ends the looks.
    """
    if not _limited(layout.items):
        return None
    kept = layout.with_floor_kept()
    looks = _Looks(kept, layout.items, find_supports(kept), check_time)
    # No box bears more than all that stands on it, directly or not.
    suspects = looks.suspects(range(len(layout)), len(layout) - 1)
    if not suspects:
        return None
    standing = _Standing(layout.items, looks.supports, suspects)
    for step in range(len(layout) if before is None else before):
        check_time()
        group = standing.place(step)
        if len(group):
            found = looks.crushed_at(step, group, standing.suspects(group))
            if found is not None:
                return found
    return None


def crushed_by_now(
    layout: Arrangement, items: Sequence[Item], check_time: Callable[[], None] = lambda: None
) -> Crushed | None:
    """The box that bears most beyond what it may since the last one was placed; None where none
    does.

    Args:
        layout: where the items are, one or more; it may still grow.
        items: with what they may bear; none was crushed before the last was placed.
        check_time: see :func:`first_crushed`.
    """
    if not _limited(items):
        return None
    looks, last = _Looks(layout, items, find_supports(layout), check_time), len(items) - 1
    group = looks.supports.joined(last)
    return looks.crushed_at(last, np.array(group), looks.suspects(group, last))


class _Looks:
    """Looks at a load that grows.

    Args:
        layout: where all items are, in the end.
        items: with what they may bear.
        supports: of the layout.
        check_time: see :func:`first_crushed`.
    """

    def __init__(
        self,
        layout: Arrangement,
        items: Sequence[Item],
        supports: Supports,
        check_time: Callable[[], None],
    ) -> None:
        self._layout, self._items, self.supports = layout, items, supports
        self._check_time = check_time
        self._contacts: Rectangles | None = None
        self._pressed: NDArray[np.bool_]

    def suspects(self, among: Sequence[int], step: int) -> list[int]:
        """Boxes on which more stands by a step, directly or not, than they may bear."""
        return [
            box
            for box in among
            if self._items[box].max_load is not None
            and _beyond(
                _standing_on(box, step, self._items, self.supports), self._items[box].max_load
            )
        ]

    def crushed_at(
        self, step: int, group: NDArray[np.int64], suspects: Sequence[int]
    ) -> Crushed | None:
        """The box that bears most beyond what it may after a step; None where none does.

        A box changes the forces of those alone that are joined to it by standing on each other.

        Args:
            step: at which a box was placed.
            group: what is joined to that box by then, in order.
            suspects: those of the group that may bear too much.
        """
        if not suspects:
            return None
        if self._contacts is None:
            self._contacts = Rectangles(self._layout, self.supports)
            self._pressed = np.ones((len(self._contacts.pairs), 4), dtype=np.bool_)
        statics = Statics(self._layout, group, self._contacts, self._check_time)
        # Few corners begin or cease to press from look to look.
        forces = statics.least_energy(start=self._pressed[statics.contacts].ravel())
        if forces is None:
            forces = statics.nearest()
        self._pressed[statics.contacts] = forces.reshape(-1, 4) > 0.0
        borne = dict(zip(group.tolist(), (statics.tops() @ forces).tolist(), strict=True))
        items = self._items
        worst = max(
            (k for k in suspects if _beyond(borne[k], items[k].max_load)),
            key=lambda k: borne[k] - (items[k].max_load or 0.0),
            default=None,
        )
        if worst is None:
            return None
        item = items[worst]
        allowed = item.max_load
        assert allowed is not None, "only a box with a limit is crushed"
        label = box_label(item.sequence, item.name)
        return Crushed(step, worst, label, borne[worst], allowed)


class _Standing:
    """Groups of boxes that are joined, and the weight on some boxes, while a load is built up.

    Args:
        items: of the complete load.
        supports: likewise.
        boxes: on which the weight is noted.
    """

    def __init__(self, items: Sequence[Item], supports: Supports, boxes: Sequence[int]) -> None:
        self._items, self._supports = items, supports
        self._group = np.arange(len(items))
        self._weight = np.zeros(len(items))
        self._most = np.full(len(items), np.inf)
        self._most[list(boxes)] = [items[box].max_load or 0.0 for box in boxes]

    def place(self, step: int) -> NDArray[np.int64]:
        """Place the next box.

        Returns:
            What is joined to it by now, in order; itself alone where nothing is.
        """
        carriers = [k for k in self._supports.carriers(step) if k < step]
        carried = [k for k in self._supports.above[step] if k < step]
        for other in carriers + carried:
            self._group[self._group == self._group[other]] = step
        self._group[step] = step
        below = self._below(step)
        if carried:
            for box in (step, *below):
                if np.isfinite(self._most[box]):
                    self._weight[box] = _standing_on(box, step, self._items, self._supports)
        else:
            self._weight[below] += self._items[step].weight
        return np.flatnonzero(self._group[: step + 1] == step)

    def suspects(self, group: NDArray[np.int64]) -> list[int]:
        """Boxes of a group on which more stands, directly or not, than they may bear."""
        over = self._weight[group] > self._most[group]
        return [k for k in group[over].tolist() if _beyond(self._weight[k], self._most[k])]

    def _below(self, step: int) -> list[int]:
        """All earlier boxes that a box stands on, directly or not."""
        todo, seen = [step], set()
        while todo:
            for under in self._supports.carriers(todo.pop()):
                if under < step and under not in seen:
                    seen.add(under)
                    todo.append(under)
        return list(seen)


def _limited(items: Sequence[Item]) -> bool:
    return any(item.max_load is not None for item in items)


def _beyond(load: float, allowed: float | None) -> bool:
    return allowed is not None and load > allowed * (1.0 + _OVER) + 1e-9


def _standing_on(box: int, step: int, items: Sequence[Item], supports: Supports) -> float:
    """Weight of all that stands on a box by a step, directly or not [kg]."""
    todo, seen, weight = [box], {box}, 0.0
    while todo:
        for on in supports.above[todo.pop()]:
            if on <= step and on not in seen:
                seen.add(on)
                todo.append(on)
                weight += items[on].weight
    return weight
