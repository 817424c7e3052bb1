"""Axes and unit in which a message speaks of a layout: those of the file that it was read from."""

from __future__ import annotations

from dataclasses import dataclass

from steadyload.layouts.dialect import UNITS, Dialect

_DECIMALS = {"mm": 0, "cm": 1, "m": 3, "in": 2}
"""Of a length; one more tells 0.1 mm apart, the tolerance."""


@dataclass(frozen=True, slots=True)
class Frame:
    """Names of axes and the unit of lengths in messages; ours unless a file has others.

    Attributes:
        axes: what the file calls our x, y and z.
        unit: of lengths, a key of :data:`steadyload.layouts.dialect.UNITS`.
    """

    axes: tuple[str, str, str] = ("x", "y", "z")
    unit: str = "cm"

    @classmethod
    def of(cls, dialect: Dialect | None) -> Frame:
        """The frame of files of a dialect; None for those of ours."""
        if dialect is None:
            return cls()
        return cls(("y", "z", "x") if dialect.up == "z" else cls().axes, dialect.units)

    def length(self, cm: float, *, finely: bool = False) -> str:
        """A length [cm] with its unit: "4.0 cm", "40 mm"; one that is not 0 never reads 0.

        Args:
            cm: the length [cm].
            finely: to 0.1 mm, where that takes one more decimal: "2.01 cm", "20.1 mm".
        """
        value = cm / float(UNITS[self.unit])
        text = f"{value:.{_DECIMALS[self.unit] + finely}f}"
        if finely:
            text = text.removesuffix("0").removesuffix(".")
        return f"{value:.1g} {self.unit}" if value and not float(text) else f"{text} {self.unit}"
