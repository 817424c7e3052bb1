"""Looks at a load that is built up, box by box: which box bears more than it may after a step?"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from steadyload.layouts.model.contacts import Supports
from steadyload.layouts.model.item import Item
from steadyload.layouts.model.layout import Arrangement
from steadyload.layouts.model.naming import label_in
from steadyload.statics.bearing.crushed import Crushed
from steadyload.statics.bearing.forces import Rectangles, Statics
from steadyload.statics.bearing.growing import GrowingStatics

_OVER = 1e-6
"""Share by which a load may exceed a limit: weights that add up to it do not."""

_ROUNDING = 1e-4
"""Share of what stands on a box that a load found in passing may be off by: what equations may be
left with, times a box over the lever of :data:`.EDGE` that the forces on a narrow edge may have."""

_SPREAD = 1e4
"""Factor by which weights may differ where loads are found in passing: beside a box that weighs
very much more, what the equations leave of a light one is no small share of it."""

_TRIES = 2
"""Steps at which nothing balances a load, after which no loads are found in passing."""


class Looks:
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
        self.layout, self.items, self.supports = layout, items, supports
        self._check_time = check_time
        self.unbalanced = 0  # looks at which nothing balanced the load

    @cached_property
    def contacts(self) -> Rectangles:
        """Of the layout."""
        return Rectangles(self.layout, self.supports)

    @cached_property
    def pressed(self) -> NDArray[np.bool_]:
        """Which corners pressed when last looked at, else true, (k, 4)."""
        return np.ones((len(self.contacts.pairs), 4), dtype=np.bool_)

    def suspects(self, among: Sequence[int], step: int) -> list[int]:
        """Boxes on which more stands by a step, directly or not, than they may bear."""
        return [
            box
            for box in among
            if self.items[box].max_load is not None
            and _beyond(
                _standing_on(box, step, self.items, self.supports), self.items[box].max_load
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
        statics = Statics(self.layout, group, self.contacts, self._check_time)
        # Few corners begin or cease to press from look to look.
        forces = statics.least_energy(start=self.pressed[statics.contacts].ravel())
        if forces is None:
            self.unbalanced += 1
            forces = statics.nearest()
        self.pressed[statics.contacts] = forces.reshape(-1, 4) > 0.0
        borne = dict(zip(group.tolist(), (statics.tops() @ forces).tolist(), strict=True))
        items = self.items
        worst = max(
            (k for k in suspects if _beyond(borne[k], items[k].max_load)),
            key=lambda k: borne[k] - (items[k].max_load or 0.0),
            default=None,
        )
        if worst is None:
            return None
        allowed = items[worst].max_load
        assert allowed is not None, "only a box with a limit is crushed"
        return Crushed(step, worst, label_in(items, worst), borne[worst], allowed)


class Passing:
    """Loads on boxes, found in passing from step to step; they decide all steps but few.

    Args:
        looks: at the load that grows.
    """

    def __init__(self, looks: Looks) -> None:
        self._looks = looks
        self._statics: GrowingStatics | None = None
        weights = looks.layout.weights
        self._are_alike = weights.max() <= _SPREAD * weights.min()

    def suspects(self, group: NDArray[np.int64], standing: Mapping[int, float]) -> list[int]:
        """Boxes that may bear too much.

        Args:
            group: what is joined to the box placed last, in order.
            standing: what stands on boxes of the group that are suspected [kg], by box.
        """
        if not self._are_alike or self._looks.unbalanced >= _TRIES:
            return list(standing)
        if self._statics is None:
            looks = self._looks
            self._statics = GrowingStatics(looks.layout, looks.contacts, looks.pressed)
        borne = self._statics.borne(group)
        if borne is None:
            self._statics = None  # it begins anew from the solution of this step
            return list(standing)
        return [
            box
            for box, weight in standing.items()
            if _beyond(borne[box] + _ROUNDING * weight, self._looks.items[box].max_load)
        ]


class Standing:
    """Groups of boxes that are joined, and the weight on boxes with limits, while a load grows.

    Args:
        items: of the complete load, J of them, of which K have limits.
        supports: likewise.
    """

    def __init__(self, items: Sequence[Item], supports: Supports) -> None:
        self._supports = supports
        self._weights = [item.weight for item in items]
        self._group = np.arange(len(items))
        self._limited = np.array([k for k, item in enumerate(items) if item.max_load is not None])
        self._most = np.array([items[k].max_load for k in self._limited])
        self._column = {box: column for column, box in enumerate(self._limited.tolist())}
        # Which boxes with limits a box is or stands on, directly or not.
        self._on = np.zeros((len(items), len(self._limited)), dtype=np.bool_)
        self._standing = np.zeros(len(self._limited))

    def place(self, step: int) -> None:
        """Place the next box."""
        carriers = [k for k in self._supports.carriers(step) if k < step]
        carried = [k for k in self._supports.above[step] if k < step]
        for other in carriers + carried:
            self._group[self._group == self._group[other]] = step
        self._group[step] = step
        for under in carriers:
            self._put(step, under)
        if step in self._column:
            self._on[step, self._column[step]] = True
        raised = [step] if carried else []
        while raised:
            under = raised.pop()
            raised += [
                on for on in self._supports.above[under] if on <= step and self._put(on, under)
            ]

    def _put(self, box: int, under: int) -> bool:
        """Put a box on another; whether it stands on more boxes with limits than before."""
        more = self._on[under] & ~self._on[box]
        self._standing += self._weights[box] * more
        self._on[box] |= more
        return bool(more.any())

    def group(self, step: int) -> NDArray[np.int64]:
        """The boxes joined to the one placed last, in order."""
        return np.flatnonzero(self._group[: step + 1] == step)

    def suspects(self, step: int) -> dict[int, float]:
        """Weights that stand, directly or not, on boxes that may not bear so much [kg], by box; of
        those that are joined to the box placed last.
        """
        over = (self._standing > self._most) & (self._group[self._limited] == step)
        return {
            box: weight
            for box, weight, most in zip(
                self._limited[over].tolist(), self._standing[over].tolist(), self._most[over],
                strict=True,
            )
            if _beyond(weight, most)
        }  # fmt: skip


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
