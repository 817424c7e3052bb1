"""Options that only MuJoCo has."""

from __future__ import annotations

from dataclasses import dataclass

from steadyload.engines.quantities import check_ranges, quantity

_SOFTEST, _HARDEST = 1e-4, 0.9999  # MuJoCo takes what is beyond for these


@dataclass(frozen=True)
class MujocoOptions:
    """Hardness of contacts: MuJoCo's ``solimp``, without the two numbers of the transition's shape.

    A contact is a spring whose force is scaled by its impedance d: of the acceleration that would
    end the penetration it gives the share d, and the load sinks in by some (1 - d) / d of what
    gravity does in the spring's time (MuJoCo documentation, "Solver parameters").

    Raises:
        ValueError: a value outside its range.
    """

    impedance: float = quantity(
        0.95, "of a contact that begins to touch", least=_SOFTEST, most=_HARDEST
    )
    impedance_deep: float = quantity(
        0.99, "of a contact at impedance_depth and deeper", least=_SOFTEST, most=_HARDEST
    )
    impedance_depth: float = quantity(
        0.001, "penetration at which a contact is at its hardest", unit="m", least=1e-9, most=1
    )

    def __post_init__(self) -> None:
        check_ranges(self)
