"""Properties of accelerated loads: what a column of boxes, and any pile, holds on the road.

Asked of methods that find limits of acceleration, see :mod:`steadyload.transport.limits`.
"""

from __future__ import annotations

from hypothesis import strategies as st
from hypothesis.strategies import DrawFn, SearchStrategy

from steadyload.layouts.model.footing import gaps
from steadyload.layouts.model.layout import Layout
from steadyload.properties.mechanics import column_limit
from steadyload.properties.property import (
    Case,
    MethodUnderTest,
    Property,
    Violation,
    errors_as_violations,
)
from steadyload.properties.strategies import columns, ordinary_layouts
from steadyload.transport.limits import knows_accelerations, limits
from steadyload.transport.whole_load import whole_load_limit

_CLEAR = 0.2
"""Share of a limit by which a method may miss it: contacts give way, and motion takes its time."""

_LEAST = 0.25
"""Smallest limit that is asked about [g]: a clear share of it is more than boxes creep by."""

_SHARE = 0.1
"""Share of the cases of other properties: a limit is bisected, by dozens of simulations a case."""

_DIRECTION = "direction [degrees]"


def _directed(layouts: SearchStrategy[Layout]) -> SearchStrategy[Case]:
    """Layouts, and a direction along a side: between sides a pyramid of friction is no cone."""
    directions = st.sampled_from((0.0, 90.0, 180.0, 270.0))

    @st.composite
    def drawn(draw: DrawFn) -> Case:
        return Case(draw(layouts), {_DIRECTION: draw(directions)})

    return drawn()


def _columns(tested: MethodUnderTest) -> SearchStrategy[Case]:
    return _directed(tested.within_range(columns()))


def _piles(tested: MethodUnderTest) -> SearchStrategy[Case]:
    return _directed(tested.within_range(ordinary_layouts()))


def _found(tested: MethodUnderTest, case: Case) -> float:
    """The limit by the method [g].

    Raises:
        Violation: there is none.
    """
    with errors_as_violations():
        (found,) = limits(case.layout, tested.method, directions=(case.change[_DIRECTION],))
    if found.limit_g is None:
        raise Violation(f"no limit: {found.reason}")
    return found.limit_g


def column_holds_its_closed_form(tested: MethodUnderTest, case: Case) -> bool:
    """A column slides or tips at the acceleration of the closed form, up to a clear share."""
    expected = column_limit(case.layout, tested.method.parameters.friction, case.change[_DIRECTION])
    if expected < _LEAST:
        return False
    found = _found(tested, case)
    if abs(found - expected) > _CLEAR * expected:
        raise Violation(f"holds {found:.3g} g; expected: {expected:.3g} g")
    return True


def pile_holds_no_more_than_one_box(tested: MethodUnderTest, case: Case) -> bool:
    """No pile holds clearly more than it would as one box: it would slide, or tip over its edge.

    Not asked of a box with a gap below it: it falls before the pile is accelerated, so that the
    centre of mass is lower than planned.
    """
    if gaps(case.layout):
        return False
    most = whole_load_limit(case.layout, tested.method.parameters.friction, case.change[_DIRECTION])
    if most < _LEAST:
        return False
    found = _found(tested, case)
    if found > (1.0 + _CLEAR) * most:
        raise Violation(f"holds {found:.3g} g; expected: up to {most:.3g} g")
    return True


def _accelerates(tested: MethodUnderTest) -> bool:
    return knows_accelerations(tested.method)


PROPERTIES = (
    Property(
        "accelerated column",
        "A column of boxes on each other slides or tips at the acceleration of the closed form, "
        "up to a fifth of it.",
        _columns,
        column_holds_its_closed_form,
        _accelerates,
        share=_SHARE,
    ),
    Property(
        "accelerated pile",
        "No pile holds an acceleration more than a fifth above that at which it would slide or tip "
        "as one box; piles with a gap below a box are left out.",
        _piles,
        pile_holds_no_more_than_one_box,
        _accelerates,
        version=2,
        share=_SHARE,
    ),
)
