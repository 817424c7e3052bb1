"""A test of a real stack: what was done to a load that was built by a plan, and what was seen."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from steadyload.escaping import shown
from steadyload.layouts.files.limits import MAX_TEXT_LENGTH
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.naming import label_in
from steadyload.measured.errors import FieldTestError
from steadyload.numbers import number_within

STEEPEST_DEG = 85.0
"""Largest tilt of a test [degrees]."""

STRONGEST_G = 20.0
"""Largest acceleration of a test [g]."""


class Done(StrEnum):
    """The treatment of a load: it is ``placed`` box by box, or the complete load is ``tilted`` or
    ``accelerated``.
    """

    PLACED = "placed"
    TILTED = "tilted"
    ACCELERATED = "accelerated"


TOWARDS = {"right": 0.0, "front": 90.0, "left": 180.0, "back": 270.0}
"""Side that goes down, or that the force on the boxes points to -> direction [degrees]."""

LEVELS = {
    Done.TILTED: ("tilt_deg", "moved_at_deg", STEEPEST_DEG, "degrees"),
    Done.ACCELERATED: ("acceleration_g", "moved_at_g", STRONGEST_G, "g"),
}
"""What is done to a complete load -> fields of how far, and of when a box moved; the most; unit."""

_NUMBERS = ("towards_deg", "tilt_deg", "acceleration_g", "moved_at_deg", "moved_at_g")


@dataclass(frozen=True, kw_only=True)
class FieldTest:
    """A test of a real stack.

    Attributes:
        name: printable, not empty.
        plan: file of the plan, as the table of tests names it.
        layout: the plan.
        done: what was done.
        towards_deg: direction of the force on the boxes, seen from above: 0 along the width, 90
            along the depth; that in which a tilted load slides. None for a load that was placed.
        tilt_deg: largest angle that a tilted load was brought to [degrees].
        acceleration_g: largest acceleration of an accelerated load [g].
        moved: whether a box moved.
        moved_step: step of the box that moved first; None for no box, and where it is not known.
        moved_at_step: step of the box that was being placed when a box moved.
        moved_at_deg: angle at which a box moved [degrees].
        moved_at_g: acceleration at which a box moved [g].
        note: any printable text.

    Raises:
        FieldTestError: a number that is missing, out of range, or of another kind of test; a box
            that the plan does not have, or that moved although nothing was done.
    """

    name: str
    plan: str
    layout: Layout
    done: Done
    towards_deg: float | None = None
    tilt_deg: float | None = None
    acceleration_g: float | None = None
    moved: bool = False
    moved_step: int | None = None
    moved_at_step: int | None = None
    moved_at_deg: float | None = None
    moved_at_g: float | None = None
    note: str = ""

    def __post_init__(self) -> None:
        if not self.name:
            raise FieldTestError("a test has no name; allowed: a printable one")
        try:
            for key in ("name", "plan", "note"):
                text = getattr(self, key)
                if not text.isprintable() or len(text) > MAX_TEXT_LENGTH:
                    raise FieldTestError(
                        f"{key} is {shown(text)}; allowed: a printable text of up to "
                        f"{MAX_TEXT_LENGTH} characters"
                    )
            self._check()
        except FieldTestError as error:
            raise FieldTestError(f"test {shown(self.name)}: {error}") from None

    @property
    def reached(self) -> float | None:
        """How far a complete load was tilted [degrees] or accelerated [g]."""
        return self.tilt_deg if self.done is Done.TILTED else self.acceleration_g

    @property
    def moved_at(self) -> float | None:
        """Angle [degrees] or acceleration [g] at which a box moved."""
        return self.moved_at_deg if self.done is Done.TILTED else self.moved_at_g

    def _check(self) -> None:
        own = LEVELS.get(self.done)
        wanted = () if own is None else ("towards_deg", *own[:2])
        for key in _NUMBERS:
            if key not in wanted and getattr(self, key) is not None:
                raise FieldTestError(
                    f"{key} is {getattr(self, key):g}, and the load was {self.done}; allowed: "
                    "nothing there"
                )
        for key in ("moved_step", "moved_at_step"):
            self._check_step(key)
        if self.moved_step is not None and not self.moved:
            raise FieldTestError("moved_step is stated, and no box moved; allowed: one of the two")
        if own is None:
            self._check_placed()
        else:
            self._check_level(*own)

    def _check_step(self, key: str) -> None:
        step = getattr(self, key)
        if step is not None and not 0 <= step < len(self.layout):
            raise FieldTestError(
                f"{key} is {shown(step)}; allowed: 0 to {len(self.layout) - 1}, the boxes of "
                f"{shown(self.layout.name)}"
            )

    def _check_placed(self) -> None:
        at = self.moved_at_step
        if self.moved != (at is not None):
            raise FieldTestError(
                f"{self._who} moved, and the box that was being placed is missing; allowed: its id "
                "in moved_at_box"
                if self.moved
                else "moved_at_box is stated, and no box moved; allowed: the box that moved in "
                "moved_box, or ? where it is not known"
            )
        if at is not None and self.moved_step is not None and self.moved_step > at:
            raise FieldTestError(
                f"{self._who} moved before it was placed (while {self._box(at)} was); allowed: a "
                "box that was there"
            )

    def _check_level(self, reached: str, moved_at: str, most: float, unit: str) -> None:
        if self.moved_at_step is not None:
            raise FieldTestError(
                f"moved_at_box is stated, and the load was {self.done}; allowed: nothing there"
            )
        how_far, at = getattr(self, reached), getattr(self, moved_at)
        if self.moved and not how_far:
            raise FieldTestError(
                f"{self._who} moved in a test in which nothing was done ({reached} is "
                f"{shown(how_far)}); allowed: how far the load was {self.done} [{unit}]"
            )
        if not how_far or not _number(reached, how_far, most, unit) > 0.0:
            raise FieldTestError(
                f"{reached} is {shown(how_far)}; allowed: a number above 0, up to {most:g} [{unit}]"
            )
        if self.towards_deg is None:
            raise FieldTestError(
                f"towards is missing; allowed: {', '.join(TOWARDS)}, or 0 to 360 [degrees]"
            )
        number_within(
            "towards", self.towards_deg, 0.0, 360.0, unit="[degrees]", error=FieldTestError
        )
        if not self.moved:
            if at is not None:
                raise FieldTestError(
                    f"{moved_at} is {at:g}, and no box moved; allowed: the box that moved in "
                    "moved_box, or ? where it is not known"
                )
            return
        if at is None or not _number(moved_at, at, how_far, unit) > 0.0:
            raise FieldTestError(
                f"{moved_at} is {shown(at)}, and {self._who} moved; allowed: a number above 0, up "
                f"to {reached}, {how_far:g} [{unit}]"
            )

    @property
    def _who(self) -> str:
        return "a box" if self.moved_step is None else self._box(self.moved_step)

    def _box(self, step: int) -> str:
        return label_in(self.layout.items, step)


def _number(name: str, value: object, most: float, unit: str) -> float:
    return number_within(name, value, 0.0, most, unit=f"[{unit}]", error=FieldTestError)
