"""Properties of what stands and what falls, by closed forms and by the exact equilibrium."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import strategies as st
from hypothesis.strategies import DrawFn, SearchStrategy

from steadyload.engines.world import GRAVITY
from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.declared import MovementLimits, Trait
from steadyload.methods.envelope import leaves
from steadyload.methods.simulation.simulation import Simulation
from steadyload.methods.simulation.simulation_parameters import BetweenSteps
from steadyload.methods.simulation.trace import Trace, trace_loading
from steadyload.properties.margin_filter import balance_lost
from steadyload.properties.mechanics import tipping_time
from steadyload.properties.property import (
    Case,
    MethodUnderTest,
    Property,
    Violation,
    check_done,
    declaring,
    errors_as_violations,
    spoken,
    steps_between,
)
from steadyload.properties.strategies import (
    Placed,
    built,
    carton_towers,
    density_weight,
    layouts,
    ordinary_layouts,
    overhanging_stacks,
    single_items,
    towers,
    with_offsets,
)
from steadyload.properties.transforms import brought_within, quarter_turned
from steadyload.statics.friction import Sides, unbalanced_item

REST_SHIFT = 0.1
"""How far a corner may creep while its item is at rest [cm], where items are not large."""

REST_SHARE = 0.001
"""The same as a share of the longest side, where that is more: contacts of large items give way."""

REST_ANGLE = 0.5
"""How far an item may turn while it is at rest [degrees]."""

_IN_TIME = 0.67
"""A box clearly past its edge has turned by the threshold in this share of the time it is given."""

_STEEP = 45.0
"""Thresholds up to here follow from the equation of the pendulum [degrees]."""

_STICKING = 2.0
"""Friction on all faces up to this multiple of the given one cannot hold what is clearly out of
balance."""

_FACETS = 8


_TALLEST = 20
"""Boxes of a tower at most, as many as the layouts of the paper have."""


def _towers(tested: MethodUnderTest) -> SearchStrategy[Case]:
    return tested.within_range(towers(most=_TALLEST, planar=tested.planar)).map(Case)


def _carton_towers(tested: MethodUnderTest) -> SearchStrategy[Case]:
    return tested.within_range(carton_towers(most=_TALLEST, planar=tested.planar)).map(Case)


def _items(tested: MethodUnderTest) -> SearchStrategy[Case]:
    plain = single_items(planar=tested.planar)
    shifted = with_offsets(plain, planar=tested.planar)
    return tested.within_range(st.one_of(plain, shifted)).map(Case)


def stands(tested: MethodUnderTest, case: Case) -> bool:
    """The loading is stable, within the declared envelope."""
    return not leaves(case.layout, tested.method) and stands_anywhere(tested, case)


def stands_anywhere(tested: MethodUnderTest, case: Case) -> bool:
    """The loading is stable, whatever was measured of an engine."""
    failing = tested.verdict(case.layout).failing_step
    if failing is not None:
        raise Violation(
            f"{spoken(failing)}; expected: stable", steps=steps_between(case.layout, failing, None)
        )
    return True


@st.composite
def _over_an_edge(draw: DrawFn, tested: MethodUnderTest, least: int, most: int) -> Case:
    """A box on a wider one, its centre of mass past the edge of that by a share of its width."""
    width, height = draw(st.integers(10, 40).map(float)), draw(st.integers(5, 40).map(float))
    percent = draw(st.integers(least, most))
    past = percent / 100.0 * width
    offset = 0.0
    if tested.has(Trait.CENTRES_OF_MASS):
        # 1 cm of contact has to be left.
        fewest = math.ceil(100.0 * (past - 0.5 * width + 1.0) / width)
        most_shift = int(min(40.0, 100.0 * tested.method.layout_range.mass_offset))
        offset = draw(st.integers(max(-most_shift, fewest), most_shift)) / 100.0 * width
    lower, upper = (2.0 * width, math.ceil(0.5 * width), 20.0), (width, height, 20.0)
    boxes = [
        Placed((-lower[0], 0.0, 0.0), lower, density_weight(lower)),
        Placed(
            (past - offset - 0.5 * width, lower[1], 0.0),
            upper,
            density_weight(upper),
            (offset, 0.0, 0.0),
        ),
    ]
    layout = brought_within(built("edge", boxes), tested.method.layout_range)
    scale = layout.items[1].size[1] / height
    turns = draw(st.integers(0, 1)) * 2 if tested.planar else draw(st.integers(0, 3))
    for _ in range(turns):
        layout = quarter_turned(layout)
    return Case(
        layout,
        {
            "past the edge [cm]": scale * past,
            "offset [cm]": scale * offset,
            "width [cm]": scale * width,
        },
    )


def _past(tested: MethodUnderTest) -> SearchStrategy[Case]:
    return _over_an_edge(tested, 10, 40)


def _inside(tested: MethodUnderTest) -> SearchStrategy[Case]:
    return _over_an_edge(tested, -40, -10)


def falls(tested: MethodUnderTest, case: Case) -> bool:
    """The upper of two boxes tips, in good time by the equation of the pendulum."""
    limits = tested.method.movement_limits
    if limits is not None and not _tips_in_time(limits, case):
        return False
    failing = tested.verdict(case.layout).failing_step
    if failing != 1:
        raise Violation(
            f"{spoken(failing)}; expected: {spoken(1)}",
            steps=steps_between(case.layout, failing, 1),
        )
    return True


def _tips_in_time(limits: MovementLimits, case: Case) -> bool:
    if limits.rotation > _STEEP or not limits.gravity:
        return False
    size = (0.01 * case.change["width [cm]"], 0.01 * case.layout.items[1].size[1])
    past = 0.01 * case.change["past the edge [cm]"]
    needed = tipping_time(size, past, math.radians(limits.rotation))
    return needed * math.sqrt(GRAVITY / limits.gravity) <= _IN_TIME * limits.time


def balanced_stays(tested: MethodUnderTest, case: Case) -> bool:
    """A layout that vertical forces balance by a clear margin is stable, and nothing moves."""
    if balance_lost(case.layout) is not None or leaves(case.layout, tested.method, at_rest=True):
        return False
    if not _reseats(tested):
        return stands(tested, case)
    trace = _trace(case.layout, tested)
    shift, angle = trace.corner[:, -1], trace.angle[:, -1]
    longest = float((case.layout.upper - case.layout.lower).max())
    allowed = max(REST_SHIFT, REST_SHARE * longest)
    moving = np.flatnonzero((shift > allowed) | (angle > REST_ANGLE))
    if len(moving):
        step = int(moving[0])
        raise Violation(
            f"item {trace.moved[step, -1]} moves by {shift[step]:.3g} cm or {angle[step]:.3g} "
            f"degrees at step {step}; expected: up to {allowed:g} cm and {REST_ANGLE:g} degrees"
        )
    return True


def unbalanced_moves(tested: MethodUnderTest, case: Case) -> bool:
    """Items that no forces balance, not even friction on side faces, move beyond the tolerance.

    Only the first step that does not balance is tested, and only if all before balance clearly.
    """
    lost = balance_lost(case.layout)
    if lost is None or not lost[1]:
        return False
    step = lost[0]
    friction = _STICKING * tested.method.parameters.friction
    if unbalanced_item(case.layout, step, Sides.FRICTION, friction, _FACETS) is None:
        return False
    layout = case.layout.first(step + 1)
    if leaves(layout, tested.method):
        return False
    trace = _trace(layout, tested)
    shift, angle = float(trace.corner[step].max()), float(trace.angle[step].max())
    if shift <= REST_SHIFT and angle <= REST_ANGLE:
        raise Violation(
            f"nothing moves by more than {shift:.3g} cm and {angle:.3g} degrees at step {step}; "
            "no forces balance it"
        )
    return True


def _trace(layout: Layout, tested: MethodUnderTest) -> Trace:
    assert isinstance(tested.method, Simulation)
    parameters = tested.method.parameters
    with errors_as_violations():
        trace = trace_loading(
            layout, tested.method, t_max=parameters.t_max, samples=parameters.samples
        )
    check_done(trace.status, trace.reason)
    return trace


def _reseats(tested: MethodUnderTest) -> bool:
    return (
        isinstance(tested.method, Simulation)
        and tested.method.parameters.between_steps is BetweenSteps.RESEAT
    )


def _balanced(tested: MethodUnderTest) -> SearchStrategy[Case]:
    return tested.within_range(layouts(planar=tested.planar)).map(Case)


def _often_unbalanced(tested: MethodUnderTest) -> SearchStrategy[Case]:
    """Few ordinary layouts are out of balance clearly, most stacks of drawn shifts are."""
    stacks = overhanging_stacks(planar=tested.planar)
    shifted = with_offsets(stacks, planar=tested.planar)
    drawn = st.one_of(stacks, shifted, ordinary_layouts(planar=tested.planar))
    return tested.within_range(drawn).map(Case)


def _needs_half_a_base(tested: MethodUnderTest) -> bool:
    share = getattr(tested.method.parameters, "alpha", 1.0)
    return not tested.has(Trait.BASE_SUPPORT) or share >= 0.5


PROPERTIES = (
    Property(
        "tower",
        "A tower of centred items, none larger than the one below, is stable within the envelope.",
        _towers,
        stands,
        version=2,
    ),
    Property(
        "carton tower",
        "A tower of up to 20 centred cartons of 20 to 60 cm is stable, whatever the envelope.",
        _carton_towers,
        stands_anywhere,
    ),
    Property("floor", "An item on the floor alone is stable.", _items, stands),
    Property(
        "past the edge",
        "A box whose centre of mass lies past its edge by a tenth of its width or more falls.",
        _past,
        falls,
        _needs_half_a_base,
    ),
    Property(
        "inside the edge",
        "A box whose centre of mass lies inside its edge by a tenth of its width or more stands.",
        _inside,
        stands,
        declaring(Trait.CENTRES_OF_MASS),
    ),
    Property(
        "balanced stays",
        "Where vertical forces balance every step by a clear margin, nothing moves (within the "
        "envelope at rest).",
        _balanced,
        balanced_stays,
        declaring(Trait.BALANCE),
    ),
    Property(
        "unbalanced moves",
        "What not even friction on side faces could hold moves beyond the tolerance of rest.",
        _often_unbalanced,
        unbalanced_moves,
        _reseats,
    ),
)
