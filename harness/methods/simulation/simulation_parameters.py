"""Parameters of a simulation: those of Table 3 of the paper, and those it leaves open."""

from __future__ import annotations

import dataclasses
import json
import typing
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cache
from types import MappingProxyType
from typing import Any

from steadyload.engines.quantities import quantity
from steadyload.engines.registry import engine_options
from steadyload.engines.world import SETTINGS, BroadPhase, WorldSettings
from steadyload.layouts.model.question import Question
from steadyload.methods.simulation.criteria import Criterion

STILL = 1e-2
"""Items slower than this are at rest at the end of a placement [m/s]; see :class:`Question`."""

OF_STANDS = MappingProxyType({"t_max": 3.0, "samples": 100, "early_exit": 0.0})
"""Values of parameters that come with the question ``stands`` unless others are stated: a look
every 0.03 s, as for a label."""


_MOST_JITTER = 1e-4
"""[m]: as much as two items of a plan may overlap. Beyond it neighbours that touch burst apart."""


class BetweenSteps(StrEnum):
    """State of the items between two placements.

    ``carry``: the state goes on (Algorithm 1 as printed). ``reseat``: every item goes back to its
    planned pose, at rest (the authors' code, and the way their labels were made).
    """

    CARRY = "carry"
    RESEAT = "reseat"


class Scope(StrEnum):
    """Scope of the simulation of a placement.

    ``all``: all that have been placed. ``local``: those joined to the new one by standing on each
    other; items beside them are fixed, as far as a corner can come before the verdict, and the
    others are left out. What is fixed stops others and cannot be pushed over itself: a light stack
    that a heavy neighbour leans on looks firmer than it is. ``widening``: first those joined to the
    new one and nothing else; a placement at which these come to rest by themselves is stable, and
    any other is simulated again with all items. It needs a ``rest_speed``. What it cannot see is a
    push of neighbours that move themselves while all stay within the thresholds: such a step may
    pass here and fail under ``all``, never the other way round. ``moving``: what is out of balance,
    with contact patches drawn in by a ``balance_margin``, and what stands on it; the rest is frozen
    until it is pushed, see :class:`steadyload.methods.simulation.moving.MovingItems`. All but
    ``all`` need ``between_steps=reseat``.
    """

    ALL = "all"
    LOCAL = "local"
    WIDENING = "widening"
    MOVING = "moving"


