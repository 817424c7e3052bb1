"""The largest constant acceleration that a load holds, by direction and by method."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from steadyload.engines.registry import world_class
from steadyload.engines.world import EngineError
from steadyload.escaping import shown
from steadyload.layouts.model.layout import Layout, require_layout
from steadyload.methods.contract.method import Method
from steadyload.methods.equilibrium.equilibrium import Equilibrium
from steadyload.methods.registry import method_of
from steadyload.methods.simulation.simulation import Simulation
from steadyload.numbers import number_within
from steadyload.statics.friction import Sides
from steadyload.transport.balance import BalanceProgramme, Mode
from steadyload.transport.errors import TransportError, UnsolvedError
from steadyload.transport.history import LONGEST, trapezoid
from steadyload.transport.riding import LoadedWorld, Ride

EXACT = "equilibrium:sides=frictionless"
"""The method that is asked unless another is named."""

DIRECTIONS = 8
"""Directions around the load, unless others are named."""

RESOLUTION = 0.005
"""Half the width of the interval that a simulated limit is known in [g]."""

HELD = 2.0
"""Time that an acceleration is held in a simulation [s]."""

VERSION = 1
"""Of limits: raised when they change."""

DISPLACEMENT, ROTATION = 5.0, 10.0
"""Largest movement of a box under an acceleration that it holds [cm, degrees]."""


@dataclass(frozen=True)
class Limit:
    """The largest acceleration in one direction.

    Attributes:
        direction_deg: of the force on the boxes, seen from above: 0 along the layout's width, 90
            along its depth.
        limit_g: [g]; 0 for a load that does not stand; None where there is no answer.
        moved_item: the box that moves first beyond it.
        displacement_cm: by how much it had moved when it was found to; None for a method that
            simulates nothing.
        mode: how it moves; None where there is no answer.
        reason: why there is no answer.
        cpu_ms: CPU time of this direction.
    """

    direction_deg: float
    limit_g: float | None
    moved_item: int | None = None
    displacement_cm: float | None = None
    mode: Mode | None = None
    reason: str = ""
    cpu_ms: float = 0.0


def around(count: int) -> tuple[float, ...]:
    """So many directions, evenly around a load [degrees].

    Raises:
        TransportError: fewer than one, or more than 360.
    """
    if not 1 <= count <= 360:
        raise TransportError(f"{shown(count)} directions; allowed: 1 to 360")
    return tuple(360.0 * k / count for k in range(count))


def checked_directions(directions: object) -> tuple[float, ...]:
    """Directions [degrees]: so many evenly around a load, or those that are named.

    Raises:
        TransportError: there are none, or one is no finite number.
    """
    if isinstance(directions, int):
        return around(directions)
    if isinstance(directions, str) or not isinstance(directions, Iterable):
        raise TransportError(
            f"directions is {shown(directions)}; allowed: how many, or numbers [degrees]"
        )
    found = tuple(
        number_within("direction", one, -1e6, 1e6, unit="[degrees]", error=TransportError)
        for one in directions
    )
    if not found:
        raise TransportError("no directions; allowed: one or more")
    return found


def limits(
    layout: Layout,
    method: str | Method = EXACT,
    *,
    directions: int | Sequence[float] = DIRECTIONS,
    rise: float = 0.0,
) -> list[Limit]:
    """The largest constant acceleration that a complete load holds, by direction.

    Args:
        layout: the load.
        method: ``equilibrium`` with friction at its faces, for the exact largest acceleration that
            contact forces balance (an upper bound, see :mod:`steadyload.transport.balance`), or a
            simulation on an engine, such as ``label@mujoco``, of which the parameters of its world,
            the frequency, the friction and the shrink count.
        directions: how many, evenly around the load, or which [degrees].
        rise: time in which a simulated acceleration rises evenly, 0 or more [s]; the equilibrium
            knows no time.

    Raises:
        LayoutError: it is no layout.
        TransportError: no such method, or one that has no friction; such a rise; no directions.
        SpecError, EngineNotInstalledError: see :func:`steadyload.methods.registry.make_method`.
    """
    require_layout(layout)
    chosen = checked_directions(directions)
    rise = number_within("rise", rise, 0.0, LONGEST, unit="[s]", error=TransportError)
    judge = method_of(method)
    if isinstance(judge, Equilibrium):
        return _balanced(layout, judge, chosen)
    if isinstance(judge, Simulation):
        return _simulated(layout, judge, chosen, rise)
    raise TransportError(
        f"method {judge.spec}: does not know friction; allowed: {EXACT}, or a simulation such as "
        "label@mujoco"
    )


def knows_accelerations(method: Method) -> bool:
    """Whether a method can be asked what a load holds: a simulation of three dimensions, or the
    equilibrium with side faces.
    """
    if isinstance(method, Simulation):
        return world_class(method.engine).capabilities.dimensions == 3
    return isinstance(method, Equilibrium) and method.parameters.sides is not Sides.NONE


def _balanced(layout: Layout, judge: Equilibrium, directions: Sequence[float]) -> list[Limit]:
    own = judge.parameters
    if own.sides is Sides.NONE:
        raise TransportError(
            f"method {judge.spec}: has vertical forces alone; allowed: sides=frictionless, or "
            "sides=friction"
        )
    start = time.process_time()
    found = []
    try:
        programme = BalanceProgramme(layout, own.friction, own.sides)
    except UnsolvedError as error:
        return [Limit(direction, None, reason=str(error)) for direction in directions]
    for direction in directions:
        try:
            held = programme.limit(direction)
        except UnsolvedError as error:
            found.append(Limit(direction, None, reason=str(error)))
        else:
            found.append(Limit(direction, held.limit_g, held.moved_item, None, held.mode))
    spent = 1e3 * (time.process_time() - start) / len(directions)
    return [replace(limit, cpu_ms=spent) for limit in found]


def _simulated(
    layout: Layout, judge: Simulation, directions: Sequence[float], rise: float
) -> list[Limit]:
    judge.prepare(len(layout))
    with LoadedWorld(layout, judge.engine, judge.parameters) as world:
        start = time.process_time()
        try:
            rest = _tried(world, 0.0, 0.0, 0.0)
        except EngineError as error:
            return [Limit(direction, None, reason=str(error)) for direction in directions]
        spent = 1e3 * (time.process_time() - start) / len(directions)
        found = [_bisected(world, one, judge.parameters.friction, rise, rest) for one in directions]
    return [replace(limit, cpu_ms=limit.cpu_ms + spent) for limit in found]


def _tried(world: LoadedWorld, level: float, direction: float, rise: float) -> Ride:
    return world.ride(
        trapezoid(level, rise, HELD),
        direction,
        displacement=DISPLACEMENT,
        rotation=ROTATION,
    )


def _bisected(
    world: LoadedWorld, direction: float, friction: float, rise: float, rest: Ride
) -> Limit:
    """The limit between one that is held and one that is not, halved until they are close.

    No load holds more than its friction at the deck. An engine may: some replace the cone of
    friction by a pyramid, which is wider along its edges, by half where it has four.
    """
    start = time.process_time()
    low, high = 0.0, 1.5 * friction + 4.0 * RESOLUTION
    broken = rest
    try:
        if not rest.held:
            high = 0.0
        else:
            broken = _tried(world, high, direction, rise)
            if broken.held:
                low = high
        while high - low > 2.0 * RESOLUTION:
            middle = 0.5 * (low + high)
            tried = _tried(world, middle, direction, rise)
            if tried.held:
                low = middle
            else:
                high, broken = middle, tried
    except EngineError as error:
        return Limit(direction, None, reason=str(error))
    spent = 1e3 * (time.process_time() - start)
    limit = 0.5 * (low + high)
    return Limit(
        direction, limit, broken.moved_item, broken.displacement, broken.mode, cpu_ms=spent
    )
