"""Declarations of methods: layouts that they judge, and movements that they call unstable."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType

from steadyload.engines.world import GRAVITY
from steadyload.layouts.model.question import Question

_ANY = (0.0, math.inf)


@dataclass(frozen=True, slots=True)
class LayoutRange:
    """Layouts that a method judges; it refuses all others. Without arguments it is every layout.

    Attributes:
        pallet_side: least and greatest longest side of the pallet [cm].
        shortest_side: least and greatest shortest side of an item [cm].
        longest_side: least and greatest longest side of an item [cm].
        weight: least and greatest weight of an item [kg].
        weight_ratio: heaviest item over lightest at most.
        mass_offset: shift of a centre of mass at most, in shares of a side.
        overhang: of an item over the edges of a deck at most [cm].
    """

    pallet_side: tuple[float, float] = _ANY
    shortest_side: tuple[float, float] = _ANY
    longest_side: tuple[float, float] = _ANY
    weight: tuple[float, float] = _ANY
    weight_ratio: float = math.inf
    mass_offset: float = math.inf
    overhang: float = math.inf


EVERY_LAYOUT = LayoutRange()
"""The range of a method that judges whatever is valid."""


@dataclass(frozen=True, slots=True)
class MovementLimits:
    """Movements that make a step fail: further than one of these, and within the time.

    Attributes:
        time: after the placement of an item [s]; infinite where it is judged how all rests.
        displacement: of an item [cm].
        rotation: of an item [degrees].
        gravity: [m/s2].
    """

    time: float
    displacement: float
    rotation: float
    gravity: float = GRAVITY


LABEL_LIMITS: Mapping[Question, MovementLimits] = MappingProxyType(
    {
        Question.WITHIN: MovementLimits(0.3, 10.0, 10.0),
        Question.STANDS: MovementLimits(3.0, 10.0, 10.0),
    }
)
"""Limits of the labels of each question, and so of the methods that were fitted to them."""


class Trait(StrEnum):
    """Trait that a method declares of itself: what concerns a kind of method asks for its trait.

    Properties are tested on methods that declare theirs
    (:func:`steadyload.methods.registry.methods_with` names the methods that declare one).

    ``stepwise``: the verdict on a step depends on the items placed by then alone.
    ``base support``: sees the supported share of bases, and no centre of mass.
    ``centres of mass``: sees where centres of mass lie.
    ``balance``: a loading that balances clearly at every step is stable.
    ``movement``: a step fails by how far items move, compared with thresholds.
    ``learned``: was trained on labels, so that those it learnt from are no test of it.
    """

    STEPWISE = "stepwise"
    BASE_SUPPORT = "base support"
    CENTRES_OF_MASS = "centres of mass"
    BALANCE = "balance"
    MOVEMENT = "movement"
    LEARNED = "learned"
