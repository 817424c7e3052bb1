"""Does a load hold the accelerations of a rule?"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from steadyload.engines.world import EngineError
from steadyload.errors import required
from steadyload.layouts.model.layout import Layout, require_layout
from steadyload.methods.contract.method import Method
from steadyload.methods.registry import make_method, method_of
from steadyload.methods.simulation.simulation import Simulation
from steadyload.transport.balance import Mode
from steadyload.transport.errors import TransportError
from steadyload.transport.history import History
from steadyload.transport.limits import (
    DISPLACEMENT,
    EXACT,
    ROTATION,
    Limit,
    checked_directions,
    knows_accelerations,
    limits,
)
from steadyload.transport.riding import LoadedWorld
from steadyload.transport.rules import Rule

_EXACT_TO = 1e-6
"""Accuracy of the exact limit [g]: a load that holds a level by no more than that holds it."""


@dataclass(frozen=True)
class Trial:
    """A load under an acceleration in one direction.

    Attributes:
        direction_deg: of the force on the boxes, seen from above.
        level_g: the largest acceleration [g].
        held: no box moves too far; None where there is no answer.
        moved_item: the box that moves too far first, or else furthest.
        displacement_cm, left_cm, rotation_deg: of that box relative to the deck, at most and in the
            end; None for a method that simulates nothing.
        mode: how it moves; None where there is no answer.
        fell: boxes that dropped by more than half their height.
        reason: why there is no answer.
    """

    direction_deg: float
    level_g: float
    held: bool | None
    moved_item: int | None = None
    displacement_cm: float | None = None
    left_cm: float | None = None
    rotation_deg: float | None = None
    mode: Mode | None = None
    fell: tuple[int, ...] = ()
    reason: str = ""


@dataclass(frozen=True)
class RuleAnswer:
    """Whether a load holds what a rule asks.

    Attributes:
        rule: its name.
        method: spec of the method that answers.
        trials: one a direction.
    """

    rule: str
    method: str
    trials: tuple[Trial, ...]

    def __str__(self) -> str:
        if self.held is None:
            return f"whether it holds {self.rule} is not known"
        worst = self.worst
        if worst is None:
            return f"holds {self.rule}"
        box = "" if worst.moved_item is None else f": item {worst.moved_item} {worst.mode}"
        return f"does not hold {self.rule} at {worst.direction_deg:g} degrees{box}"

    @property
    def held(self) -> bool | None:
        """Whether it is held in every direction; None where that is not known."""
        said = [trial.held for trial in self.trials]
        if False in said:
            return False
        return None if None in said else True

    @property
    def worst(self) -> Trial | None:
        """The first trial that was not held, or else that has no answer; None for a load that
        holds.
        """
        if self.held is True:
            return None
        return next(trial for trial in self.trials if trial.held is self.held)


def answer_rule(layout: Layout, rule: Rule, method: str | Method = EXACT) -> RuleAnswer:
    """Whether a load holds a rule, by a method that may know nothing of accelerations.

    Args:
        layout: the load.
        rule: what is asked.
        method: answers itself where :func:`under_rule` takes it; else :data:`EXACT` does.

    Raises:
        SpecError, EngineNotInstalledError: as of :func:`under_rule`.
    """
    judge = method_of(method)
    if not knows_accelerations(judge):
        judge = make_method(EXACT)
    return RuleAnswer(rule.name, str(judge.spec), tuple(under_rule(layout, rule, judge)))


def under_rule(layout: Layout, rule: Rule, method: str | Method = EXACT) -> list[Trial]:
    """Whether a load holds what a rule asks, direction by direction.

    Args:
        layout: the load.
        rule: what is asked.
        method: as of :func:`steadyload.transport.limits.limits`. A simulation puts the load through
            the rule's history; the equilibrium asks whether forces hold its level at all, for ever.

    Raises:
        TransportError, SpecError, EngineNotInstalledError: as of that function.
    """
    judge = method_of(method)
    levels = rule.directions()
    if not isinstance(judge, Simulation):
        found = limits(layout, judge, directions=tuple(levels))
        return [
            Trial(
                one.direction_deg,
                level,
                None if one.limit_g is None else _holds(one, level),
                one.moved_item,
                mode=one.mode,
                reason=one.reason,
            )
            for one, level in zip(found, levels.values(), strict=True)
        ]
    height = float(layout.upper[:, 1].max())
    histories = {direction: rule.history(level) for direction, level in levels.items()}
    displacement = rule.largest_displacement(height)
    return _ridden(layout, judge, histories, displacement, rule.rotation, rule.rest)


def _holds(limit: Limit, level: float) -> bool:
    """Whether a limit that is known allows a level; a load that falls at rest holds nothing."""
    assert limit.limit_g is not None
    return limit.mode != Mode.FALLS and limit.limit_g >= level - _EXACT_TO


def under_history(
    layout: Layout, history: History, directions: Iterable[float], method: str | Method
) -> list[Trial]:
    """Whether a load holds a history in some directions, by a simulation.

    Args:
        layout: the load.
        history: what it is put through.
        directions: [degrees].
        method: a simulation.

    Raises:
        LayoutError: it is no layout.
        TransportError: the method simulates nothing, or the history is none.
        SpecError, EngineNotInstalledError: see :func:`steadyload.methods.registry.make_method`.
    """
    require_layout(layout)
    required("history", history, History, "a History", TransportError)
    judge = method_of(method)
    if not isinstance(judge, Simulation):
        raise TransportError(
            f"method {judge.spec}: knows no time; allowed: a simulation such as label@mujoco"
        )
    histories = dict.fromkeys(checked_directions(directions), history)
    return _ridden(layout, judge, histories, DISPLACEMENT, ROTATION, 0.5)


def _ridden(
    layout: Layout,
    judge: Simulation,
    histories: Mapping[float, History],
    displacement: float,
    rotation: float,
    rest: float,
) -> list[Trial]:
    judge.prepare(len(layout))
    trials = []
    with LoadedWorld(layout, judge.engine, judge.parameters) as world:
        for direction, history in histories.items():
            level = max(history.levels, key=abs)
            try:
                ride = world.ride(
                    history,
                    direction,
                    displacement=displacement,
                    rotation=rotation,
                    rest=rest,
                    whole=True,
                )
            except EngineError as error:
                trials.append(Trial(direction, level, None, reason=str(error)))
                continue
            trials.append(
                Trial(
                    direction,
                    level,
                    ride.held,
                    ride.moved_item,
                    ride.displacement,
                    ride.left,
                    ride.rotation,
                    ride.mode,
                    ride.fell,
                )
            )
    return trials