@dataclass(frozen=True)
class SimulationParameters:
    """Table 3 of the paper and what it leaves open, in its units.

    Raises:
        ValueError: ``t_max`` is shorter than one substep, the scope is not ``all`` without
            reseating, or ``widening`` without a speed of rest, or there is an early exit below the
            threshold, with the criterion ``paper`` or with the question ``stands``.
    """

    t_max: float = quantity(0.3, "simulated time a placement", unit="s", least=1e-6, most=1000)
    frequency: float = quantity(240, "substeps a second", unit="Hz", least=1, most=1e6)
    eps_t: float = quantity(10, "displacement that counts as unstable", unit="cm", least=0)
    eps_r: float = quantity(10, "angle that counts as unstable", unit="deg", least=0)
    friction: float = quantity(0.5, "Coulomb friction of a contact", least=0, most=10)
    restitution: float = quantity(0, "restitution of a contact", least=0, most=1)
    linear_damping: float = quantity(
        0, "share of linear velocity lost a second", least=0, most=0.999999
    )
    angular_damping: float = quantity(
        0, "share of angular velocity lost a second", least=0, most=0.999999
    )
    margin: float = quantity(0, "collision margin", unit="m", least=0, most=1)
    broad_phase: BroadPhase | None = quantity(None, "broad-phase collision detection")
    solver_iterations: int | None = quantity(
        None, "iterations of the contact solver", least=1, most=100_000
    )
    gravity: float = quantity(9.8, "gravitational acceleration", unit="m/s2", least=0, most=1000)
    between_steps: BetweenSteps = quantity(BetweenSteps.CARRY, "state between two placements")
    criterion: Criterion = quantity(Criterion.PAPER, "when an item counts as moved")
    samples: int = quantity(
        10, "looks at the items a placement, the last at its end", least=1, most=100_000
    )
    shrink: float = quantity(
        0, "draw in side faces by this, so that neighbours do not touch", unit="m", least=0, most=1
    )
    jitter: float = quantity(
        0, "displace every item at random by up to this, along every axis", unit="m", least=0,
        most=_MOST_JITTER,
    )  # fmt: skip
    seed: int = quantity(0, "seed of the jitter", least=0, most=2**31)
    rest_speed: float = quantity(
        0, "end a placement when nothing is faster at some samples in a row; 0: never",
        unit="m/s", least=0, most=1000,
    )  # fmt: skip
    rest_samples: int = quantity(
        2, "at so many samples in a row", least=1, most=100_000, later=True
    )
    early_exit: float = quantity(
        0, "criterion adams: end at a sample beyond this multiple of a threshold; 0: never", least=0
    )
    early_stop: float = quantity(
        0, "end a placement as stable when what is to come, as foreseen for each item from how it "
        "moves, is at most this share of what is left to the thresholds; 0: never",
        least=0, most=1, later=True,
    )  # fmt: skip
    scope: Scope = quantity(Scope.ALL, "which items are simulated when one is placed")
    balance_margin: float = quantity(
        0.01, "scope moving: contact patches are drawn in by this on every side where balance is "
        "looked at", unit="cm", least=0, most=10, later=True,
    )  # fmt: skip
    question: Question = quantity(Question.WITHIN, "what is asked of a placement", later=True)
    emulate: frozenset[str] = quantity(
        frozenset(),
        "settings to imitate where an engine can do so only at a price",
        choices=SETTINGS,
    )

    def __post_init__(self) -> None:
        if self.t_max * self.frequency < 1.0 - 1e-9:
            raise ValueError(
                f"t_max times frequency is {self.t_max * self.frequency:g} substeps a placement; "
                "allowed: 1 or more"
            )
        if self.scope is not Scope.ALL and self.between_steps is BetweenSteps.CARRY:
            raise ValueError(f"scope={self.scope} needs between_steps=reseat")
        if self.scope is Scope.WIDENING and not self.rest_speed:
            raise ValueError("scope=widening needs a rest_speed above 0")
        if 0.0 < self.early_exit < 1.0:
            raise ValueError(f"early_exit is {self.early_exit:g}; allowed: 0, or 1 or more")
        if self.early_exit and self.criterion is Criterion.PAPER:
            raise ValueError("early_exit needs criterion=adams: with paper every sample may end it")
        if self.early_exit and self.question == Question.STANDS:
            raise ValueError("early_exit needs question=within: every sample may end the other")

    @property
    def ends_at_rest(self) -> bool:
        """Whether a placement ends where nothing is faster than the speed of rest.

        What tips slowly is not, and falls in the seconds that a load is to stand, so that with
        ``early_stop`` the question ``stands`` does without.
        """
        unsafe = self.early_stop > 0.0 and self.question == Question.STANDS
        return self.rest_speed > 0.0 and not unsafe

    @property
    def any_sample(self) -> bool:
        """Whether what moved too far at any sample ends the loading, not at the last one alone."""
        return self.criterion is Criterion.PAPER or self.question == Question.STANDS

    def world_settings(self) -> WorldSettings:
        """The part of the parameters that a world is made with."""
        shared = {name: getattr(self, name) for name in (*SETTINGS, "emulate")}
        gravity = (0.0, 0.0, -self.gravity)
        return WorldSettings(**shared, gravity=gravity, options=self._options())

    def _options(self) -> object | None:
        return None


@cache
def parameters_on(engine: str) -> type[SimulationParameters]:
    """The parameters of a simulation, and after them those that this engine alone has."""
    options = engine_options(engine)
    if options is None:
        return SimulationParameters
    own, hints = dataclasses.fields(options), typing.get_type_hints(options)

    def make_options(parameters: SimulationParameters) -> object:
        return options(**{f.name: getattr(parameters, f.name) for f in own})

    def check(parameters: SimulationParameters) -> None:
        SimulationParameters.__post_init__(parameters)
        make_options(parameters)

    return dataclasses.make_dataclass(
        f"SimulationParameters_{engine}",
        [(f.name, hints[f.name], field(default=f.default, metadata=f.metadata)) for f in own],
        bases=(SimulationParameters,),
        namespace={"_options": make_options, "__post_init__": check},
        frozen=True,
    )


COMMON = frozenset(own.name for own in dataclasses.fields(SimulationParameters))
"""Parameters that simulations on every engine have."""


def tuning(parameters: Mapping[str, Any]) -> str:
    """The parameters that every engine has, as a text, equal for equally tuned simulations."""
    return json.dumps({k: v for k, v in parameters.items() if k in COMMON}, sort_keys=True)
