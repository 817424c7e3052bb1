"""A method that knows no physics: it repeats the label of the training case most like a layout."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from steadyload.layouts.model.layout import FloatArray, Layout


class Memoriser:
    """Labels of training cases, found by the boxes that come first.

    Most alike is the case that begins with the same boxes at the same places for longest: that of a
    twin where there is one. Of several it is the one whose centres of mass, over these boxes and in
    shares of their sides, are nearest; of several of these the first. Its failing step is the
    verdict, and a step beyond the last item of the layout means that it is stable. A layout that
    nothing begins like is called stable, as most are.

    Args:
        cases: layouts with their failing steps, None for a stable one.
    """

    def __init__(self, cases: Iterable[tuple[Layout, int | None]]) -> None:
        self._steps: list[int | None] = []
        self._shifts: list[FloatArray] = []
        self._beginnings: dict[bytes, list[int]] = {}
        for which, (layout, step) in enumerate(cases):
            self._steps.append(step)
            self._shifts.append(_shifts(layout))
            for beginning in _beginnings(layout):
                self._beginnings.setdefault(beginning, []).append(which)

    def failing_step(self, layout: Layout) -> int | None:
        """The failing step of the case most like a layout; None for stable."""
        for count, beginning in reversed(list(enumerate(_beginnings(layout), start=1))):
            alike = self._beginnings.get(beginning)
            if alike:
                own = _shifts(layout)[:count]
                apart = [float(np.square(self._shifts[k][:count] - own).sum()) for k in alike]
                step = self._steps[alike[int(np.argmin(apart))]]
                return step if step is not None and step < len(layout) else None
        return None


def _shifts(layout: Layout) -> FloatArray:
    """Centres of mass from the middle, in shares of the sides, (J, 3)."""
    shifts: FloatArray = layout.mass_offsets / (layout.upper - layout.lower)
    return shifts


def _beginnings(layout: Layout) -> list[bytes]:
    """For every item the pallet and all boxes up to it, as bytes."""
    rows = np.hstack([layout.lower, layout.upper]).astype("<f8")
    whole, start = rows.tobytes(), np.array(layout.pallet.size, "<f8").tobytes()
    width = rows.shape[1] * rows.itemsize
    return [start + whole[: width * count] for count in range(1, len(rows) + 1)]
