"""A box that is crushed, in a sentence."""

from __future__ import annotations

from dataclasses import dataclass

from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.naming import ordinal


@dataclass(frozen=True, slots=True)
class Crushed:
    """A box that bears more than it may.

    Attributes:
        step: placement after which it does.
        item: the box.
        label: its name in a sentence.
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
        """The box and its load, in the unit in which people read weights."""
        bears, allowed = frame.spoken(self.bears_kg), frame.spoken(self.allowed_kg)
        if bears == allowed:
            bears = frame.spoken(self.bears_kg, finely=True)
            allowed = frame.spoken(self.allowed_kg, finely=True)
        allowed = allowed.removesuffix(f" {frame.spoken_weight}")
        placed = f"the {ordinal(self.step + 1)} box"
        return f"crushed when {placed} is placed: {self.label} bears {bears} of {allowed}"

    def __str__(self) -> str:
        return self.sentence(Frame())
