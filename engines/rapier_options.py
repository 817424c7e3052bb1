"""Options that only Rapier has."""

from __future__ import annotations

from dataclasses import dataclass

from steadyload.engines.quantities import check_ranges, quantity


@dataclass(frozen=True)
class RapierOptions:
    """How hard contacts are, and at what size a scene is simulated.

    A contact of Rapier is a damped spring that is given by its frequency, whatever it carries: the
    box at the foot of a pile sinks by as much as its load weighs more than it. At Rapier's own 30
    Hz ten cubes sink by 25 mm, at 120 Hz by 1.7 mm; above some 240 Hz a pile falls over at 60
    substeps a second.

    Some lengths within Rapier are fixed numbers, whatever ``length_unit`` is. A wall of cubes of 1
    cm is pushed apart by 3 mm as it is, and by 0.16 mm where it is simulated ten times as large,
    under a gravity ten times as strong, which is the same motion.

    Raises:
        ValueError: a value outside its range.
    """

    contact_frequency: float = quantity(
        120, "natural frequency of a contact", unit="Hz", least=1, most=10000
    )
    length_scale: float = quantity(
        10, "lengths in the engine over those of the scene", least=0.001, most=1000
    )

    def __post_init__(self) -> None:
        check_ranges(self)
