"""Changes of a repaired plan, box by box, in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import Item, Layout, Vector
from steadyload.layouts.model.naming import label_in
from steadyload.repairing.plan import kept_in_order


@dataclass(frozen=True, slots=True)
class Change:
    """A box that is at another place, or loaded at another time, than in the plan.

    Attributes:
        step: of the box in the plan.
        new_step: in the changed plan; None where it is left out.
        box: its label in the plan: "box SKU-2002 (step 5)".
        way: from its lower corner in the plan to that in the changed one (x, y, z) [cm]; of a
            turned box between the centres.
        turned: by a quarter about the vertical.
        before, after: label of the box that it is loaded just before, or after, where it has
            another turn in the order; else empty.
    """

    step: int
    new_step: int | None
    box: str
    way: Vector = (0.0, 0.0, 0.0)
    turned: bool = False
    before: str = ""
    after: str = ""

    @property
    def moved(self) -> bool:
        """Whether it is at another place, or turned."""
        return self.turned or any(self.way)

    @property
    def distance_cm(self) -> float:
        """How far it is moved [cm]."""
        return float(np.sqrt(np.dot(self.way, self.way)))

    def sentence(self, frame: Frame | None = None) -> str:
        """The change: "box SKU-2002 (step 5) moves 12.0 cm towards -x".

        Args:
            frame: axes and unit of the sentence; None for ours.
        """
        if self.new_step is None:
            return f"{self.box} is left out"
        frame, said = frame or Frame(), []
        if self.turned:
            said.append("is turned by a quarter")
        if aside := sideways(self.way, frame):
            said.append(f"moves {aside}")
        if self.way[1]:
            how = "comes down" if self.way[1] < 0 else "goes up"
            said.append(f"{how} {frame.length(abs(self.way[1]), finely=True)}")
        if self.before or self.after:
            other = f"before {self.before}" if self.before else f"after {self.after}"
            said.append(f"is loaded {other}")
        return f"{self.box} {', '.join(said)}"

    def to_dict(self) -> dict[str, Any]:
        """The change as values that JSON can hold, with units in the names."""
        x, y, z = self.way
        return {
            "step": self.step, "new_step": self.new_step, "box": self.box, "x_cm": x, "y_cm": y,
            "z_cm": z, "turned": self.turned, "loaded_before": self.before or None,
            "loaded_after": self.after or None,
        }  # fmt: skip


def sideways(way: Vector, frame: Frame) -> str:
    """The horizontal part of a way [cm] in words: "12 cm towards -x and 3 cm towards +z"."""
    return " and ".join(
        f"{frame.length(abs(way[axis]), finely=True)} towards {'-' if way[axis] < 0 else '+'}"
        f"{frame.axes[axis]}"
        for axis in (0, 2)
        if way[axis]
    )


def changes_between(plan: Layout, changed: Layout, origins: Sequence[int]) -> tuple[Change, ...]:
    """Differences between two plans, in the order of loading of the first.

    Args:
        plan: as it was.
        changed: as it is now.
        origins: of every item of ``changed`` the step in ``plan``.
    """
    labels = [label_in(plan.items, step) for step in range(len(plan))]
    steady = set(kept_in_order(origins))
    found = []
    for new_step, step in enumerate(origins):
        was, now = plan.items[step], changed.items[new_step]
        turned = not np.allclose(was.size, now.size, atol=1e-6)
        before, after = "", ""
        if step not in steady:
            earlier = [other for other in origins[:new_step] if other in steady and other > step]
            later = [other for other in origins[new_step + 1 :] if other in steady]
            if earlier:
                after = labels[earlier[-1]]
            elif later:
                before = labels[later[0]]
        one = Change(step, new_step, labels[step], _way(was, now, turned), turned, before, after)
        if one.moved or before or after:
            found.append(one)
    kept = set(origins)
    found += [Change(step, None, labels[step]) for step in range(len(plan)) if step not in kept]
    return tuple(sorted(found, key=lambda change: change.step))


def _way(was: Item, now: Item, turned: bool) -> Vector:
    share = 0.5 if turned else 0.0
    way = [
        round((b + share * t) - (a + share * s), 6) + 0.0
        for a, s, b, t in zip(was.position, was.size, now.position, now.size, strict=True)
    ]
    return (way[0], way[1], way[2])
